// The only place where metres become millimetres, and numbers become text.
import type { Unit } from "../api/types";

const MM_IN: Record<Unit, number> = { m: 1000, dm: 100, cm: 10, mm: 1, in: 25.4, ft: 304.8 };

export const mmFromMetres = (metres: number): number => metres * 1000;
export const metresFromMm = (mm: number): number => mm / 1000;
export const mmFrom = (value: number, unit: Unit): number => value * MM_IN[unit];
export const toUnit = (mm: number, unit: Unit): number => mm / MM_IN[unit];
export const isUnit = (text: unknown): text is Unit => typeof text === "string" && Object.hasOwn(MM_IN, text);

/** Of a file that names none of these. */
export const unknownUnit = (unit: unknown): string => `The unit “${typeof unit === "string" ? unit : JSON.stringify(unit)}” is not known: use m, dm, cm, mm, in or ft.`;

const grouped = new Intl.NumberFormat("en-GB");

/** 61784 → "61,784". */
export const formatCount = (count: number): string => grouped.format(count);

const UNKNOWN = "–";

/** Millimetres to one decimal, the most that the scanner and the fit are worth; hundredths below a tenth. */
export function formatMm(mm: number | null | undefined): string {
  if (mm === null || mm === undefined) return UNKNOWN;
  return mm !== 0 && Math.abs(mm) < 0.1 ? mm.toFixed(2) : mm.toFixed(1);
}

/** −1.2, 0.0, +0.3: with the sign that says on which side. */
export function formatSignedMm(mm: number): string {
  const digits = Math.abs(mm).toFixed(1);
  return digits === "0.0" ? digits : `${mm < 0 ? "\u2212" : "+"}${digits}`;
}

export const formatMmWhole = (mm: number): string => mm.toFixed(0);

export function formatSeconds(seconds: number | undefined): string {
  if (seconds === undefined) return UNKNOWN;
  return seconds < 10 ? seconds.toFixed(2) : seconds.toFixed(1);
}
export const formatPercent = (share: number): string => (100 * share).toFixed(0);
export const formatCm = (metres: number): string => (metres * 100).toFixed(0);
export const formatMegabytes = (bytes: number): string => (bytes / 2 ** 20).toFixed(0);
