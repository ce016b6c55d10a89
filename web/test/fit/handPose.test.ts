import { expect, test } from "vitest";
import type { NodePose } from "../../src/api/types";
import { scaleOf, weightOf, withScale, withWeight } from "../../src/fit/hand_pose/handPose";

const nodes: NodePose[] = [
  { name: "lumbar", translation: [0, 0, 0], rotation: [0, 0, 0, 1] },
  { name: "lumbar_scale", scale: [1, 1.1, 1.2] },
  { name: "torso", weights: [0.5, -0.5] },
];

test("one number of one part changes, in a copy", () => {
  const wider = withScale(nodes, "lumbar", 0, 1.4);
  expect([0, 1, 2].map((axis) => scaleOf(wider, "lumbar", axis as 0 | 1 | 2))).toEqual([1.4, 1.1, 1.2]);
  expect(scaleOf(nodes, "lumbar", 0)).toBe(1);
  const fuller = withWeight(wider, 1, 0.25);
  expect([weightOf(fuller, 0), weightOf(fuller, 1)]).toEqual([0.5, 0.25]);
  expect(weightOf(nodes, 1)).toBe(-0.5);
  expect(fuller[0]).toBe(nodes[0]);
});

test("what the model does not have is not invented", () => {
  expect(scaleOf(nodes, "tail", 0)).toBeNull();
  expect(withScale(nodes, "tail", 0, 2)).toEqual(nodes);
});
