import { expect, test } from "vitest";
import { widthsOf } from "../../src/drawing/lines/widths";

const at = (count: number): [number, number, number][] => Array.from({ length: count }, (_, i) => [i, 0, 0]);

test("a halo shows the line error, across the line, of which the service says one number", () => {
  const widths = widthsOf({ points: at(2), error_mm: [10, 20], line_error_mm: 0.71 * Math.sqrt(250) });
  expect(widths[0]).toBeCloseTo(7.1, 6);
  expect(widths[1]).toBeCloseTo(14.2, 6);
});

test("a width that is not known is none, nor is one of more than a breast", () => {
  expect(widthsOf({ points: at(2), error_mm: null })).toEqual([NaN, NaN]);
  expect(widthsOf({ points: at(3), error_mm: [null, 5, 100], line_error_mm: null })).toEqual([NaN, 5, NaN]);
});
