import { expect, test } from "vitest";
import { labelsOf, landmarkWarnings } from "../../src/fit/landmarkWarnings";
import type { FitState } from "../../src/fit/state";

const labels = labelsOf([
  { name: "nipple_L", label: "Left nipple" },
  { name: "nipple_R", label: "Right nipple" },
]);
const exchanged = { names: ["nipple_L", "nipple_R"], reason: "nipple_L and nipple_R look exchanged; they were not followed." };
const fit = (part: object): FitState => ({ result: null, started: null, ...part }) as unknown as FitState;

test("picks that were not followed are named by their labels", () => {
  const found = landmarkWarnings(fit({ result: { landmarks_not_followed: [exchanged] } }), labels);
  expect(found).toEqual(["Left nipple and Right nipple look exchanged; they were not followed."]);
});

test("a name without a label stays, and the sentence begins with a capital", () => {
  const warning = { names: ["my_point"], reason: "my_point is 60 mm off." };
  expect(landmarkWarnings(fit({ result: { landmarks_not_followed: [warning] } }), labels)).toEqual(["My_point is 60 mm off."]);
});

test("what the start knows counts until the result is there", () => {
  const started = { landmarks_not_followed: [exchanged] };
  expect(landmarkWarnings(fit({ started }), labels)).toHaveLength(1);
  expect(landmarkWarnings(fit({ started, result: { landmarks_not_followed: [] } }), labels)).toEqual([]);
});

test("a fit that followed all picks, or one of an older version, has none", () => {
  expect(landmarkWarnings(fit({}), labels)).toEqual([]);
  expect(landmarkWarnings(fit({ started: {}, result: {} }), labels)).toEqual([]);
});
