// The report's flat rows as a table: one line for each measure, the stances beside each other, changes at the end.
import type { Measure, MeasuresFile } from "../../api/types";
import { verdictWords } from "../../fit/verdict";

export interface Cell {
  readonly value: number | null;
  readonly low: number | null;
  readonly high: number | null;
}

export interface MeasureLine {
  readonly key: string;
  readonly measure: string;
  readonly label: string;
  readonly kind: string;
  readonly unit: Measure["unit"];
  readonly step: number; // in which its numbers are shown
  /** for each stance and then the change: the cells that the columns name */
  readonly groups: readonly { readonly left: Cell; readonly right: Cell; readonly difference: Cell; readonly whole: Cell; readonly notSeen: readonly string[]; readonly notKnown: readonly string[]; readonly vague: readonly string[] }[];
  readonly method: string;
  readonly landmarks: readonly { readonly stance: string; readonly words: string }[];
}

export interface MeasuresTable {
  /** names of the groups: one stance; or first, second, `second - first` */
  readonly groups: readonly string[];
  readonly lines: readonly MeasureLine[];
}

/** What has to be read before the numbers: the fits that are not simply good, and why; each names its stance. */
export const measuredDoubts = ({ stances, doubts = [] }: Pick<MeasuresFile, "stances"> & Partial<Pick<MeasuresFile, "doubts">>): string[] =>
  doubts.concat(stances.flatMap(({ name, verdict }) => (verdict && verdict.level !== "good" ? [`${name.charAt(0).toUpperCase()}${name.slice(1)}: ${verdictWords({ verdict })}`] : [])));

const NONE: Cell = { value: null, low: null, high: null };

/** The larger side of the band; null where none is known. */
const marginOf = ({ value, low, high }: Cell): number | null => (value === null || low === null || high === null ? null : Math.max(high - value, value - low));

/** Left less right as they are shown, where `given` is a number, with its band: what both are wrong by they share in part. */
function differenceOf(given: Cell, left: Cell, right: Cell): Cell {
  const half = marginOf(given);
  const value = given.value === null || left.value === null || right.value === null ? null : left.value - right.value;
  if (value === null || half === null) return { value, low: null, high: null };
  return { value, low: value - half, high: value + half };
}


/** Most lengths are there twice: straight, and along the skin. */
export const measureKey = ({ measure, kind }: Pick<Measure, "measure" | "kind">): string => `${measure}, ${kind}`;

/** As it is shown, with as wide a band: differences and changes of such cells agree with what stands beside them. */
function shown({ value, low, high }: Cell, step: number): Cell {
  if (value === null) return { value, low, high };
  const now = Math.round(value / step) * step;
  return { value: now, low: low === null ? null : low + now - value, high: high === null ? null : high + now - value };
}

/** `to` less `from` where both are there, with the band of `of`. */
function changed(of: Cell, from: Cell | undefined, to: Cell | undefined): Cell {
  if (of.value === null || from?.value == null || to?.value == null) return of;
  const value = to.value - from.value;
  return { value, low: of.low === null ? null : of.low + value - of.value, high: of.high === null ? null : of.high + value - of.value };
}

const givenDifference = (row: Measure | null | undefined): Cell => ({ value: row?.difference ?? null, low: row?.difference_low ?? null, high: row?.difference_high ?? null });

const named = (cells: string | undefined): string[] => (cells ?? "").split("; ");

