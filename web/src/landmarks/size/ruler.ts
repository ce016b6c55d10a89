// A straight length that was measured on the patient, which gives a scan its true size.  Each end is a landmark or mark that is placed,
// or a place that is clicked.
import type { Scan, Vector } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import { type History, startHistory } from "../../store/history";
import { isMark, markCalled, markKey, type Picks } from "../picks";
import type { LandmarksSlice } from "../state";

export type Side = "from" | "to";
export type End = string | Vector | null; // a name in the picks, or mm, scan's axes

export interface RulerSlice {
  readonly ruler: Readonly<Record<Side, End>>;
}

export type Scale = NonNullable<Scan["scale"]> | null; // null: the size of the scan's file

export interface SizesSlice {
  /** The sizes that a scan was given here, to go back to: a new size begins the history of its picks anew. */
  readonly sizes: { readonly scan: string; readonly history: History<Scale> } | null;
}

export const initialSizes: SizesSlice = { sizes: null };

/** Of the scan that is shown. */
export function sizesOf({ sizes, scan }: SizesSlice & Pick<ScanSlice, "scan">): History<Scale> {
  const present = scan?.info.scale ?? null;
  return sizes && sizes.scan === scan?.info.id ? { ...sizes.history, present } : startHistory<Scale>(present);
}

type Steps = SizesSlice & Pick<ScanSlice, "scan"> & Pick<LandmarksSlice, "picks">;

/** Whether a size is what undo takes back: picks that were placed since go first. */
export const isSizeLast = (state: Steps): boolean => state.picks.past.length === 0 && sizesOf(state).past.length > 0;
export const isSizeNext = (state: Steps): boolean => state.picks.past.length + state.picks.future.length === 0 && sizesOf(state).future.length > 0;

const SAME_MM = 0.01;

/** Both ends of the length that gave this size, in the size that is shown: by name where that stands there still. */
export function endsOf(scale: NonNullable<Scale>, shown: Scale, picks: Picks): (string | Vector)[] {
  const factor = (shown?.factor ?? 1) / scale.factor;
  return scale.ends.map((end, i) => {
    const place = end.map((value) => factor * value) as unknown as Vector;
    const name = scale.between[i]!;
    const at = picks[name] ?? picks[markKey(name)];
    return at && Math.hypot(...at.map((value, axis) => value - place[axis]!)) < SAME_MM ? name : place;
  });
}

export const initialRuler: RulerSlice = { ruler: { from: null, to: null } };

// While one is clicked it is what the next click places, as a landmark is: no landmark's name begins so.
const RULER = "ruler:";
export const rulerKey = (side: Side): string => RULER + side;
export const isRuler = (name: string): boolean => name.startsWith(RULER);

export const placeOf = (end: End, picks: Picks): Vector | null => (typeof end === "string" ? (picks[end] ?? null) : end);

/** mm in the scan; null until both ends are known. */
export function inScan({ from, to }: RulerSlice["ruler"], picks: Picks): number | null {
  const [start, end] = [placeOf(from, picks), placeOf(to, picks)];
  return start && end ? Math.hypot(...start.map((value, axis) => value - end[axis]!)) : null;
}

/** After the click that places the end which is wanted: then the other one is, where it is open. */
export function withEnd({ ruler }: RulerSlice, wanted: string, point: Vector): RulerSlice & { readonly active: string | null } {
  const side: Side = wanted === rulerKey("from") ? "from" : "to";
  const placed = { ...ruler, [side]: point };
  return { ruler: placed, active: side === "from" && placed.to === null ? rulerKey("to") : null };
}

/** As the service reads it. */
export const sentEnd = (end: string | Vector): string | Vector => (typeof end === "string" && isMark(end) ? markCalled(end) : end);
