// What is said about a drawing that was carried to the other stance: how sure its place is, honestly.
import type { Laid } from "../drawing/state";

export interface CarriedNote {
  readonly points: number;
  /** points where this scan shows no skin */
  readonly bridged: number;
  /** mm: the radius that holds the true place with 90 %, at half of the points and at the least sure one; null: not known */
  readonly error: { readonly median: number; readonly most: number } | null;
}

export function carriedNote({ shapes }: Pick<Laid, "shapes">): CarriedNote {
  const errors = shapes.flatMap(({ error_mm }) => error_mm ?? []).filter((mm) => mm !== null).sort((a, b) => a - b);
  return {
    points: shapes.reduce((sum, { points }) => sum + points.length, 0),
    bridged: shapes.reduce((sum, { bridged }) => sum + bridged.filter(Boolean).length, 0),
    error: errors.length > 0 ? { median: errors[Math.floor((errors.length - 1) / 2)]!, most: errors.at(-1)! } : null,
  };
}
