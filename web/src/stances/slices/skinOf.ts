// The skin of a scan for its slices: triangles in the scan's axes, millimetres.
import type { Frame, Vector } from "../../api/types";
import { flat, type Box, type Skin, type View } from "../../drawing/slices/section";
import { place } from "../../scan/place";
import { mmFromMetres } from "../../ui/units";
import { leftOf } from "../../viewer/frame";
import { firstMesh, readGltf } from "../../viewer/gltf";

export interface SeenSkin extends Skin {
  readonly low: Vector; // of a box along the frame's axes: left, up, front; mm
  readonly high: Vector;
}

export async function readSkin(bytes: ArrayBuffer, frame: Frame): Promise<SeenSkin> {
  const { scene } = await readGltf(bytes);
  scene.updateMatrixWorld(true);
  const mesh = firstMesh(scene);
  if (!mesh) throw new Error("no mesh");
  place(mesh.geometry, mesh.matrixWorld);
  const { position } = mesh.geometry.attributes;
  const positions = Float32Array.from(position!.array, mmFromMetres);
  const index = mesh.geometry.index?.array ?? Uint32Array.from({ length: position!.count }, (_, i) => i);
  const axes = [leftOf(frame), frame.up, frame.front];
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 3) {
    for (const [k, [x, y, z]] of axes.entries()) {
      const along = positions[i]! * x + positions[i + 1]! * y + positions[i + 2]! * z;
      if (along < low[k]!) low[k] = along;
      if (along > high[k]!) high[k] = along;
    }
  }
  return { positions, index, low: low as unknown as Vector, high: high as unknown as Vector };
}

/** A place by its ways along left, up and front. */
export const fromWays = ([left, up, front]: readonly number[], frame: Frame): Vector => leftOf(frame).map((value, k) => left! * value + up! * frame.up[k]! + front! * frame.front[k]!) as unknown as Vector;

/** In the picture. */
export function boxOf({ low, high }: SeenSkin, frame: Frame, view: View): Box {
  const [a, b] = [flat(fromWays(low, frame), view), flat(fromWays(high, frame), view)];
  return [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]), Math.max(a[1], b[1])];
}
