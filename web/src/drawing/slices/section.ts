// Plane sections of a skin: where a plane cuts its triangles, as lines in the picture, and what of the picture is body.
// Pictures are in millimetres along `right` and `up`, from the scan's zero.
import type { Frame, Vector } from "../../api/types";
import { cross, dot, leftOf, negative } from "../../viewer/frame";
import type { Plane } from "./state";

export type Flat = readonly [x: number, y: number];

/** A plane as it is seen: unit vectors in the scan's axes. */
export interface View {
  readonly right: Vector;
  readonly up: Vector;
  readonly out: Vector; // to the eye: the plane's place is counted along it
}

/** Triangles in the scan's axes, millimetres, seen counterclockwise from outside. */
export interface Skin {
  readonly positions: ArrayLike<number>;
  readonly index: ArrayLike<number>;
}

/** A line in the picture with the body to its left; closed, or ending where the skin ends. */
export interface Outline {
  readonly points: readonly Flat[];
  readonly isClosed: boolean;
}

/** [least x, least y, most x, most y] of the skin as a whole. */
export type Box = readonly [number, number, number, number];

/** Axes of DICOM and of label maps: left, back, head. */
export const LPS: Frame = { up: [0, 0, 1], front: [0, -1, 0] };

/** As radiology shows them: axial from the feet, sagittal from the patient's left with the front to the left, coronal from the front. */
export function viewOf(plane: Plane, frame: Frame): View {
  const right = plane === "sagittal" ? negative(frame.front) : leftOf(frame);
  const up = plane === "axial" ? frame.front : frame.up;
  return { right, up, out: cross(right, up) };
}

export const flat = (point: Vector, { right, up }: View): Flat => [dot(point, right), dot(point, up)];

/** The place in the plane of `through` that is seen there in the picture. */
export function placeAt([x, y]: Flat, view: View, through: Vector): Vector {
  const deep = dot(through, view.out);
  return view.right.map((value, k) => x * value + y * view.up[k]! + deep * view.out[k]!) as unknown as Vector;
}

const GRAIN = 100; // to a millimetre: corners nearer than that are one

/** The lines in which the plane at `offset` (mm, along `out`) cuts the skin. */
export function cut({ positions, index }: Skin, view: View, offset: number): Outline[] {
  const { right, up, out } = view;
  const starts = new Map<number, number[]>(); // corner's key -> pieces that begin there
  const pieces: { from: Flat; to: Flat; fromKey: number; toKey: number; isUsed: boolean }[] = [];
  const ends = new Set<number>();
  const above = (vertex: number): number => positions[3 * vertex]! * out[0] + positions[3 * vertex + 1]! * out[1] + positions[3 * vertex + 2]! * out[2] - offset;
  const crossing = (a: number, b: number, da: number, db: number): Flat => {
    const share = da / (da - db);
    const at = (axis: Vector): number => axis.reduce((sum, value, k) => sum + value * (positions[3 * a + k]! + share * (positions[3 * b + k]! - positions[3 * a + k]!)), 0);
    return [at(right), at(up)];
  };
  for (let i = 0; i + 2 < index.length; i += 3) {
    const heights = [above(index[i]!), above(index[i + 1]!), above(index[i + 2]!)] as const;
    const isAbove = heights.map((height) => height >= 0);
    if (isAbove[0] === isAbove[1] && isAbove[1] === isAbove[2]) continue;
    let [from, to]: [Flat | null, Flat | null] = [null, null];
    for (let k = 0; k < 3; k += 1) {
      const next = (k + 1) % 3;
      if (isAbove[k] === isAbove[next]) continue;
      // The same edge is cut in the same direction from both of its triangles, so that both come to one place.
      const [low, high] = isAbove[k] ? [next, k] : [k, next];
      const place = crossing(index[i + low]!, index[i + high]!, heights[low]!, heights[high]!);
      if (isAbove[k]) from = place;
      else to = place;
    }
    const [fromKey, toKey] = [keyOf(from!), keyOf(to!)];
    if (fromKey === toKey) continue;
    starts.set(fromKey, [...(starts.get(fromKey) ?? []), pieces.length]);
    ends.add(toKey);
    pieces.push({ from: from!, to: to!, fromKey, toKey, isUsed: false });
  }
  const follow = (first: number): Outline => {
    const points: Flat[] = [pieces[first]!.from];
    let at: number | undefined = first;
    let last = pieces[first]!;
    while (at !== undefined) {
      last = pieces[at]!;
      last.isUsed = true;
      points.push(last.to);
      at = starts.get(last.toKey)?.find((piece) => !pieces[piece]!.isUsed);
    }
    return { points, isClosed: last.toKey === pieces[first]!.fromKey };
  };
  const open = pieces.flatMap((piece, i) => (!piece.isUsed && !ends.has(piece.fromKey) ? [follow(i)] : []));
  const closed = pieces.flatMap((piece, i) => (piece.isUsed ? [] : [follow(i)]));
  return [...open, ...closed];
}

