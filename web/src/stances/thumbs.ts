// The patient's scans as the strip shows them: by day, the newest first; in each day in the same order, whatever is done.
import type { FitSlice } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanSlice } from "../scan/state";
import { isComparing, isPredicted, type PatientScan, stanceOf, type StancesSlice } from "./state";

const ORDER = ["standing", "supine", "prone"] as const;

export interface Thumb {
  readonly id: string; // of the scan; of a predicted body that of the scan it comes from, and "predicted"
  readonly stance: (typeof ORDER)[number];
  readonly isImage: boolean; // an MRI's label map
  readonly isPredicted: boolean;
  readonly at: string; // ISO 8601
  readonly picture: string;
  readonly pane: 1 | 2 | null; // in which it is seen, counted from the left
}

export type StripShown = Pick<ScanSlice & LandmarksSlice & FitSlice & StancesSlice, "scan" | "active" | "stance" | "fit" | "stances">;

export function thumbsOf(state: StripShown): Thumb[] {
  const { scan, stances } = state;
  const { other } = stances;
  const both = isComparing(state);
  const mine = scan?.info.id;
  const its = other && !isPredicted(other) ? other.scan?.info.id : undefined;
  const paneOf = (isMain: boolean): Thumb["pane"] => (both ? (isMain === stances.isSecond ? 2 : 1) : isMain ? 1 : null);
  const asThumb = ({ id, stance, created_at, thumbnail, kind }: PatientScan): Thumb => ({
    id,
    stance: id === mine ? stanceOf(state) : other && id === its ? stanceOf(other) : stance,
    isImage: kind === "image",
    isPredicted: false,
    at: created_at,
    picture: thumbnail,
    pane: id === mine ? paneOf(true) : id === its ? paneOf(false) : null,
  });
  const from = stances.scans.find(({ id }) => id === mine);
  const made: Thumb[] = other && from && isPredicted(other) ? [{ ...asThumb(from), id: "predicted", stance: stanceOf(other), isPredicted: true, pane: paneOf(false) }] : [];
  const placeOf = ({ stance, isImage }: Thumb): number => (isImage ? ORDER.length : ORDER.indexOf(stance));
  return [...stances.scans.map(asThumb), ...made].sort((a, b) => placeOf(a) - placeOf(b) || a.at.localeCompare(b.at));
}

/** The newest day first; a day as the reader's clock has it. */
export function daysOf(thumbs: readonly Thumb[]): (readonly [day: string, thumbs: readonly Thumb[]])[] {
  const days = new Map<string, Thumb[]>();
  for (const thumb of thumbs) {
    const day = new Date(thumb.at).toDateString();
    days.set(day, [...(days.get(day) ?? []), thumb]);
  }
  return [...days].sort(([a], [b]) => new Date(b).getTime() - new Date(a).getTime());
}
