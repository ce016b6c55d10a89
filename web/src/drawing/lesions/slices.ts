// Slices through a lesion: from millimetres in the picture to places of the scan, and back.
import type { Vector } from "../../api/types";
import type { LaidLesion } from "./lesions";

export type LesionSlice = LaidLesion["slices"][number];

/** mm: moved in a slice by so much to the right and up. */
export const movedInSlice = (center: Vector, { right, up }: LesionSlice, [x, y]: readonly [number, number]): Vector =>
  center.map((value, k) => Math.round(10 * (value + x * right[k]! + y * up[k]!)) / 10) as Vector;

/** mm to the right and up in a slice that leads from one place to another. */
export const alongSlice = (from: readonly number[], to: readonly number[], { right, up }: LesionSlice): [number, number] => {
  const along = (direction: readonly number[]): number => direction.reduce((sum, each, k) => sum + each * (to[k]! - from[k]!), 0);
  return [along(right), along(up)];
};
