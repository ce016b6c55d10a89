// Lines of files drawn as curves: through all of their points, nearer to the true curve, with meant corners kept.
import { expect, test } from "vitest";
import type { Polyline } from "../../src/viewer/lines/FatLines";
import { smoothed } from "../../src/viewer/smooth";

const line = (points: readonly (readonly number[])[], isClosed: boolean, bridged: boolean[] | null = null): Polyline => ({ points: new Float32Array(points.flat()), isClosed, bridged, colour: "#2b6cb0" });
const pointsOf = ({ points }: Polyline): number[][] => Array.from({ length: points.length / 3 }, (_, i) => [...points.subarray(3 * i, 3 * i + 3)]);

test("a circle of few points becomes round, through the points that it had", () => {
  const corners = Array.from({ length: 24 }, (_, i) => [0.05 * Math.cos((i * Math.PI) / 12), 0.05 * Math.sin((i * Math.PI) / 12), 0]);
  const round = smoothed(line(corners, true));
  const off = (points: readonly number[][]): number => Math.max(...points.map(([x, y]) => Math.abs(Math.hypot(x!, y!) - 0.05)));
  const middles = corners.map(([x, y], i) => [(x! + corners[(i + 1) % 24]![0]!) / 2, (y! + corners[(i + 1) % 24]![1]!) / 2]);
  expect(off(pointsOf(round))).toBeLessThan(off(middles) / 20);
  expect(pointsOf(round).filter((_, i) => i % 4 === 0).flat()).toEqual([...new Float32Array(corners.flat())]);
  expect(round).toMatchObject({ isClosed: true, colour: "#2b6cb0" });
});

test("a corner that is meant stays one, and a straight line straight", () => {
  const angle = smoothed(line([[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0], [0.02, 0.01, 0], [0.02, 0.02, 0]], false));
  for (const [x, y] of pointsOf(angle)) expect(Math.min(Math.abs(y!), Math.abs(x! - 0.02))).toBeLessThan(1e-9);
  expect(Math.max(...pointsOf(angle).map(([x]) => x!)), "no overshoot").toBeLessThanOrEqual(Math.fround(0.02));
});

test("what leads over a hole does so in between as well", () => {
  const points = [[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0], [0.03, 0, 0]];
  const { bridged } = smoothed(line(points, false, [false, false, true, false]));
  expect(bridged).toEqual([false, false, false, false, false, true, true, true, true, true, true, true, false]);
});

test("two points stay two", () => {
  const short = line([[0, 0, 0], [0.01, 0, 0]], false);
  expect(smoothed(short)).toBe(short);
});
