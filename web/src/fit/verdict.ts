// How far a fit may be trusted, in words: the service's own verdict, before any number.
import type { DrawingFile, Result } from "../api/types";
import { formatMmWhole } from "../ui/units";
import * as text from "./text";

const words = text.numbers;
export const KNOWN_MM = 60; // a larger radius is that of a breast or more: nothing is known of the place, as the service says

/** "± 6 mm", of a radius that holds nine of ten places. */
export const marginOf = (mm: number): string => (mm > KNOWN_MM ? words.unknown : `±\u00a0${formatMmWhole(mm)}\u00a0mm`);

type Drawn = readonly (Pick<DrawingFile["shapes"][number], "line_error_mm"> & { readonly kind?: string })[];

/** mm: the service's line error (90 %) of the line of which least is known, a lesion inside the body being none; null where none is known. */
export function lineErrorOf(shapes: Drawn): number | null {
  const known = shapes.flatMap(({ line_error_mm: mm, kind }) => (kind === "lesion" ? [] : (mm ?? [])));
  return known.length === 0 ? null : Math.max(...known);
}

export interface WithLines {
  readonly fit: { readonly result: Pick<Result, "line_error_mm"> | null; readonly drawing: DrawingFile | null } | null;
  readonly drawn: { readonly onScan: { readonly plan: { readonly shapes: Drawn } } | null };
}

/** Without what is said of the width of lines. */
export const otherReasons = ({ verdict }: Pick<Result, "verdict">): string[] => (verdict?.reasons ?? []).filter((_, i) => verdict?.about?.[i] !== "lines");

/** Whether a length that was measured on the patient would answer a reason. */
export const asksForLength = ({ verdict }: Pick<Result, "verdict">): boolean => verdict?.about?.includes("size") ?? false;

/** How far off lines may be, across them: those that are drawn on this scan, else any on the breasts; null: not known. */
export function linesOn({ fit, drawn }: WithLines): { readonly mm: number; readonly of: string } | null {
  const mm = lineErrorOf(drawn.onScan?.plan.shapes ?? fit?.drawing?.shapes ?? []);
  if (mm !== null && fit?.result) return { mm, of: words.drawnLines };
  return fit?.result?.line_error_mm == null ? null : { mm: fit.result.line_error_mm, of: words.lines };
}

/** good where a result of an older version has no verdict, so that nothing is called doubtful without a reason. */
export const levelOf = (result: Pick<Result, "verdict"> | null | undefined): NonNullable<Result["verdict"]>["level"] => result?.verdict?.level ?? "good";

/** The scan did not show clearly how the patient stands or lies: the fit has guessed, and asks. */
export const isStanceAsked = (result: Pick<Result, "stance_asked"> | null | undefined): boolean => result?.stance_asked ?? false;

/** In one line, for those who listen. */
export const verdictWords = ({ verdict }: Pick<Result, "verdict">): string => (verdict ? [`${words.verdicts[verdict.level]}.`, ...verdict.reasons].join(" ") : "");
