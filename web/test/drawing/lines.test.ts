import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { polyline } from "../../src/drawing/lines/lines";

const POINTS: Vector[] = [[0, 0, 0], [10, 20, 30]];

test("a polyline of the service is shown in metres, whatever its unit", () => {
  expect([...polyline({ points: POINTS, closed: true, bridged: [false, true] }, 25.4).points]).toEqual([0, 0, 0, ...[0.254, 0.508, 0.762].map(Math.fround)]);
  expect([...polyline({ points: POINTS }).points]).toEqual([0, 0, 0, ...[0.01, 0.02, 0.03].map(Math.fround)]);
});

test("what the service leaves out of a polyline is open and on the skin", () => {
  expect(polyline({ points: POINTS })).toMatchObject({ isClosed: false, bridged: null });
  expect(polyline({ points: POINTS, closed: true, bridged: [false, true] })).toMatchObject({ isClosed: true, bridged: [false, true] });
});
