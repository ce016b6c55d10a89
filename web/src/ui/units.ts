// The only place where metres become millimetres, and numbers become text.
import type { Unit } from "../api/types";
import { locale, word } from "../languages/words";

const MM_IN: Record<Unit, number> = { m: 1000, dm: 100, cm: 10, mm: 1, in: 25.4, ft: 304.8 };

export const mmFromMetres = (metres: number): number => metres * 1000;
export const metresFromMm = (mm: number): number => mm / 1000;
export const mmFrom = (value: number, unit: Unit): number => value * MM_IN[unit];
export const toUnit = (mm: number, unit: Unit): number => mm / MM_IN[unit];
export const isUnit = (text: unknown): text is Unit => typeof text === "string" && Object.hasOwn(MM_IN, text);

/** Of a file that names none of these. */
export const unknownUnit = (unit: unknown): string => word("ui.unknownUnit", { unit: typeof unit === "string" ? unit : JSON.stringify(unit) });

const formats = new Map<string, Intl.NumberFormat>();

function format(value: number, most: number, least: number, isGrouped = false): string {
  const key = `${locale()} ${most} ${least} ${isGrouped}`;
  const made = formats.get(key) ?? new Intl.NumberFormat(locale(), { maximumFractionDigits: most, minimumFractionDigits: least, useGrouping: isGrouped, signDisplay: "negative" });
  formats.set(key, made);
  return made.format(value);
}

/** With exactly so many decimals, as the language writes them. */
export const formatFixed = (value: number, digits: number): string => format(value, digits, digits);

/** With as many decimals as it has, at most so many. */
export const formatUpTo = (value: number, digits: number): string => format(value, digits, 0);

/** 61784 → "61,784", in German "61.784". */
export const formatCount = (count: number): string => format(count, 0, 0, true);

const UNKNOWN = "–";

/** Millimetres to one decimal, the most that the scanner and the fit are worth; hundredths below a tenth. */
export function formatMm(mm: number | null | undefined): string {
  if (mm === null || mm === undefined) return UNKNOWN;
  return formatFixed(mm, mm !== 0 && Math.abs(mm) < 0.1 ? 2 : 1);
}

/** −1.2, 0.0, +0.3: with the sign that says on which side. */
export function formatSignedMm(mm: number): string {
  const isZero = Math.abs(mm) < 0.05;
  return `${isZero ? "" : mm < 0 ? "\u2212" : "+"}${formatFixed(isZero ? 0 : Math.abs(mm), 1)}`;
}

export const formatMmWhole = (mm: number): string => formatFixed(mm, 0);

export function formatSeconds(seconds: number | undefined): string {
  if (seconds === undefined) return UNKNOWN;
  return formatFixed(seconds, seconds < 10 ? 2 : 1);
}
export const formatPercent = (share: number): string => formatFixed(100 * share, 0);
export const formatCm = (metres: number): string => formatFixed(metres * 100, 0);
export const formatMegabytes = (bytes: number): string => formatFixed(bytes / 2 ** 20, 0);
