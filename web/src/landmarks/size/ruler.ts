// A straight length that was measured on the patient, which gives a scan its true size.  Each end is a landmark or mark that is placed,
// or a place that is clicked.
import type { Vector } from "../../api/types";
import { isMark, markCalled, type Picks } from "../picks";

export type Side = "from" | "to";
export type End = string | Vector | null; // a name in the picks, or mm, scan's axes

export interface RulerSlice {
  readonly ruler: Readonly<Record<Side, End>>;
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
