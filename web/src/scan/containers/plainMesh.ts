// Triangles with colours or a picture as a plain GLB: what the service reads, and nothing else.
import { type Accessor, Binary, type Document, FLOAT, packGlb, type Primitive, UNSIGNED_INT } from "./glb";

export interface PlainMesh {
  readonly positions: Float32Array; // (3 V) metres, or whatever unit the file means
  readonly indices: Uint32Array; // (3 F)
  readonly colours?: Float32Array; // (3 V) linear light
  readonly uv?: Float32Array; // (2 V) glTF's: from the upper left
  readonly picture?: string; // one of the pictures' names
}

export function plainGlb(meshes: readonly PlainMesh[], pictures: ReadonlyMap<string, Uint8Array>): Uint8Array<ArrayBuffer> {
  const binary = new Binary();
  const accessors: Accessor[] = [];
  const array = (content: Float32Array | Uint32Array, type: string, columns: number): number =>
    accessors.push({ bufferView: binary.add(content), componentType: content instanceof Float32Array ? FLOAT : UNSIGNED_INT, count: content.length / columns, type }) - 1;
  const names = [...new Set(meshes.flatMap(({ picture }) => picture ?? []))].filter((name) => pictures.has(name));
  const images = names.map((name) => {
    const bytes = pictures.get(name)!;
    return { mimeType: bytes[0] === 0xff ? "image/jpeg" : "image/png", bufferView: binary.add(bytes) };
  });
  const primitives = meshes.map(({ positions, indices, colours, uv, picture }): Primitive => {
    const material = names.indexOf(picture ?? "");
    return {
      attributes: {
        POSITION: array(positions, "VEC3", 3),
        ...(colours ? { COLOR_0: array(colours, "VEC3", 3) } : {}),
        ...(uv && material >= 0 ? { TEXCOORD_0: array(uv, "VEC2", 2) } : {}),
      },
      indices: array(indices, "SCALAR", 1),
      ...(material >= 0 ? { material } : {}),
    };
  });
  const whole = binary.bytes();
  const document: Document = {
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives }],
    accessors,
    bufferViews: binary.views,
    buffers: [{ byteLength: whole.length }],
    ...(names.length > 0 ? { images, textures: names.map((_, source) => ({ source })), materials: names.map((_, index) => ({ pbrMetallicRoughness: { baseColorTexture: { index } } })) } : {}),
  };
  return packGlb(document, whole);
}
