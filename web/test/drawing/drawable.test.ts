// What of a scan a pen draws on, and where a stroke ends: on a body, on two plates with air between them.
import { PlaneGeometry, SphereGeometry } from "three";
import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { gap } from "../../src/drawing/lines/lines";
import { type Skin, skinOf } from "../../src/drawing/lines/skin";
import { BRIDGE_MM, freehand, handStrokes, isJoined, leadsOver } from "../../src/drawing/lines/strokes";
import { cut, half, made, place } from "../shapes";

test("a hand may draw on the body's outside, and not on the inside of its back", () => {
  const geometry = made(half());
  const skin = skinOf(geometry);
  const corner = geometry.index!.getX(0);
  const point = [geometry.attributes.position!.getX(corner), geometry.attributes.position!.getY(corner), geometry.attributes.position!.getZ(corner)].map((value) => 1000 * value) as Vector;
  expect(skin.mayDraw({ face: 0, point }, [0, 0, 2000])).toBe(true);
  expect(skin.mayDraw({ face: 0, point }, [0, 0, -2000])).toBe(false);
  expect(skin.nearest([200, 0, 5]).away).toBeGreaterThan(90);
});

/** Two plates: one at z = 0, the other, from x = 50 on, 63 mm behind it. */
const step = (): Skin => skinOf(made(place(new PlaneGeometry(0.1, 0.1, 50, 50), 0, 0, 0), place(new PlaneGeometry(0.1, 0.1, 50, 50), 0.1, 0, -0.063)));
const drawn = (skin: Skin, hits: readonly (Vector | null)[]): Vector[][] => {
  const hand = handStrokes(skin);
  for (const hit of hits) hand.add(hit);
  return hand.strokes();
};
const widest = (points: readonly Vector[]): number => Math.max(...points.slice(1).map((point, i) => gap(points[i]!, point)));

test("a stroke that jumps to what lies 63 mm behind ends there and another begins: no line leads through air", () => {
  const skin = step();
  const hits = Array.from({ length: 41 }, (_, i): Vector => (i <= 20 ? [-40 + 4.4 * i, 0, 0] : [-40 + 4.4 * i, 0, -63]));
  const strokes = drawn(skin, hits);
  expect(strokes).toHaveLength(2);
  for (const stroke of strokes) {
    const line = freehand(skin, stroke);
    expect(widest(line)).toBeLessThan(BRIDGE_MM);
    expect(new Set(line.map(([, , z]) => Math.round(z)))).toHaveLength(1);
  }
});

test("where no skin leads across at all, two places are not joined, however the way between them collapses", () => {
  const apart = skinOf(made(new SphereGeometry(0.02, 32, 24), place(new SphereGeometry(0.02, 32, 24), 0.12, 0, 0)));
  expect(isJoined(apart, [20, 0, 0], [100, 0, 0])).toBe(false);
  expect(leadsOver(apart, [20, 0, 0], [100, 0, 0])).toBe(false);
});

test("a hand that left the skin and comes back elsewhere begins anew; a pinhole does not end the stroke", () => {
  const skin = step();
  const along = (from: number, to: number): Vector[] => Array.from({ length: 6 }, (_, i) => [from + (i * (to - from)) / 5, 0, 0]);
  expect(drawn(skin, [...along(-45, -30), null, ...along(-5, 10)])).toHaveLength(2);
  expect(drawn(skin, [...along(-45, -30), null, ...along(-26, -10)])).toHaveLength(1);
  expect(drawn(skin, [null, ...along(-45, -30), null])).toHaveLength(1);
  expect(drawn(skin, [[0, 0, 0], null]), "a speck is no line").toHaveLength(0);
});

test("a quick hand on one skin is one stroke, with gaps of several centimetres", () => {
  expect(drawn(step(), [[-45, -40, 0], [-10, 20, 0], [40, 30, 0]])).toHaveLength(1);
});

test("clicks are joined over skin and over a hole as under a breast, not through air", () => {
  const holed = (half: number): Skin => skinOf(made(cut(new PlaneGeometry(0.2, 0.2, 100, 100), (x, y) => Math.abs(x) > half || Math.abs(y) > half)));
  expect(leadsOver(holed(0.015), [-60, 0, 0], [60, 0, 0])).toBe(true);
  expect(leadsOver(step(), [40, 0, 0], [60, 0, -63])).toBe(false);
});
