import { DoubleSide, MeshBasicMaterial } from "three";
import { expect, test } from "vitest";
import { bringNearer, depthMaterial, pushAway } from "../../src/viewer/overlaid";

test("what only fills the depth is drawn once, from both sides: three.js draws what is translucent twice, its back and its front", () => {
  const late = depthMaterial(true, DoubleSide);
  expect(late).toMatchObject({ transparent: true, side: DoubleSide, forceSinglePass: true, colorWrite: false });
});

test("what is far before all else is told by the same distance as what lies over it", () => {
  const [over, far] = [new MeshBasicMaterial(), new MeshBasicMaterial()];
  bringNearer([over], true, 1000);
  pushAway(far, 1000);
  expect(far).toMatchObject({ polygonOffset: true, polygonOffsetUnits: -over.polygonOffsetUnits });
  expect(far.polygonOffsetUnits).toBeGreaterThan(0);
});
