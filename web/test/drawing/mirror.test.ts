// A line on the other side: in the fitted body's median plane, which the service gives, on the skin that is there.
import { PlaneGeometry, SphereGeometry } from "three";
import { expect, test } from "vitest";
import type { Result, Vector } from "../../src/api/types";
import { circle } from "../../src/drawing/lines/strokes";
import { lineAlong } from "../../src/drawing/lines/edits";
import { gap, INK, lengthOf, type OwnLine } from "../../src/drawing/lines/lines";
import { mirroredLine, mirroredPoint, mirrorPlane } from "../../src/drawing/mirror/mirror";
import { type Skin, skinOf } from "../../src/drawing/lines/skin";
import type { FitState } from "../../src/fit/state";
import { withScan } from "../fakes";
import { cut, made, place } from "../shapes";
import shared from "./median_plane.json" with { type: "json" }; // what the service says of a turned body: tests/report/test_body_frame.py

type Plane = NonNullable<Result["median_plane"]>;
const result = (median_plane: Plane | null, unit = "mm"): Pick<Result, "median_plane" | "scan"> => ({ median_plane, scan: { unit } as Result["scan"] });
const MIDDLE: Plane = { normal: [1, 0, 0], offset: 10 };

const fitted = (plane: Plane | null): FitState => ({ id: "f1", state: "running", iterations: [], result: result(plane) }) as unknown as FitState;

/** Two balls (80 mm) beside x = 10. */
const breasts = (): Skin => skinOf(made(place(new SphereGeometry(0.08, 96, 64), 0.11, 0, 0), place(new SphereGeometry(0.08, 96, 64), -0.09, 0, 0)));
const onBall = (points: readonly Vector[], x: number): number => Math.max(...points.map((point) => Math.abs(gap(point, [x, 0, 0]) - 80)));

const arc = (): OwnLine => {
  const points = Array.from({ length: 41 }, (_, i): Vector => {
    const angle = ((i - 5) * Math.PI) / 60;
    return [110 + 80 * Math.sin(angle), 0, 80 * Math.cos(angle)];
  });
  return lineAlong("Fold", INK, points, false);
};

test("the plane is the service's, in any unit, and results of earlier versions have none", () => {
  expect(mirrorPlane(result(MIDDLE))).toEqual(MIDDLE);
  expect(mirrorPlane(result({ ...MIDDLE, offset: 0.01 }, "m"))!.offset).toBeCloseTo(10, 9);
  expect(mirrorPlane(result(null))).toBeNull();
});

test("mirrored twice a point is where it was, and each of a pair lies where the other is", () => {
  const plane = mirrorPlane(result({ normal: [0.6, 0, 0.8], offset: 7 }))!;
  expect(gap(mirroredPoint(plane, [10.2, 5, 13.6]), [-1.8, 5, -2.4])).toBeLessThan(1e-9);
  expect(gap(mirroredPoint(plane, mirroredPoint(plane, [13, -4, 250])), [13, -4, 250])).toBeLessThan(1e-9);
});

test("a point's mirror image is where the service's own frame of the body has it", () => {
  const plane = mirrorPlane(result(shared.median_plane as Plane, "m"))!;
  for (const { point, mirrored } of shared.pairs_mm) expect(gap(mirroredPoint(plane, point as unknown as Vector), mirrored as unknown as Vector)).toBeLessThan(0.005);
});

test("what is guessed of a line is guessed on the other side", () => {
  const { points, name, color } = arc();
  const other = mirroredLine(breasts(), mirrorPlane(result(MIDDLE))!, lineAlong(name, color, points, false, points.map((_, i) => i >= 10 && i < 20)))!;
  const guessed = other.points.map((_, i) => i).filter((i) => other.bridged![i]);
  expect(guessed.length / other.points.length).toBeCloseTo(10 / 41, 1);
  expect(guessed.at(-1)! - guessed[0]!).toBe(guessed.length - 1);
  const from = mirroredPoint(mirrorPlane(result(MIDDLE))!, points[10]!);
  expect(gap(other.points[guessed[0]!]!, from)).toBeLessThan(4);
});

