// The skin around a line within which its true place lies with 90 %: triangles of the skin, cut finer, each corner with
// its distance to the line as a share of the error there.  Lying in the skin's own triangles, a wide band neither sinks
// into a fold nor covers itself.
import type { Vector } from "../../api/types";

/** Points of lines, metres in the scan's axes. */
export interface ErrorPoints {
  readonly points: Float32Array; // x y z in a row
  readonly normals: Float32Array; // of the skin there
  readonly errors: Float32Array; // metres, per point; none is NaN
}

export interface Skin {
  readonly position: ArrayLike<number>;
  readonly normal: ArrayLike<number>; // per vertex
  readonly index: ArrayLike<number>;
}

export interface Band {
  readonly position: Float32Array;
  /** per corner: 0 on the line, 1 at the end of the band, more beyond */
  readonly share: Float32Array;
}

const CUTS = 2; // times that a triangle's edges are halved: the scan's are as long as a narrow band is wide
const FACING = 0.2; // cosine: skin that looks another way is an arm beside the chest, or the far side of a fold
const BEYOND = 1.3; // shares to which triangles are taken, so that the band's edge is whole

/** Points by place, so that only those near a place are looked at. */
export class ErrorIndex {
  private readonly cells = new Map<number, number[]>();
  private readonly size: number;
  readonly count: number;

  constructor(private readonly of: ErrorPoints) {
    this.count = of.errors.length;
    this.size = BEYOND * of.errors.reduce((most, each) => Math.max(most, each), 1e-4);
    for (let i = 0; i < this.count; i += 1) {
      const key = this.key(...this.cell(of.points[3 * i]!, of.points[3 * i + 1]!, of.points[3 * i + 2]!));
      const found = this.cells.get(key);
      if (found) found.push(i);
      else this.cells.set(key, [i]);
    }
  }

  private cell(x: number, y: number, z: number): Vector {
    return [Math.floor(x / this.size), Math.floor(y / this.size), Math.floor(z / this.size)];
  }

  private readonly key = (i: number, j: number, k: number): number => (i * 73856093) ^ (j * 19349663) ^ (k * 83492791);

  /** The point in whose error a place lies deepest, and how deep (0 to BEYOND); null where none is near. */
  nearest(x: number, y: number, z: number, nx: number, ny: number, nz: number): { share: number; point: number } | null {
    const { points, normals, errors } = this.of;
    const [i, j, k] = this.cell(x, y, z);
    let share = BEYOND;
    let point = -1;
    for (let a = i - 1; a <= i + 1; a += 1)
      for (let b = j - 1; b <= j + 1; b += 1)
        for (let c = k - 1; c <= k + 1; c += 1)
          for (const at of this.cells.get(this.key(a, b, c)) ?? []) {
            const away = Math.hypot(points[3 * at]! - x, points[3 * at + 1]! - y, points[3 * at + 2]! - z) / errors[at]!;
            if (away >= share || normals[3 * at]! * nx + normals[3 * at + 1]! * ny + normals[3 * at + 2]! * nz < FACING) continue;
            share = away;
            point = at;
          }
    return point < 0 ? null : { share, point };
  }
}

/** The skin within the errors of the points. */
export function errorBand(skin: Skin, index: ErrorIndex): Band {
  const position: number[] = [];
  const share: number[] = [];
  if (index.count === 0) return { position: new Float32Array(), share: new Float32Array() };
  const of = (values: ArrayLike<number>, vertex: number): Vector => [values[3 * vertex]!, values[3 * vertex + 1]!, values[3 * vertex + 2]!];
  const cut = (corners: readonly [Corner, Corner, Corner], times: number): void => {
    if (times > 0) {
      const [a, b, c] = corners;
      const [ab, bc, ca] = [between(a, b), between(b, c), between(c, a)];
      for (const part of [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] as const) cut(part, times - 1);
      return;
    }
    const shares = corners.map(({ at, normal }) => index.nearest(...at, ...normal)?.share ?? BEYOND);
    if (shares.every((each) => each >= 1)) return;
    corners.forEach(({ at }) => position.push(...at));
    share.push(...shares);
  };
  const near = new Map<number, boolean>();
  const isNear = (vertex: number): boolean => {
    let found = near.get(vertex);
    if (found === undefined) near.set(vertex, (found = index.nearest(...of(skin.position, vertex), ...of(skin.normal, vertex)) !== null));
    return found;
  };
  for (let at = 0; at < skin.index.length; at += 3) {
    const [a, b, c] = [skin.index[at]!, skin.index[at + 1]!, skin.index[at + 2]!];
    const corner = (vertex: number): Corner => ({ at: of(skin.position, vertex), normal: of(skin.normal, vertex) });
    const corners = [corner(a), corner(b), corner(c)] as const;
    const middle = between(corners[0], between(corners[1], corners[2]));
    if (isNear(a) || isNear(b) || isNear(c) || index.nearest(...middle.at, ...middle.normal)) cut(corners, CUTS);
  }
  return { position: new Float32Array(position), share: new Float32Array(share) };
}

interface Corner {
  readonly at: Vector;
  readonly normal: Vector;
}

const half = (a: Vector, b: Vector): Vector => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2];
const between = (a: Corner, b: Corner): Corner => ({ at: half(a.at, b.at), normal: half(a.normal, b.normal) });
