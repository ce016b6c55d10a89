// Where a projector stands and how it draws, from places that were clicked: the direct linear transform (DLT).
//
// Hartley & Zisserman, Multiple View Geometry, chapter 7: points and places are moved to their middle and scaled (7.1, data
// normalisation), the smallest eigenvector of the equations is the 3 x 4 matrix, and from there the sum of squared distances
// in the picture is made least (algorithm 7.1, the "Gold Standard", by Levenberg and Marquardt).  Six points are the least;
// points in one plane fix no matrix, and clicks that are off must not make one up; other sets that lie badly are seen from
// how far the picture of a body around them would move if each click were one pixel off.
import type { Vector } from "../api/types";
import { besideSight, type Camera, handedness, type Place, project } from "./camera";
import { symmetricEigen } from "./eigen";

export const LEAST_POINTS = 6;
const ROUNDS = 60; // of the refinement; it rests after five or so
const DEEP_MM = 50; // above and below the points' own plane, as far as a breast stands out
const FLAT_MM = 8; // root mean square from one plane: little more than clicks are off; six landmarks spread over a torso have 17 to 33
const MOST_PIXELS = 12; // that a place there may move for one pixel in each click
const FAR_PIXELS = 1e-3; // clicks that all stand on one place

export interface Sighting {
  readonly point: Vector; // mm, scan's axes
  readonly at: Place; // pixels
}

export interface Projection {
  readonly camera: Camera;
  readonly pixels: readonly number[]; // off, for each sighting
  readonly mm: readonly number[]; // how far each point lies beside the line of sight of its place
  readonly rmsPixels: number;
  readonly rmsMm: number;
}

export type Refusal = "tooFew" | "flat" | "mixedUp";

type Matrix = number[][];

/** Moves the middle to the origin and scales the mean distance to `away`. */
function normaliser(points: readonly (readonly number[])[], away: number): { middle: number[]; scale: number; points: number[][] } {
  const middle = points[0]!.map((_, axis) => points.reduce((sum, point) => sum + point[axis]!, 0) / points.length);
  const off = points.map((point) => point.map((value, axis) => value - middle[axis]!));
  const mean = off.reduce((sum, point) => sum + Math.hypot(...point), 0) / points.length;
  const scale = away / Math.max(mean, 1e-12);
  return { middle, scale, points: off.map((point) => point.map((value) => value * scale)) };
}

/** sum of outer products of the rows */
function squared(rows: readonly (readonly number[])[], size: number): Matrix {
  const out: Matrix = Array.from({ length: size }, () => new Array<number>(size).fill(0));
  for (const row of rows) for (let i = 0; i < size; i += 1) for (let k = 0; k < size; k += 1) out[i]![k]! += row[i]! * row[k]!;
  return out;
}

interface Linear {
  readonly rows: readonly (readonly number[])[]; // two for each point: how its place changes with the matrix
  readonly off: readonly number[];
}

function linearised(p: readonly number[], points: readonly number[][], places: readonly number[][]): Linear {
  const rows: number[][] = [];
  const off: number[] = [];
  points.forEach((point, n) => {
    const x = [...point, 1];
    const value = (row: number): number => x.reduce((sum, each, k) => sum + p[4 * row + k]! * each, 0);
    const w = value(2);
    [0, 1].forEach((axis) => {
      const at = value(axis) / w;
      const row = new Array<number>(12).fill(0);
      x.forEach((each, k) => {
        row[4 * axis + k] = each / w;
        row[8 + k] = (-at * each) / w;
      });
      rows.push(row);
      off.push(at - places[n]![axis]!);
    });
  });
  return { rows, off };
}

const energy = ({ off }: Linear): number => off.reduce((sum, value) => sum + value * value, 0);
const unit = (p: readonly number[]): number[] => {
  const length = Math.hypot(...p);
  return p.map((value) => value / length);
};

function refined(start: readonly number[], points: readonly number[][], places: readonly number[][]): number[] {
  let p = unit(start);
  let now = linearised(p, points, places);
  let damping = 1e-3;
  for (let round = 0; round < ROUNDS && damping < 1e9; round += 1) {
    const { values, vectors } = symmetricEigen(squared(now.rows, 12));
    const downhill = Array.from({ length: 12 }, (_, k) => -now.rows.reduce((sum, row, n) => sum + row[k]! * now.off[n]!, 0));
    const step = new Array<number>(12).fill(0);
    vectors.forEach((vector, k) => {
      const share = vector.reduce((sum, each, i) => sum + each * downhill[i]!, 0) / (Math.max(values[k]!, 0) + damping * values.at(-1)!);
      vector.forEach((each, i) => (step[i]! += share * each));
    });
    const next = unit(p.map((value, i) => value + step[i]!));
    const there = linearised(next, points, places);
    const [before, after] = [energy(now), energy(there)];
    if (after <= before) {
      [p, now, damping] = [next, there, damping / 10];
      if (before - after <= 1e-14 * before) break;
    } else damping *= 10;
  }
  return p;
}