const keyOf = ([x, y]: Flat): number => (Math.round(GRAIN * x) + 5e6) * 1e7 + Math.round(GRAIN * y) + 5e6;

const AT_EDGE = 6; // mm, as a voxel may be long: so near to the edge the skin ends because the image does
const NO_CORNER = 1e-6;
const BEYOND = 1000; // mm: the body goes on there, outside the picture

/**
 * What is body, as closed lines.  Where the skin ends at the edge of what was imaged the body goes on beyond it; null
 * where it ends elsewhere, as at a hole: then nobody knows.
 */
export function bodyOf(outlines: readonly Outline[], box: Box): readonly (readonly Flat[])[] | null {
  const open = outlines.filter(({ isClosed }) => !isClosed);
  const ways = open.map(({ points }) => ({ leaves: edgeAt(points.at(-1)!, points.at(-2)!, box), comes: edgeAt(points[0]!, points[1]!, box) }));
  if (ways.some(({ leaves, comes }) => leaves === null || comes === null)) return null;
  const found: (readonly Flat[])[] = outlines.filter(({ isClosed }) => isClosed).map(({ points }) => points);
  const left = new Set(open.keys());
  for (const first of left) {
    const loop: Flat[] = [];
    for (let at = first; left.has(at); ) {
      left.delete(at);
      loop.push(...open[at]!.points);
      const leaves = ways[at]!.leaves!;
      // Counterclockwise along the edge, with the body to the left, to where the next line comes in.
      const gaps = ways.map(({ comes }) => (comes! - leaves + 4) % 4);
      const next = gaps.indexOf(Math.min(...gaps));
      loop.push(onEdge(leaves, box));
      for (let corner = Math.floor(leaves) + 1; corner < leaves + gaps[next]!; corner += 1) loop.push(onEdge(corner % 4, box));
      loop.push(onEdge(ways[next]!.comes!, box));
      at = next;
    }
    found.push(loop);
  }
  return found;
}

/** 0 to 4, counterclockwise from the lower left corner: where a line that goes on from `before` over `end` meets the edge. */
function edgeAt(end: Flat, before: Flat, [x0, y0, x1, y1]: Box): number | null {
  const [dx, dy] = [end[0] - before[0], end[1] - before[1]];
  const sides: readonly (readonly [away: number, outwards: number, share: number])[] = [
    [end[1] - y0, -dy, (end[0] - x0) / (x1 - x0)],
    [x1 - end[0], dx, (end[1] - y0) / (y1 - y0)],
    [y1 - end[1], dy, (x1 - end[0]) / (x1 - x0)],
    [end[0] - x0, -dx, (y1 - end[1]) / (y1 - y0)],
  ];
  const near = [...sides.entries()].filter(([, [away]]) => away < AT_EDGE).sort(([, a], [, b]) => b[1] - a[1])[0];
  return near ? near[0] + Math.min(Math.max(near[1][2], NO_CORNER), 1 - NO_CORNER) : null; // at a corner it leaves through one side all the same
}

/** The place of such a number, outside the picture. */
function onEdge(at: number, [x0, y0, x1, y1]: Box): Flat {
  const share = at - Math.floor(at);
  const isCorner = share === 0;
  const [low, left, high, right] = [y0 - BEYOND, x0 - BEYOND, y1 + BEYOND, x1 + BEYOND];
  const side = Math.floor(at) % 4;
  if (side === 0) return isCorner ? [left, low] : [x0 + share * (x1 - x0), low];
  if (side === 1) return isCorner ? [right, low] : [right, y0 + share * (y1 - y0)];
  if (side === 2) return isCorner ? [right, high] : [x1 - share * (x1 - x0), high];
  return isCorner ? [left, high] : [left, y1 - share * (y1 - y0)];
}

/** Radius of the circle in which the plane cuts a ball; null where it does not. */
export function ballCut(center: Vector, radius: number, { out }: View, offset: number): number | null {
  const off = dot(center, out) - offset;
  return Math.abs(off) < radius ? Math.sqrt(radius ** 2 - off ** 2) : null;
}

/** What of a line lies within `half` mm of the plane, piece by piece: a dot where it goes through. */
export function lineNear(points: readonly Vector[], view: View, offset: number, half: number): (readonly [Flat, Flat])[] {
  const found: (readonly [Flat, Flat])[] = [];
  for (let i = 1; i < points.length; i += 1) {
    const [a, b] = [points[i - 1]!, points[i]!];
    const [da, db] = [dot(a, view.out) - offset, dot(b, view.out) - offset];
    const reach = (limit: number): number => (da === db ? (Math.abs(da) <= half ? (limit < 0 ? 0 : 1) : NaN) : (limit - da) / (db - da));
    const [s, t] = [reach(-half), reach(half)].sort((x, y) => x - y) as [number, number];
    const [from, to] = [Math.max(0, s), Math.min(1, t)];
    if (!(from <= to)) continue;
    const at = (share: number): Flat => flat(a.map((value, k) => value + share * (b[k]! - value)) as unknown as Vector, view);
    found.push([at(from), at(to)]);
  }
  return found;
}
