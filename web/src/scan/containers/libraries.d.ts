// What of three.js comes without types.

declare module "three/examples/jsm/libs/draco/gltf/draco_wasm_wrapper.js" {
  interface Pointer {
    readonly ptr: number;
  }
  interface DracoMesh extends Pointer {
    num_points(): number;
    num_faces(): number;
  }
  interface DracoAttribute extends Pointer {
    num_components(): number;
  }
  interface DracoDecoder extends Pointer {
    DecodeArrayToMesh(data: Int8Array, size: number, mesh: DracoMesh): { ok(): boolean };
    GetAttributeByUniqueId(mesh: DracoMesh, id: number): DracoAttribute;
    GetAttributeDataArrayForAllPoints(mesh: DracoMesh, attribute: DracoAttribute, kind: number, size: number, at: number): boolean;
    GetTrianglesUInt32Array(mesh: DracoMesh, size: number, at: number): boolean;
  }
  interface DracoModule {
    readonly Decoder: new () => DracoDecoder;
    readonly Mesh: new () => DracoMesh;
    readonly HEAPF32: Float32Array<ArrayBuffer>;
    readonly DT_INT8: number;
    readonly DT_UINT8: number;
    readonly DT_INT16: number;
    readonly DT_UINT16: number;
    readonly DT_UINT32: number;
    readonly DT_FLOAT32: number;
    _malloc(size: number): number;
    _free(at: number): void;
    destroy(thing: Pointer): void;
  }
  const make: (options: { wasmBinary: ArrayBuffer }) => Promise<DracoModule>;
  export default make;
}

declare module "three/examples/jsm/loaders/usd/USDAParser.js" {
  export class USDAParser {
    parseData(text: string): unknown;
  }
}

declare module "three/examples/jsm/loaders/usd/USDCParser.js" {
  export class USDCParser {
    parseData(bytes: ArrayBuffer): unknown;
  }
}

declare module "three/examples/jsm/loaders/usd/USDComposer.js" {
  import type { Group } from "three";

  export class USDComposer {
    readonly texturePromises: Promise<void>[];
    constructor(manager: null);
    compose(layer: unknown, assets: Record<string, unknown>, variants: Record<string, never>, path: string): Group;
  }
}
