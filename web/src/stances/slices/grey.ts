// Grey values of an image in any plane through it: an array of voxels is looked up along the plane, wherever its axes lead.
import { Matrix4, Vector3 } from "three";
import type { Vector } from "../../api/types";
import { type Flat, flat, type View } from "../../drawing/slices/section";

/** Voxels with their place in the scan's frame, mm. */
export interface Grey {
  readonly values: Uint8Array; // i fastest, then j, then k
  readonly shape: readonly [number, number, number];
  readonly toScan: Matrix4; // indices of a voxel's middle to mm
  readonly fromScan: Matrix4;
  readonly step: number; // mm: the shortest side of a voxel
}

/** As the service says it of a scan. */
interface Placed {
  readonly shape: readonly number[];
  readonly to_scan: readonly (readonly number[])[];
}

/** Pixels in a plane, mm in the picture: the first one's outer corner is at the upper left. */
export interface Grid {
  readonly left: number;
  readonly top: number;
  readonly step: number;
  readonly wide: number;
  readonly high: number;
}

const MOST = 640; // pixels along a side

/** null where the bytes are not that many. */
export function greyOf(bytes: ArrayBuffer, { shape, to_scan: rows }: Placed): Grey | null {
  const [i, j, k] = shape as [number, number, number];
  if (bytes.byteLength !== i * j * k) return null;
  const toScan = new Matrix4().set(...(rows.flat() as Parameters<Matrix4["set"]>));
  const step = Math.min(...[0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(toScan, axis).length()));
  return { values: new Uint8Array(bytes), shape: [i, j, k], toScan, fromScan: toScan.clone().invert(), step };
}

/** The pixels that hold all of the image, wherever the plane lies. */
export function gridOf({ shape, toScan, step }: Grey, view: View): Grid {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits): Flat => {
    const index = shape.map((count, axis) => ((bits >> axis) & 1 ? count - 0.5 : -0.5));
    return flat(new Vector3(...index).applyMatrix4(toScan).toArray(), view);
  });
  const [xs, ys] = [corners.map(([x]) => x), corners.map(([, y]) => y)];
  const [left, top] = [Math.min(...xs), Math.max(...ys)];
  const [across, down] = [Math.max(...xs) - left, top - Math.min(...ys)];
  const side = Math.max(step, across / MOST, down / MOST);
  return { left, top, step: side, wide: Math.ceil(across / side), high: Math.ceil(down / side) };
}

/** Into `pixels`, row by row: what the plane at `offset` (mm along `out`) cuts, between voxels in proportion; 0 outside. */
export function resample({ values, shape, fromScan }: Grey, { right, up, out }: View, offset: number, { left, top, step, wide, high }: Grid, pixels: Uint8Array): void {
  const [ni, nj, nk] = shape;
  const m = fromScan.elements;
  const way = ([x, y, z]: Vector, mm: number): Vector => [0, 1, 2].map((row) => mm * (m[row]! * x + m[4 + row]! * y + m[8 + row]! * z)) as unknown as Vector;
  const [across, down] = [way(right, step), way(up, -step)];
  const start = [way(right, left + step / 2), way(up, top - step / 2), way(out, offset), [m[12], m[13], m[14]]].reduce((sum, each) => sum.map((value, k) => value + each[k]!), [0, 0, 0]);
  const [dj, dk] = [ni, ni * nj];
  for (let row = 0, at = 0; row < high; row += 1) {
    let i = start[0]! + row * down[0];
    let j = start[1]! + row * down[1];
    let k = start[2]! + row * down[2];
    for (let column = 0; column < wide; column += 1, at += 1, i += across[0], j += across[1], k += across[2]) {
      if (!(i > -0.5 && j > -0.5 && k > -0.5 && i < ni - 0.5 && j < nj - 0.5 && k < nk - 0.5)) {
        pixels[at] = 0;
        continue;
      }
      // Within half a voxel of the edge the last one goes on.
      const [i0, j0, k0] = [i > 0 ? i | 0 : 0, j > 0 ? j | 0 : 0, k > 0 ? k | 0 : 0];
      const [u, v, w] = [i0 + 1 < ni && i > 0 ? i - i0 : 0, j0 + 1 < nj && j > 0 ? j - j0 : 0, k0 + 1 < nk && k > 0 ? k - k0 : 0];
      const a = i0 + dj * j0 + dk * k0;
      const di = u > 0 ? 1 : 0;
      const b = v > 0 ? a + dj : a;
      const next = w > 0 ? dk : 0;
      const below = (1 - v) * ((1 - u) * values[a]! + u * values[a + di]!) + v * ((1 - u) * values[b]! + u * values[b + di]!);
      const above = (1 - v) * ((1 - u) * values[a + next]! + u * values[a + di + next]!) + v * ((1 - u) * values[b + next]! + u * values[b + di + next]!);
      pixels[at] = (1 - w) * below + w * above + 0.5;
    }
  }
}

/** Which grey values are black and white: the level is the grey between, the window the width of both. */
export interface Window {
  readonly level: number; // of 255
  readonly width: number;
}

export const USUAL: Window = { level: 127.5, width: 255 }; // the service has stretched them already

/** Within what can be seen. */
export const windowed = ({ level, width }: Window): Window => ({ level: Math.min(Math.max(level, 0), 255), width: Math.min(Math.max(width, 5), 510) });

/** Colours of a canvas for each of the 256 values. */
export function shades({ level, width }: Window): Uint32Array {
  return Uint32Array.from({ length: 256 }, (_, value) => {
    const grey = Math.round(Math.min(Math.max((255 * (value - level)) / width + 127.5, 0), 255));
    return 0xff000000 + grey * 0x010101;
  });
}
