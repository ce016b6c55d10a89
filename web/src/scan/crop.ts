// What a person has drawn around and cut away: the surroundings, an arm that is in the way, a bad part of the scan.  A lasso
// cuts like scissors: everything within it as it was seen, however deep.  The service keeps the cuts with the scan, which stays
// whole, and finds the same triangles (scan/hand_cuts.py).
import type { Cut, Vector } from "../api/types";
import type { History } from "../store/history";

export interface Crop {
  /** Column by column: from metres in the scan's axes to the picture in which the lasso was drawn. */
  readonly toPicture: readonly number[];
  /** Its corners there, -1 to 1 across and up. */
  readonly lasso: readonly (readonly [x: number, y: number])[];
}

export type Crops = readonly Crop[];
export const NO_CROPS: Crops = [];
export const cropsOf = (scan: { readonly crops?: History<Crops> } | null): Crops => scan?.crops?.present ?? NO_CROPS;

/** As many as the service keeps of one scan, and corners of one lasso. */
export const MOST = { cuts: 32, corners: 300 };

export const cropsFrom = (cuts: readonly Cut[]): Crops => cuts.map(({ to_picture, lasso }) => ({ toPicture: to_picture, lasso }));
export const cutsOf = (crops: Crops): Cut[] => crops.map(({ toPicture, lasso }) => ({ to_picture: [...toPicture], lasso: lasso.map(([x, y]) => [x, y]) }));

/** Cuts that were changed here, from `before` to `mine`, and meanwhile elsewhere, to `theirs`: both changes. */
export function mergedCrops(before: Crops, mine: Crops, theirs: Crops): Crops {
  const key = (crop: Crop): string => JSON.stringify(cutsOf([crop]));
  const [known, kept, there] = [before, mine, theirs].map((crops) => new Set(crops.map(key))) as [Set<string>, Set<string>, Set<string>];
  const stay = theirs.filter((crop) => kept.has(key(crop)) || !known.has(key(crop)));
  const mineOnly = mine.filter((crop) => !there.has(key(crop)) && !known.has(key(crop)));
  return [...stay, ...mineOnly].slice(0, MOST.cuts);
}

/** Says of a place, metres, whether it lies within the lasso. */
function within({ toPicture: m, lasso }: Crop): (x: number, y: number, z: number) => boolean {
  const [xs, ys] = [lasso.map(([x]) => x), lasso.map(([, y]) => y)];
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  return (x, y, z) => {
    const w = m[3]! * x + m[7]! * y + m[11]! * z + m[15]!;
    if (w <= 0) return false; // behind the eye
    const u = (m[0]! * x + m[4]! * y + m[8]! * z + m[12]!) / w;
    const v = (m[1]! * x + m[5]! * y + m[9]! * z + m[13]!) / w;
    if (u < left || u > right || v < low || v > high) return false;
    let isInside = false; // a ray to the right crosses an odd number of edges
    for (let i = 0, k = xs.length - 1; i < xs.length; k = i, i += 1) {
      if (ys[i]! > v !== ys[k]! > v && u < ((xs[k]! - xs[i]!) * (v - ys[i]!)) / (ys[k]! - ys[i]!) + xs[i]!) isInside = !isInside;
    }
    return isInside;
  };
}

/** By triangle: 1 where its middle lies in one of the lassos. */
export function croppedFaces(positions: ArrayLike<number>, index: ArrayLike<number>, crops: Crops): Uint8Array {
  const hidden = new Uint8Array(index.length / 3);
  for (const crop of crops) {
    const isWithin = within(crop);
    for (let face = 0; face < hidden.length; face += 1) {
      if (hidden[face]) continue;
      const [a, b, c] = [3 * index[3 * face]!, 3 * index[3 * face + 1]!, 3 * index[3 * face + 2]!];
      const middle = (axis: number): number => (positions[a + axis]! + positions[b + axis]! + positions[c + axis]!) / 3;
      if (isWithin(middle(0), middle(1), middle(2))) hidden[face] = 1;
    }
  }
  return hidden;
}

/** Corners of those triangles that are among `faces`, or are not. */
export const triangles = (index: Uint32Array, faces: Uint8Array, isWanted: boolean): Uint32Array => index.filter((_, i) => (faces[(i / 3) | 0] === 1) === isWanted);

/** Corners of the triangles that are not cut away; all of them where nothing else would be left. */
export function leftOver(positions: ArrayLike<number>, index: Uint32Array, crops: Crops): Uint32Array {
  const left = crops.length === 0 ? index : triangles(index, croppedFaces(positions, index, crops), false);
  return left.length === 0 ? index : left;
}

/** More than half of these places, millimetres, lie in one of the lassos: as the service says of a line (service/ink.py). */
export function isCut(points: readonly Vector[], crops: Crops): boolean {
  if (crops.length === 0) return false;
  const lassos = crops.map(within);
  const gone = points.filter(([x, y, z]) => lassos.some((isWithin) => isWithin(x / 1000, y / 1000, z / 1000)));
  return 2 * gone.length > points.length;
}

const SAMPLES = 5000;

/** Share of the triangles (of those that are shown) that the lasso takes, from a sample. */
export function shareWithin(positions: ArrayLike<number>, index: ArrayLike<number>, crop: Crop): number {
  const isWithin = within(crop);
  const faces = index.length / 3;
  const step = Math.max(1, Math.floor(faces / SAMPLES));
  let [count, all] = [0, 0];
  for (let face = 0; face < faces; face += step) {
    const at = 3 * index[3 * face]!;
    all += 1;
    if (isWithin(positions[at]!, positions[at + 1]!, positions[at + 2]!)) count += 1;
  }
  return all === 0 ? 0 : count / all;
}
