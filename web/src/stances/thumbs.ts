// The patient's scans as the strip shows them: by day, the newest first; in each day in the same order, whatever is done.
import { type FitSlice, isUnusable } from "../fit/state";
import { linesOn } from "../fit/verdict";
import type { DrawingSlice } from "../drawing/state";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanVisit } from "../api/types";
import type { ScanSlice } from "../scan/state";
import { isComparing, isPredicted, type PatientScan, stanceOf, type StancesSlice, type Workspace } from "./state";

const ORDER = ["standing", "supine", "prone"] as const;

export interface Thumb {
  readonly id: string; // of the scan; of a predicted body that of the scan it comes from, and "predicted"
  readonly stance: (typeof ORDER)[number];
  readonly isImage: boolean; // an MRI's label map
  readonly isPredicted: boolean;
  readonly at: string; // ISO 8601
  readonly picture: string;
  readonly pane: 1 | 2 | null; // in which it is seen, counted from the left
  readonly mm?: number | null; // line error; null: not known; left out: there is no fit that can be used
  readonly fit: string | null;
  readonly day: string | null; // ISO 8601, of the visit, as a person has said it
  readonly visit: string; // its name
}

export type StripShown = Pick<ScanSlice & LandmarksSlice & FitSlice & DrawingSlice & StancesSlice, "scan" | "active" | "stance" | "fit" | "drawn" | "stances">;

/** On the page as its pane says it, else as the patient's list has it. */
const errorOf = (of: Pick<Workspace, "fit" | "drawn"> | null, fit: PatientScan["fit"]): Thumb["mm"] => {
  if (of) return of.fit?.state === "done" && !isUnusable(of) ? (linesOn(of)?.mm ?? null) : undefined;
  return fit?.state === "done" && fit.verdict !== "unusable" ? fit.line_error_mm : undefined;
};

export function thumbsOf(state: StripShown): Thumb[] {
  const { scan, stances } = state;
  const { other } = stances;
  const both = isComparing(state);
  const mine = scan?.info.id;
  const its = other && !isPredicted(other) ? other.scan?.info.id : undefined;
  const paneOf = (isMain: boolean): Thumb["pane"] => (both ? (isMain === stances.isSecond ? 2 : 1) : isMain ? 1 : null);
  const visitOf = (id: string): ScanVisit | undefined => stances.visits.days?.find(({ scan: of }) => of === id);
  const asThumb = ({ id, stance, created_at, thumbnail, kind, fit }: PatientScan): Thumb => ({
    id,
    stance: id === mine ? stanceOf(state) : other && id === its ? stanceOf(other) : stance,
    isImage: kind === "image",
    isPredicted: false,
    at: created_at,
    picture: thumbnail,
    pane: id === mine ? paneOf(true) : id === its ? paneOf(false) : null,
    mm: errorOf(id === mine ? state : id === its ? other : null, fit),
    fit: (id === mine ? state.fit : id === its ? other!.fit : fit)?.id ?? null,
    day: visitOf(id)?.date ?? null,
    visit: visitOf(id)?.label ?? "",
  });
  const from = stances.scans.find(({ id }) => id === mine);
  const made: Thumb[] = other && from && isPredicted(other) ? [{ ...asThumb(from), id: "predicted", stance: stanceOf(other), isPredicted: true, pane: paneOf(false), mm: errorOf(other, null), fit: null }] : [];
  const placeOf = ({ stance, isImage }: Thumb): number => (isImage ? ORDER.length : ORDER.indexOf(stance));
  return [...stances.scans.map(asThumb), ...made].sort((a, b) => placeOf(a) - placeOf(b) || a.at.localeCompare(b.at));
}

/** The newest day first: of the visit where a person has said it, else the one on which the scan came, as the reader's clock has it. */
export function daysOf<Each extends Thumb>(thumbs: readonly Each[]): (readonly [day: string, thumbs: readonly Each[]])[] {
  const days = new Map<string, Each[]>();
  for (const thumb of thumbs) {
    const day = thumb.day === null ? new Date(thumb.at).toDateString() : `${thumb.day}T12:00`; // noon is that day everywhere
    days.set(day, [...(days.get(day) ?? []), thumb]);
  }
  return [...days].sort(([a], [b]) => new Date(b).getTime() - new Date(a).getTime());
}
