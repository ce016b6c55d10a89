import { expect, test } from "vitest";
import { doubtSentences, labelsOf } from "../../src/fit/landmarkWarnings";
import type { FitState } from "../../src/fit/state";

const labels = labelsOf([
  { name: "nipple_L", label: "Left nipple" },
  { name: "nipple_R", label: "Right nipple" },
]);
const exchanged = { names: ["nipple_L", "nipple_R"], reason: "nipple_L and nipple_R look exchanged; they were not followed." };
const fit = (part: object): FitState => ({ result: null, started: null, ...part }) as unknown as FitState;

test("doubted picks are told with their labels", () => {
  const found = doubtSentences(fit({ result: { landmarks_not_followed: [exchanged] } }), labels);
  expect(found).toEqual(["Left nipple and Right nipple look exchanged; they were not followed."]);
});

test("a name without a label stays, and the sentence begins with a capital", () => {
  const doubt = { names: ["my_point"], reason: "my_point is 60 mm off." };
  expect(doubtSentences(fit({ result: { landmarks_not_followed: [doubt] } }), labels)).toEqual(["My_point is 60 mm off."]);
});

test("what the start knows is told until the result tells all", () => {
  const started = { landmarks_not_followed: [exchanged] };
  expect(doubtSentences(fit({ started }), labels)).toHaveLength(1);
  expect(doubtSentences(fit({ started, result: { landmarks_not_followed: [] } }), labels)).toEqual([]);
});

test("a fit without doubts, or from before they were told, has none", () => {
  expect(doubtSentences(fit({}), labels)).toEqual([]);
  expect(doubtSentences(fit({ started: {}, result: {} }), labels)).toEqual([]);
});
