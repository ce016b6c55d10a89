import type { BufferGeometry} from "three";
import { SphereGeometry } from "three";
import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { ballCut, bodyOf, type Box, cut, type Flat, flat, lineNear, LPS, type Outline, placeAt, type Skin, viewOf } from "../../src/drawing/slices/section";
import { cut as kept } from "../shapes";

const skinOf = (geometry: BufferGeometry): Skin => ({ positions: geometry.attributes.position!.array, index: geometry.index!.array });
const ball = (x: number, y: number, z: number, radius = 50): BufferGeometry => new SphereGeometry(radius, 64, 48).translate(x, y, z);
/** mm², positive counterclockwise. */
const areaOf = (points: readonly Flat[]): number => points.reduce((sum, [x, y], i) => sum + (x * points[(i + 1) % points.length]![1] - points[(i + 1) % points.length]![0] * y) / 2, 0);
const LESION: Vector = [60, -35, 150]; // LPS: the patient's left, to the front, to the head

test("in a label map's axes left is right in axial and coronal pictures, the front is up or left, the head is up", () => {
  const seen = (plane: "axial" | "sagittal" | "coronal") => flat(LESION, viewOf(plane, LPS)).map(Math.round);
  expect(seen("axial")).toEqual([60, 35]);
  expect(seen("sagittal")).toEqual([-35, 150]);
  expect(seen("coronal")).toEqual([60, 150]);
  for (const plane of ["axial", "sagittal", "coronal"] as const) {
    const view = viewOf(plane, LPS);
    const [x, y, z] = placeAt(flat(LESION, view), view, LESION);
    expect([x, y, z].map((value) => Math.round(value))).toEqual(LESION);
  }
});

test("in another scan's axes too: standing along y, looking along z", () => {
  const frame = { up: [0, 1, 0] as Vector, front: [0, 0, 1] as Vector };
  expect(flat([60, 150, 35], viewOf("axial", frame))).toEqual([60, 35]);
  expect(flat([60, 150, 35], viewOf("sagittal", frame))).toEqual([-35, 150]);
  expect(flat([60, 150, 35], viewOf("coronal", frame))).toEqual([60, 150]);
});

test("a ball is cut in one closed circle with the body to its left, at the place where it is, in all three planes", () => {
  for (const plane of ["axial", "sagittal", "coronal"] as const) {
    const view = viewOf(plane, LPS);
    const middle = flat(LESION, view);
    const through = view.out.reduce((sum, value, k) => sum + value * LESION[k]!, 0);
    const [outline, ...more] = cut(skinOf(ball(...LESION)), view, through + 30);
    expect(more).toEqual([]);
    expect(outline!.isClosed).toBe(true);
    for (const [x, y] of outline!.points) expect(Math.hypot(x - middle[0], y - middle[1])).toBeCloseTo(40, -0.5);
    expect(areaOf(outline!.points)).toBeGreaterThan(0.97 * Math.PI * 40 ** 2);
  }
});

test("beside the ball nothing is cut; a hollow ball's inner skin runs the other way", () => {
  const view = viewOf("axial", LPS);
  expect(cut(skinOf(ball(0, 0, 0)), view, 80)).toEqual([]);
  const inner = ball(0, 0, 0, 20);
  inner.index!.array.reverse(); // looks inwards
  expect(areaOf(cut(skinOf(inner), view, 0)[0]!.points)).toBeLessThan(-0.97 * Math.PI * 20 ** 2);
});

const outline = (...points: Flat[]): Outline => ({ points, isClosed: false });

/** Whether a place lies in the body: how often the closed lines go around it. */
const isBody = (loops: readonly (readonly Flat[])[] | null, [x, y]: Flat): boolean =>
  (loops ?? []).reduce((sum, loop) => sum + loop.reduce((turns, a, i) => {
    const b = loop[(i + 1) % loop.length]!;
    const side = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
    return turns + (a[1] <= y && b[1] > y && side > 0 ? 1 : a[1] > y && b[1] <= y && side < 0 ? -1 : 0);
  }, 0), 0) !== 0;

test("where the image ends the body goes on: behind a chest whose skin runs from edge to edge", () => {
  const box: Box = [-100, 0, 100, 60];
  const chest = outline([100, 1], [90, 1], [50, 60], [0, 1], [-50, 60], [-90, 1], [-100, 1]); // the body below it, to its left
  const body = bodyOf([chest], box);
  for (const place of [[0, -40], [50, 30], [-50, 50], [120, -10], [-120, -1], [120, 0]] as const) expect(isBody(body, place), place.join(" ")).toBe(true);
  for (const place of [[0, 30], [100, 55], [-100, 55], [0, 70]] as const) expect(isBody(body, place), place.join(" ")).toBe(false);
});

test("a chest that ends in the image's very corners goes on straight, not over a corner", () => {
  const body = bodyOf([outline([100, 0], [50, 60], [0, 0], [-50, 60], [-99, 0], [-100, 0])], [-100, 0, 100, 60]);
  for (const place of [[-180, -2], [0, -2]] as const) expect(isBody(body, place), place.join(" ")).toBe(true);
  expect(isBody(body, [-180, 2])).toBe(false);
});

test("two cut breasts that hang out of a picture are two, and the air between them is air", () => {
  const box: Box = [0, 0, 100, 50];
  const body = bodyOf([outline([30, 0], [20, 50], [10, 0]), outline([90, 0], [80, 50], [70, 0])], box);
  for (const place of [[20, 20], [80, 20], [20, -20]] as const) expect(isBody(body, place), place.join(" ")).toBe(true);
  for (const place of [[50, 20], [50, -20], [5, 10]] as const) expect(isBody(body, place), place.join(" ")).toBe(false);
});

test("at a hole nobody knows where the body is", () => {
  expect(bodyOf([outline([30, 20], [20, 50], [10, 20])], [0, 0, 100, 60])).toBeNull();
  const half = kept(ball(0, 0, 0), (x) => x > -10);
  const [open] = cut(skinOf(half), viewOf("axial", LPS), 0);
  expect(open!.isClosed).toBe(false);
});

test("a ball beside the plane is no circle; through its middle it is as wide as it is", () => {
  const view = viewOf("sagittal", LPS);
  expect(ballCut(LESION, 8, view, 60)).toBeCloseTo(8);
  expect(ballCut(LESION, 8, view, 60 + 4.8)).toBeCloseTo(6.4);
  expect(ballCut(LESION, 8, view, 69)).toBeNull();
});

test("of a line in the plane all is seen, of one through it a dot, of one beside it nothing", () => {
  const view = viewOf("coronal", LPS); // out is the front: -y
  expect(lineNear([[0, -30, 0], [40, -30, 10]], view, 30, 1)).toEqual([[[0, 0], [40, 10]]]);
  const [[from, to]] = lineNear([[5, -20, 7], [5, -40, 7]], view, 30, 1) as [[Flat, Flat]];
  expect([from, to]).toEqual([[5, 7], [5, 7]]);
  expect(lineNear([[0, -20, 0], [40, -21, 10]], view, 30, 1)).toEqual([]);
});
