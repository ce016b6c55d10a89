import { expect, test } from "vitest";
import { expectedAt } from "../../src/landmarks/questions/closeUp";
import type { ProposedLandmark } from "../../src/api/types";
import { startHistory } from "../../src/store/history";

const proposal = { point: [1, 2, 3], error_mm: 12, on_scan: true } as ProposedLandmark;
const nothing = { active: "nipple_L", picks: startHistory({}), proposals: null, beside: {}, fit: null };
const proposals = { state: "found", landmarks: { nipple_L: proposal }, not_proposed: {} } as const;
const fit = { started: null, picks: null, result: { landmarks: { nipple_L: [0.1, 0.2, 0.3] as [number, number, number] }, scan: { unit: "m" } } };

test("a landmark is expected where it was placed, else where the fit has it, else where it is proposed, else nowhere", () => {
  expect(expectedAt(nothing)).toBeNull();
  expect(expectedAt({ ...nothing, proposals })).toEqual([1, 2, 3]);
  expect(expectedAt({ ...nothing, proposals, fit })).toEqual([100, 200, 300]);
  expect(expectedAt({ ...nothing, proposals, fit, picks: startHistory({ nipple_L: [7, 8, 9] }) })).toEqual([7, 8, 9]);
  expect(expectedAt({ ...nothing, active: "mark:mole", beside: { "mark:mole": [4, 5, 6] } })).toEqual([4, 5, 6]);
  expect(expectedAt({ ...nothing, active: null, proposals })).toBeNull();
  expect(expectedAt({ ...nothing, active: "umbilicus", proposals, fit })).toBeNull();
});
