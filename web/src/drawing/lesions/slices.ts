// The service's slices through a lesion: from places of the scan to millimetres in the picture.
import type { LaidLesion } from "./lesions";

export type LesionSlice = LaidLesion["slices"][number];

/** mm to the right and up in a slice that leads from one place to another. */
export const alongSlice = (from: readonly number[], to: readonly number[], { right, up }: LesionSlice): [number, number] => {
  const along = (direction: readonly number[]): number => direction.reduce((sum, each, k) => sum + each * (to[k]! - from[k]!), 0);
  return [along(right), along(up)];
};
