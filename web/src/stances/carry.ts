// What is said about a drawing that was carried to the other stance: how sure its place is, honestly.
import type { CarriedDrawing } from "../api/types";

export interface CarriedNote {
  readonly points: number;
  /** points where the second scan shows no skin */
  readonly bridged: number;
  /** mm that the two fits are off their scans along the lines: mean, and 95 % of the points are nearer */
  readonly from: Spread | null;
  readonly to: Spread | null;
}

export interface Spread {
  readonly mean: number;
  readonly p95: number;
}

function spread(values: readonly (number | null)[]): Spread | null {
  const known = values.filter((value) => value !== null).map(Math.abs).sort((a, b) => a - b);
  if (known.length === 0) return null;
  const at = 0.95 * (known.length - 1);
  const [low, high] = [known[Math.floor(at)]!, known[Math.ceil(at)]!];
  return { mean: known.reduce((sum, value) => sum + value, 0) / known.length, p95: low + (at - Math.floor(at)) * (high - low) };
}

export function carriedNote(drawing: CarriedDrawing): CarriedNote {
  return {
    points: drawing.shapes.reduce((sum, { points }) => sum + points.length, 0),
    bridged: drawing.shapes.reduce((sum, { bridged }) => sum + bridged.filter(Boolean).length, 0),
    from: spread(drawing.shapes.flatMap(({ distance_from_mm }) => distance_from_mm)),
    to: spread(drawing.shapes.flatMap(({ distance_to_mm }) => distance_to_mm)),
  };
}