test("on an even body a line lies on the other side as it lies on this one", () => {
  const plane = mirrorPlane(result(MIDDLE))!;
  const line = arc();
  const other = mirroredLine(breasts(), plane, line)!;
  expect(onBall(other.points, -90)).toBeLessThan(0.2);
  expect(gap(other.points[0]!, mirroredPoint(plane, line.points[0]!))).toBeLessThan(0.2);
  expect(gap(other.points.at(-1)!, mirroredPoint(plane, line.points.at(-1)!))).toBeLessThan(0.2);
  expect(lengthOf(other) / lengthOf(line)).toBeCloseTo(1, 2);
});

test("a closed line stays closed, its points even", () => {
  const skin = breasts();
  const line = lineAlong("Tumour", INK, circle(skin, [110, 0, 80], 20), true);
  const other = mirroredLine(skin, mirrorPlane(result(MIDDLE))!, line)!;
  expect(other.closed).toBe(true);
  expect(lengthOf(other) / lengthOf(line)).toBeCloseTo(1, 2);
  const steps = other.points.map((point, i) => gap(point, other.points[(i + 1) % other.points.length]!));
  expect(Math.max(...steps)).toBeLessThan(3);
  expect(Math.min(...steps)).toBeGreaterThan(0.4);
});

test("on a smaller breast it comes down on that breast's skin", () => {
  const uneven = skinOf(made(place(new SphereGeometry(0.08, 96, 64), 0.11, 0, 0), place(new SphereGeometry(0.05, 96, 64), -0.09, 0, 0)));
  const other = mirroredLine(uneven, mirrorPlane(result(MIDDLE))!, arc())!;
  for (const point of other.points) expect(Math.abs(gap(point, [-90, 0, 0]) - 50)).toBeLessThan(0.3);
});

test("where the other side was not scanned there is no line", () => {
  const chest = skinOf(made(cut(new PlaneGeometry(0.4, 0.4, 80, 80), (x) => x > -0.03)));
  const across = (from: number, to: number): OwnLine => lineAlong("Line", INK, Array.from({ length: 21 }, (_, i): Vector => [from + ((to - from) * i) / 20, 0, 0]), false);
  const plane = { normal: [1, 0, 0] as Vector, offset: 0 };
  expect(mirroredLine(chest, plane, across(60, 120))).toBeNull();
  expect(mirroredLine(chest, plane, across(-20, 20))).not.toBeNull();
});

test("the copy is a line of its own, named after the first; a missing side is said", async () => {
  const { store, actions } = await withScan();
  const skin = breasts();
  actions.drawing.setSkin(() => skin);
  const fold = arc();
  actions.drawing.strokes([fold.points]);
  actions.drawing.rename("Line 1", "Fold");
  const lines = (): readonly OwnLine[] => store.get().drawn.lines.present;
  actions.drawing.mirror("Fold");
  expect(lines(), "without a fit there is no plane").toHaveLength(1);
  store.set({ fit: fitted(MIDDLE) });
  actions.drawing.mirror("Fold");
  actions.drawing.mirror("Fold");
  expect(lines().map(({ name }) => name)).toEqual(["Fold", "Fold, mirrored", "Fold, mirrored 2"]);
  expect(new Set(lines().map(({ id }) => id)).size).toBe(3);
  actions.drawing.undo();
  expect(lines()).toHaveLength(2);
  const half = skinOf(made(place(new SphereGeometry(0.08, 96, 64), 0.11, 0, 0)));
  actions.drawing.setSkin(() => half);
  store.set({ fit: fitted(MIDDLE) });
  actions.drawing.mirror("Fold");
  expect(lines()).toHaveLength(2);
  expect(store.get().problems.drawing).toBe("The other side of “Fold” is not on this scan, so it was not mirrored.");
});
