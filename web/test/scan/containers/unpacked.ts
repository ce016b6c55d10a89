// What a plain GLB says, read without any of the code that wrote it.
import { expect } from "vitest";

interface Part {
  readonly position: number[][];
  readonly colour: number[][] | null; // shares of one
  readonly uv: number[][] | null;
  readonly indices: number[];
}

interface Plain {
  readonly document: Record<string, unknown>;
  readonly parts: Part[];
  readonly pictures: Uint8Array[];
}

const READERS: Record<number, [number, (view: DataView, at: number) => number]> = {
  5121: [1, (view, at) => view.getUint8(at)],
  5123: [2, (view, at) => view.getUint16(at, true)],
  5125: [4, (view, at) => view.getUint32(at, true)],
  5126: [4, (view, at) => view.getFloat32(at, true)],
};
const COLUMNS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

export function read(glb: Uint8Array): Plain {
  const view = new DataView(glb.buffer, glb.byteOffset, glb.byteLength);
  expect(view.getUint32(0, true)).toBe(0x46546c67);
  expect(view.getUint32(8, true)).toBe(glb.byteLength);
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + length))) as Record<string, never[]> & Record<string, unknown>;
  const binary = 28 + length;
  const views = document.bufferViews as unknown as { byteOffset: number; byteLength: number; byteStride?: number }[];
  const rows = (index: number | undefined): number[][] | null => {
    if (index === undefined) return null;
    const accessor = (document.accessors as unknown as { bufferView: number; byteOffset?: number; componentType: number; count: number; type: string; normalized?: boolean }[])[index]!;
    const { byteOffset, byteStride, byteLength } = views[accessor.bufferView]!;
    const [size, number] = READERS[accessor.componentType]!;
    const columns = COLUMNS[accessor.type]!;
    const stride = byteStride ?? size * columns;
    expect((accessor.byteOffset ?? 0) + stride * (accessor.count - 1) + size * columns).toBeLessThanOrEqual(byteLength);
    const start = binary + byteOffset + (accessor.byteOffset ?? 0);
    return Array.from({ length: accessor.count }, (_, row) => Array.from({ length: columns }, (_, column) => number(view, start + row * stride + column * size) / (accessor.normalized ? 2 ** (8 * size) - 1 : 1)));
  };
  const primitives = (document.meshes as unknown as { primitives: { attributes: Record<string, number>; indices: number }[] }[]).flatMap((mesh) => mesh.primitives);
  const images = (document.images ?? []) as unknown as { bufferView: number }[];
  return {
    document,
    parts: primitives.map(({ attributes, indices }) => ({ position: rows(attributes.POSITION)!, colour: rows(attributes.COLOR_0), uv: rows(attributes.TEXCOORD_0), indices: rows(indices)!.flat() })),
    pictures: images.map(({ bufferView }) => glb.slice(binary + views[bufferView]!.byteOffset).slice(0, views[bufferView]!.byteLength)),
  };
}
