// Draco's own decoder, as three.js brings it: a compressed primitive becomes plain arrays.
import makeDecoder from "three/examples/jsm/libs/draco/gltf/draco_wasm_wrapper.js";
import { type Accessor, BYTES, FLOAT, NUMBERS } from "./glb";
import { BadContainer, type Budget, checkTriangles } from "./limits";
import * as text from "./text";

type Draco = Awaited<ReturnType<typeof makeDecoder>>;

/** Once opened, it decodes one primitive after the other. */
export async function openDraco(wasmBinary: ArrayBuffer) {
  const draco = await makeDecoder({ wasmBinary });
  return (data: Uint8Array, wanted: Record<string, readonly [number, Accessor]>, budget: Budget): DracoMesh => decoded(draco, data, wanted, budget);
}

export interface DracoMesh {
  readonly indices: Uint32Array;
  readonly attributes: Record<string, Uint8Array>; // of the accessor's own numbers
  readonly points: number;
}

/** `wanted`: name -> (Draco's number of it, the accessor that says its kind of numbers). */
function decoded(draco: Draco, data: Uint8Array, wanted: Record<string, readonly [number, Accessor]>, budget: Budget): DracoMesh {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  try {
    const status = decoder.DecodeArrayToMesh(new Int8Array(data.buffer, data.byteOffset, data.byteLength), data.byteLength, mesh);
    if (!status.ok() || mesh.ptr === 0) throw new BadContainer(text.damaged);
    const points = mesh.num_points();
    checkTriangles(mesh.num_faces());
    const attributes: Record<string, Uint8Array> = {};
    for (const [name, [id, accessor]] of Object.entries(wanted)) {
      const attribute = decoder.GetAttributeByUniqueId(mesh, id);
      const columns = NUMBERS[accessor.type];
      const kind = kindOf(draco, accessor.componentType);
      if (attribute.ptr === 0 || columns === undefined || attribute.num_components() !== columns) throw new BadContainer(text.damaged);
      attributes[name] = copied(draco, points * columns * BYTES[accessor.componentType]!, budget, (size, at) => decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, kind, size, at));
    }
    const corners = copied(draco, 12 * mesh.num_faces(), budget, (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at));
    return { indices: new Uint32Array(corners.buffer), attributes, points };
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

function copied(draco: Draco, size: number, budget: Budget, fill: (size: number, at: number) => boolean): Uint8Array<ArrayBuffer> {
  budget.take(size);
  const at = draco._malloc(size);
  try {
    if (!fill(size, at)) throw new BadContainer(text.damaged);
    return new Uint8Array(draco.HEAPF32.buffer, at, size).slice();
  } finally {
    draco._free(at);
  }
}

function kindOf(draco: Draco, componentType: number): number {
  const kinds: Record<number, number> = { 5120: draco.DT_INT8, 5121: draco.DT_UINT8, 5122: draco.DT_INT16, 5123: draco.DT_UINT16, 5125: draco.DT_UINT32, [FLOAT]: draco.DT_FLOAT32 };
  const kind = kinds[componentType];
  if (kind === undefined) throw new BadContainer(text.damaged);
  return kind;
}
