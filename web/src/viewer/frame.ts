// Which way the body faces, in the scan's own axes: `up` to the head, `front` out of the chest.
// The patient's left is up × front.  Turning by 90 degrees only swaps these axes, so nothing drifts.
import type { Frame, Vector } from "../api/types";

export type Turn = "around" | "sideways" | "forwards";

export const negative = (v: Vector): Vector => [0 - v[0], 0 - v[1], 0 - v[2]];

export function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function unit(v: Vector): Vector | null {
  const length = Math.hypot(...v);
  return length > 1e-9 ? [v[0] / length, v[1] / length, v[2] / length] : null;
}

/** Up and front as exact unit vectors at a right angle; +Y and +Z where they say nothing usable. */
export function tidyFrame(frame: Frame): Frame {
  const up = unit(frame.up) ?? [0, 1, 0];
  const left = unit(cross(up, frame.front)) ?? unit(cross(up, [0, 0, 1])) ?? [1, 0, 0];
  return { up, front: cross(left, up) };
}

export const leftOf = (frame: Frame): Vector => cross(frame.up, frame.front);

/** Degrees of the turn from one frame to the other. */
export function angleBetween(a: Frame, b: Frame): number {
  const trace = dot(a.up, b.up) + dot(a.front, b.front) + dot(leftOf(a), leftOf(b));
  return (Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2))) * 180) / Math.PI;
}

/** The same frame after the body was turned by 90 degrees before the viewer's eyes. */
export function turned(frame: Frame, turn: Turn): Frame {
  const left = leftOf(frame);
  if (turn === "around") return { up: frame.up, front: negative(left) }; // about its long axis
  if (turn === "sideways") return { up: left, front: frame.front }; // in the plane of the picture
  return { up: frame.front, front: negative(frame.up) }; // over its own feet
}

/** Width, height and depth as one frame has them, of what was measured along the axes of another: whole turns exchange them. */
export function sizeIn(frame: Frame, measured: Frame, [width, height, depth]: readonly number[]): [number, number, number] {
  const parts: [Vector, number][] = [[leftOf(measured), width!], [measured.up, height!], [measured.front, depth!]];
  const along = (axis: Vector): number => parts.reduce((best, part) => (Math.abs(dot(part[0], axis)) > Math.abs(dot(best[0], axis)) ? part : best))[1];
  return [along(leftOf(frame)), along(frame.up), along(frame.front)];
}
