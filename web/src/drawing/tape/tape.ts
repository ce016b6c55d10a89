// A tape measure along the skin: from click to click, read off and put away; nothing of it is saved.
import type { Vector } from "../../api/types";
import { gap, lengthOf } from "../lines/lines";
import type { Skin } from "../lines/skin";
import { BRIDGE_MM, leadsOver, way } from "../lines/strokes";

/** From one click to the next. */
export interface TapeLeg {
  readonly points: readonly Vector[]; // on the skin, mm in the scan's own axes
  readonly mm: number | null; // along the skin, straight over holes; null: the service is asked, which measures on the fitted skin
  readonly hasHole: boolean;
}

export interface Tape {
  readonly places: readonly Vector[];
  readonly legs: readonly TapeLeg[]; // one fewer
  readonly isEnded: boolean; // the next click begins another one
  readonly isRefused: boolean; // the last click was where no skin leads
}

export const tapeFrom = (at: Vector): Tape => ({ places: [at], legs: [], isEnded: false, isRefused: false });

/** On to the next place, if skin leads there. */
export function tapeTo(skin: Skin, tape: Tape, to: Vector): Tape {
  const from = tape.places.at(-1)!;
  if (!leadsOver(skin, from, to)) return { ...tape, isRefused: true };
  const points = way(skin, from, to);
  const hasHole = points.some((point, i) => i > 0 && gap(points[i - 1]!, point) > BRIDGE_MM);
  return { ...tape, isRefused: false, places: [...tape.places, to], legs: [...tape.legs, { points, mm: lengthOf({ points, closed: false }), hasHole }] };
}

/** Without its last place; null when nothing is left. */
export const tapeBack = (tape: Tape): Tape | null => (tape.places.length < 2 ? null : { places: tape.places.slice(0, -1), legs: tape.legs.slice(0, -1), isEnded: false, isRefused: false });

/** The same with its last leg as the service measures it, once it has answered. */
export const tapeAsked = (tape: Tape): Tape => ({ ...tape, legs: tape.legs.map((leg, i) => (i === tape.legs.length - 1 ? { ...leg, mm: null } : leg)) });

export const tapeMeasured = (tape: Tape, asked: TapeLeg, { mm, points }: { readonly mm: number; readonly points: readonly Vector[] }): Tape => ({
  ...tape,
  legs: tape.legs.map((leg) => (leg === asked ? { points, mm, hasHole: false } : leg)),
});

/** All legs together, mm; null while one is being measured. */
export const tapeLength = ({ legs }: Tape): number | null => legs.reduce<number | null>((sum, { mm }) => (sum === null || mm === null ? null : sum + mm), 0);

export const tapeHasHole = ({ legs }: Tape): boolean => legs.some(({ hasHole }) => hasHole);