/** How many pixels the worst of these places moves for one pixel (standard deviation) in each click. */
function spread(p: readonly number[], points: readonly number[][], places: readonly number[][], around: readonly number[][]): number {
  const { values, vectors } = symmetricEigen(squared(linearised(p, points, places).rows, 12));
  const least = 1e-13 * values.at(-1)!;
  const { rows } = linearised(p, around, around);
  let worst = 0;
  for (let n = 0; n < around.length; n += 1) {
    let variance = 0;
    for (let k = 1; k < 12; k += 1) { // the first is the matrix times a number: no picture changes
      for (const row of [rows[2 * n]!, rows[2 * n + 1]!]) {
        variance += row.reduce((sum, each, i) => sum + each * vectors[k]![i]!, 0) ** 2 / Math.max(values[k]!, least);
      }
    }
    worst = Math.max(worst, Math.sqrt(variance));
  }
  return worst;
}

/** The projection through which all points are seen nearest to their places. */
export function projectionThrough(sightings: readonly Sighting[]): Projection | Refusal {
  if (sightings.length < LEAST_POINTS) return "tooFew";
  const space = normaliser(sightings.map(({ point }) => point), Math.sqrt(3));
  const picture = normaliser(sightings.map(({ at }) => at), Math.SQRT2);
  if (1 / picture.scale < FAR_PIXELS) return "flat";
  const lying = symmetricEigen(squared(space.points, 3));
  const normal = lying.vectors[0]!; // of the plane that the points come nearest to
  if (Math.sqrt(Math.max(lying.values[0]!, 0) / sightings.length) < FLAT_MM * space.scale) return "flat";
  const rows = space.points.flatMap((point, n) => {
    const x = [...point, 1];
    const [u, v] = picture.points[n]! as [number, number];
    const none = [0, 0, 0, 0];
    return [[...none, ...x.map((each) => -each), ...x.map((each) => v * each)], [...x, ...none, ...x.map((each) => -u * each)]];
  });
  const start = symmetricEigen(squared(rows, 12)).vectors[0]!;
  let p = refined(start, space.points, picture.points);
  const deep = DEEP_MM * space.scale;
  const around = space.points.flatMap((point) => [-deep, 0, deep].map((away) => point.map((value, axis) => value + away * normal[axis]!)));
  const depths = around.map((point) => [...point, 1].reduce((sum, each, k) => sum + p[8 + k]! * each, 0));
  const isBehind = depths.filter((depth) => depth < 0).length;
  if (isBehind > around.length / 2) p = p.map((value) => -value);
  if (!(spread(p, space.points, picture.points, around) <= MOST_PIXELS)) return "flat";
  if (isBehind !== 0 && isBehind !== around.length) return "mixedUp";
  const camera = inPixels(p, space, picture);
  if (handedness(camera) <= 0) return "mixedUp"; // a mirrored picture: left and right were exchanged
  const pixels = sightings.map(({ point, at }) => {
    const { at: seen } = project(camera, point);
    return Math.hypot(seen[0] - at[0], seen[1] - at[1]);
  });
  const mm = sightings.map(({ point, at }) => besideSight(camera, point, at));
  return { camera, pixels, mm, rmsPixels: rms(pixels), rmsMm: rms(mm) };
}

const rms = (values: readonly number[]): number => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);

/** T⁻¹ P U: from the normalised picture and points back to pixels and millimetres. */
function inPixels(p: readonly number[], space: { middle: number[]; scale: number }, picture: { middle: number[]; scale: number }): Camera {
  const out = [0, 1, 2].map((row) => {
    const turned = [0, 1, 2].map((k) => p[4 * row + k]! * space.scale);
    return [...turned, p[4 * row + 3]! - turned.reduce((sum, value, k) => sum + value * space.middle[k]!, 0)];
  });
  return [...[0, 1].flatMap((row) => out[row]!.map((value, k) => value / picture.scale + picture.middle[row]! * out[2]![k]!)), ...out[2]!];
}
