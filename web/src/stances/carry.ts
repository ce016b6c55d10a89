// What is said about a drawing that was carried to the other stance: how sure its place is, honestly.
import type { Laid } from "../drawing/state";
import { lineErrorOf } from "../fit/verdict";

export interface CarriedNote {
  readonly points: number;
  /** points where this scan shows no skin */
  readonly bridged: number;
  /** mm: the service's line error (90 %) of the line of which least is known; null: not known */
  readonly error: number | null;
}

export function carriedNote({ shapes }: Pick<Laid, "shapes">): CarriedNote {
  return {
    points: shapes.reduce((sum, { points }) => sum + points.length, 0),
    bridged: shapes.reduce((sum, { bridged }) => sum + bridged.filter(Boolean).length, 0),
    error: lineErrorOf(shapes),
  };
}
