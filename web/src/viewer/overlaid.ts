// The model over the scan, seen as one even mixture: where two surfaces lie on each other within a few millimetres they pass
// through one another everywhere, and whichever is nearer would win in patches.
//
// The order of a picture: the scan; what of the model lies farther than REACH before it, opaque, for through a back that
// nobody scanned one would look at the inside of the front; the model's depth alone, drawn REACH nearer to the eye than it is; the model's clay at
// the same depth, so that each pixel is one and the same share of it; then the depth of both as it is (order RESTORE), for
// lines and pins.  What of the model lies farther behind the scan than REACH stays hidden: an arm before the trunk is an arm.
import { FrontSide, type Material, MeshBasicMaterial, type Object3D, type Side } from "three";

const REACH = 0.03; // metres: more than a fit is off where it is one
export const MODEL_SHARE = 0.55; // of each pixel
export const GLASS = 0.3; // of each pixel, while something inside is looked at
export const ORDER = { scan: 0, farBefore: 0.5, modelDepth: 1, model: 2, mirrored: 2.5, restore: 3, restoreModel: 4 } as const;

/** Fills the depth and nothing else, both sides at once; with `isLate` after what is translucent. */
export function depthMaterial(isLate: boolean, side: Side = FrontSide): MeshBasicMaterial {
  return new MeshBasicMaterial({ colorWrite: false, side, transparent: isLate, forceSinglePass: true, polygonOffset: true });
}

/** While the model lies over the scan: as near to the eye as it is counted. */
export function bringNearer(nearer: readonly Material[], isOver: boolean, depthUnits: number): void {
  for (const material of nearer) {
    material.polygonOffset = true;
    material.polygonOffsetUnits = isOver ? -REACH * depthUnits : 0;
  }
}

/** Drawn only where it is nearer to the eye than all else by more than REACH. */
export function pushAway(farther: Material, depthUnits: number): void {
  farther.polygonOffset = true;
  farther.polygonOffsetUnits = REACH * depthUnits;
}

/** The first of what restores the depth wipes what was there. */
export function wipesDepth(thing: Object3D): void {
  thing.frustumCulled = false; // it must be drawn to wipe
  thing.onBeforeRender = (renderer) => {
    const { state } = renderer;
    state.buffers.depth.setMask(true);
    renderer.clearDepth();
  };
}
