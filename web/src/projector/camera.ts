// A projection as a 3 x 4 matrix: what stands where in a picture.  Points are millimetres in the scan's own axes, places are
// pixels of the page, x to the right and y downwards.  The third number of a projected point grows away from the eye.
import type { Frame, Vector } from "../api/types";
import { cross, dot, leftOf } from "../viewer/frame";

/** Row by row. */
export type Camera = readonly number[];
export type Place = readonly [x: number, y: number];

export function project(camera: Camera, [x, y, z]: Vector): { readonly at: Place; readonly depth: number } {
  const row = (i: number): number => camera[4 * i]! * x + camera[4 * i + 1]! * y + camera[4 * i + 2]! * z + camera[4 * i + 3]!;
  const depth = row(2);
  return { at: [row(0) / depth, row(1) / depth], depth };
}

const rowOf = (camera: Camera, i: number): Vector => [camera[4 * i]!, camera[4 * i + 1]!, camera[4 * i + 2]!];

/** The determinant of the left 3 x 3 block: below zero where the picture is mirrored, zero where the eye is infinitely far away. */
export const handedness = (camera: Camera): number => dot(rowOf(camera, 0), cross(rowOf(camera, 1), rowOf(camera, 2)));

/** Solves M x = right for the left block M, by Cramer's rule. */
function solve(camera: Camera, right: Vector): Vector {
  const [a, b, c] = [rowOf(camera, 0), rowOf(camera, 1), rowOf(camera, 2)];
  const columns = [cross(b, c), cross(c, a), cross(a, b)]; // of the adjugate
  const whole = handedness(camera);
  return [0, 1, 2].map((i) => (columns[0]![i]! * right[0] + columns[1]![i]! * right[1] + columns[2]![i]! * right[2]) / whole) as Vector;
}

/** Where all lines of sight meet; null where they are parallel. */
export function eyeOf(camera: Camera): Vector | null {
  if (isParallel(camera)) return null;
  return solve(camera, [-camera[3]!, -camera[7]!, -camera[11]!]);
}

const isParallel = (camera: Camera): boolean => camera[8] === 0 && camera[9] === 0 && camera[10] === 0;

const unit = (v: Vector): Vector => {
  const length = Math.hypot(...v);
  return [v[0] / length, v[1] / length, v[2] / length];
};

/** Unit vector from a point to the eye. */
export function towardsEye(camera: Camera, point: Vector): Vector {
  const eye = eyeOf(camera);
  if (eye) return unit([eye[0] - point[0], eye[1] - point[1], eye[2] - point[2]]);
  return unit(cross(rowOf(camera, 0), rowOf(camera, 1)).map((value) => -value) as Vector); // right x down is away from the eye
}

/** How far a point lies beside the line of sight of a place, mm. */
export function besideSight(camera: Camera, point: Vector, [x, y]: Place): number {
  const eye = eyeOf(camera);
  if (!eye) throw new Error("parallel lines of sight start nowhere");
  const along = unit(solve(camera, [x, y, 1]));
  const to: Vector = [point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]];
  return Math.hypot(...cross(to, along));
}

export type Side = "front" | "left" | "right";

/** As from infinitely far away: `middle` (mm) stands at `at`, and a millimetre is `pixels` long whatever its depth. */
export function parallelCamera(frame: Frame, side: Side, pixels: number, middle: Vector, at: Place): Camera {
  const left = leftOf(frame);
  const front = frame.front;
  const negated = (v: Vector): Vector => [-v[0], -v[1], -v[2]];
  const right = side === "front" ? left : side === "left" ? negated(front) : front; // on the screen
  const row = (direction: Vector, origin: number): number[] => {
    const scaled = direction.map((value) => value * pixels) as Vector;
    return [...scaled, origin - dot(scaled, middle)];
  };
  return [...row(right, at[0]), ...row(negated(frame.up), at[1]), 0, 0, 0, 1];
}
