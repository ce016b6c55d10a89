// The report's flat rows as a table: one line for each measure, the stances beside each other, changes at the end.  The
// service prints the numbers, so that differences and changes agree with what stands beside them, and with the report.
import type { Measure, MeasuresFile } from "../../api/types";
import { verdictWords } from "../../fit/verdict";
import { stanceLabel } from "../../scan/text";

export interface MeasureLine extends Pick<Measure, "measure" | "label" | "kind" | "unit" | "method"> {
  readonly key: string;
  readonly cells: readonly (Measure | null)[]; // for each of the groups
  readonly landmarks: readonly { readonly stance: string; readonly words: string }[];
}

export interface MeasuresTable {
  /** names of the groups: one stance; or first, second, `second - first` */
  readonly groups: readonly string[];
  readonly lines: readonly MeasureLine[];
}

/** "Supine", "Supine 2": as a heading. */
export const stanceTitle = (name: string): string => name.replace(/^[a-z]+/, stanceLabel);

/** What has to be read before the numbers: the fits that are not simply good, and why; each names its stance. */
export const measuredDoubts = ({ stances, doubts = [] }: Pick<MeasuresFile, "stances"> & Partial<Pick<MeasuresFile, "doubts">>): string[] =>
  doubts.concat(stances.flatMap(({ name, verdict }) => (verdict && verdict.level !== "good" ? [`${stanceTitle(name)}: ${verdictWords({ verdict })}`] : [])));

/** Most lengths are there twice: straight, and along the skin. */
export const measureKey = ({ measure, kind }: Pick<Measure, "measure" | "kind">): string => `${measure}, ${kind}`;

export function measuresTable({ measures, stances }: Pick<MeasuresFile, "measures" | "stances">): MeasuresTable {
  const groups = [...new Set(measures.map(({ stance }) => stance))];
  const lines = [...new Set(measures.map(measureKey))].map((key): MeasureLine => {
    const cells = groups.map((group) => measures.find((row) => measureKey(row) === key && row.stance === group) ?? null);
    const rows = cells.filter((row) => row !== null);
    const { measure, label, kind, unit, method } = rows[0]!;
    const ofStances = rows.filter((row) => row.landmarks !== "" && stances.some(({ name }) => name === row.stance));
    return { key, measure, label, kind, unit, cells, method: rows.findLast((row) => isNamed(row.not_seen))?.method ?? method, landmarks: ofStances.map(({ stance, landmarks }) => ({ stance, words: landmarks })) };
  });
  return { groups, lines };
}

/** Of the cells that a row names as not seen, not known or vague: whether it names this one, or any. */
export const isNamed = (cells = "", column?: string): boolean => (column === undefined ? cells !== "" : cells.split("; ").includes(column));

/** A number with its band, as on the report's pages. */
export const saidOf = (row: Measure | null, column: "left" | "right" | "value" | "difference"): string => (row?.said?.[column] ?? "–").replace("-", "\u2212").replace(" ±", "\u00a0±");
