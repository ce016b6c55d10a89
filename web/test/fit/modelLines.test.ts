import { expect, test } from "vitest";
import type { ModelSide } from "../../src/api/types";
import { hasPattern, shapesOnModel } from "../../src/fit/modelLines";

const side = { drawings: [{ name: "lumpectomy", shapes: [{ name: "a" }, { name: "b" }] }, { name: "anatomy", shapes: [{ name: "c" }] }] } as unknown as ModelSide;

test("the model's own drawings ride along, also beside a pattern", () => {
  const names = (asked: string | null): string[] => shapesOnModel(side, asked).map(({ name }) => name);
  expect(names("lumpectomy")).toEqual(["a", "b"]);
  expect(names("anatomy+tumour:side=L,clock=10,distance_mm=45,radius_mm=12")).toEqual(["c"]);
  expect(names("reduction:areola_mm=42")).toEqual([]);
  expect(names(null)).toEqual([]);
});

test("a pattern is known by not being a drawing of the model", () => {
  expect(hasPattern(side, "lumpectomy+anatomy")).toBe(false);
  expect(hasPattern(side, "lumpectomy+reduction")).toBe(true);
  expect(hasPattern(side, null)).toBe(false);
});