export function measuresTable(file: Pick<MeasuresFile, "measures" | "stances">): MeasuresTable {
  const groups = [...new Set(file.measures.map(({ stance }) => stance))];
  const lines = [...new Set(file.measures.map(measureKey))].map((key): MeasureLine => {
    const rows = groups.map((group) => file.measures.find((row) => measureKey(row) === key && row.stance === group) ?? null);
    const first = rows.find((row) => row !== null)!;
    const step = first.unit === "grade" ? 1 : (first.printed_step ?? STEPS[first.unit][0]);
    const cells = rows.map((row) => ({
      left: row ? { value: row.left, low: row.left_low, high: row.left_high } : NONE,
      right: row ? { value: row.right, low: row.right_low, high: row.right_high } : NONE,
      whole: row ? { value: row.value, low: row.value_low, high: row.value_high } : NONE,
    }));
    const ofStances = cells.slice(0, Math.max(file.stances.length, 1)).map((cell) => ({ left: shown(cell.left, step), right: shown(cell.right, step), whole: shown(cell.whole, step) }));
    const all = cells.map((cell, i) => {
      if (ofStances[i]) return ofStances[i];
      const [from, to] = ofStances;
      return { left: changed(cell.left, from?.left, to?.left), right: changed(cell.right, from?.right, to?.right), whole: changed(cell.whole, from?.whole, to?.whole) };
    });
    return {
      key,
      measure: first.measure,
      label: first.label,
      kind: first.kind,
      unit: first.unit,
      step,
      groups: all.map((cell, i) => ({ ...cell, difference: differenceOf(givenDifference(rows[i]), cell.left, cell.right), notSeen: named(rows[i]?.not_seen), notKnown: named(rows[i]?.not_known), vague: named(rows[i]?.vague) })),
      method: rows.findLast((row) => row !== null && (row.not_seen ?? "") !== "")?.method ?? first.method,
      landmarks: rows.flatMap((row) => (row && row.landmarks !== "" && file.stances.some(({ name }) => name === row.stance) ? [{ stance: row.stance, words: row.landmarks }] : [])),
    };
  });
  return { groups, lines };
}

const STEPS: Record<Exclude<Measure["unit"], "grade">, readonly [least: number, most: number]> = { mm: [0.1, 1], ml: [1, 10], "1": [0.01, 0.1] };
const GRADES = ["none", "I", "II", "III", "glandular"]; // of ptosis, by number

/** In which steps a number is written, as in the report: no finer than a tenth of its band. */
function stepOf(margin: number | null, unit: Exclude<Measure["unit"], "grade">): number {
  const [least, most] = STEPS[unit];
  return margin === null || margin === 0 ? least : Math.min(Math.max(10 ** Math.floor(Math.log10(0.5 * margin)), least), most);
}

const rounded = (value: number, step: number): string => (Math.round(value / step) * step).toFixed(Math.max(0, Math.round(-Math.log10(step))));

/** In steps of `step`, else as finely as its band allows; changes and differences with their sign. */
export function formatCell(cell: Cell, unit: Measure["unit"], isSigned: boolean, step?: number): string {
  const { value } = cell;
  if (value === null) return "–";
  if (unit === "grade") return GRADES[value] ?? "–";
  const digits = rounded(Math.abs(value), step ?? stepOf(marginOf(cell), unit));
  const isZero = Number(digits) === 0;
  const sign = value < 0 && !isZero ? "\u2212" : isSigned && !isZero ? "+" : "";
  return sign + digits;
}

/** " ±5", to stand behind the number; nothing where no band is known. */
export function formatMargin(cell: Cell, unit: Measure["unit"]): string {
  const margin = marginOf(cell);
  return margin === null || unit === "grade" ? "" : `\u00a0±${rounded(margin, stepOf(margin, unit))}`;
}

const COLUMNS = ["stance", "measure", "kind", "unit", "left", "left_low", "left_high", "right", "right_low", "right_high", "difference", "difference_low", "difference_high", "value", "value_low", "value_high", "not_seen", "not_known", "vague", "landmarks", "method"] as const satisfies readonly (keyof Measure)[];

const quoted = (cell: string): string => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

const LEVELS = ["", "good", "uncalibrated", "check", "unusable"]; // none in results of earlier versions

/**
 * The same columns as the command line's measures.csv, every digit that the service sent.  The verdict of its fit is in
 * each row, for a table is read without its report; a change is as good as the worse of both.
 */
export function measuresCsv({ measures, stances }: Pick<MeasuresFile, "measures" | "stances">): string {
  const verdicts = new Map(stances.map(({ name, verdict }) => [name, verdict?.level ?? ""]));
  const worst = LEVELS.findLast((level) => [...verdicts.values()].some((each) => each === level)) ?? "";
  const written = measures.map((row) => [...COLUMNS.map((name) => quoted(String(row[name] ?? ""))), verdicts.get(row.stance) ?? worst].join(","));
  return [[...COLUMNS, "verdict"].join(","), ...written].join("\r\n") + "\r\n";
}
