import { DoubleSide } from "three";
import { expect, test } from "vitest";
import { depthMaterial } from "../../src/viewer/overlaid";

test("what only fills the depth is drawn once, from both sides: three.js draws what is translucent twice, its back and its front", () => {
  const late = depthMaterial(true, DoubleSide);
  expect(late).toMatchObject({ transparent: true, side: DoubleSide, forceSinglePass: true, colorWrite: false });
});
