// The frame of a binary glTF: one JSON document and one binary chunk.
import { BadContainer } from "./limits";
import * as text from "./text";

export type Json = Record<string, unknown>;

export interface Accessor extends Json {
  bufferView?: number;
  byteOffset?: number;
  componentType: number;
  count: number;
  type: string;
  normalized?: boolean;
}

export interface BufferView extends Json {
  buffer: number;
  byteOffset?: number;
  byteLength: number;
  byteStride?: number;
  extensions?: Record<string, Json>;
}

export interface Primitive extends Json {
  attributes: Record<string, number>;
  indices?: number;
  mode?: number;
  extensions?: Record<string, Json>;
}

export interface Document extends Json {
  accessors?: Accessor[];
  bufferViews?: BufferView[];
  buffers?: (Json & { byteLength: number; uri?: string })[];
  images?: (Json & { bufferView?: number; mimeType?: string; uri?: string })[];
  meshes?: { primitives: Primitive[] }[];
  textures?: (Json & { source?: number; extensions?: Record<string, Json> })[];
  extensionsUsed?: string[];
  extensionsRequired?: string[];
}

export const FLOAT = 5126;
export const UNSIGNED_INT = 5125;
export const NUMBERS: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };
export const BYTES: Record<number, number> = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };
const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;

export function openGlb(bytes: Uint8Array): { document: Document; binary: Uint8Array } {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 20 || view.getUint32(0, true) !== MAGIC || view.getUint32(16, true) !== JSON_CHUNK) throw new BadContainer(text.damaged);
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length))) as Document;
  const at = 20 + length;
  const hasBinary = at + 8 <= bytes.length && view.getUint32(at + 4, true) === BINARY_CHUNK;
  return { document, binary: hasBinary ? bytes.subarray(at + 8, at + 8 + view.getUint32(at, true)) : new Uint8Array() };
}

export function packGlb(document: Document, binary: Uint8Array): Uint8Array<ArrayBuffer> {
  const json = new TextEncoder().encode(JSON.stringify(document));
  const [jsonSize, binarySize] = [padded(json.length), padded(binary.length)];
  const bytes = new Uint8Array(28 + jsonSize + binarySize);
  const view = new DataView(bytes.buffer);
  bytes.fill(0x20, 20, 20 + jsonSize);
  [MAGIC, 2, bytes.length, jsonSize, JSON_CHUNK].forEach((number, index) => view.setUint32(4 * index, number, true));
  bytes.set(json, 20);
  view.setUint32(20 + jsonSize, binarySize, true);
  view.setUint32(24 + jsonSize, BINARY_CHUNK, true);
  bytes.set(binary, 28 + jsonSize);
  return bytes;
}

export const padded = (size: number): number => Math.ceil(size / 4) * 4;

/** Puts arrays one behind the other, each where numbers of four bytes may begin. */
export class Binary {
  readonly views: BufferView[] = [];
  private readonly parts: Uint8Array[] = [];
  private size = 0;

  /** The number of its buffer view. */
  add(content: ArrayBufferView, byteStride?: number): number {
    const bytes = new Uint8Array(content.buffer, content.byteOffset, content.byteLength);
    this.parts.push(bytes);
    this.views.push({ buffer: 0, byteOffset: this.size, byteLength: bytes.length, ...(byteStride === undefined ? {} : { byteStride }) });
    this.size += padded(bytes.length);
    return this.views.length - 1;
  }

  bytes(): Uint8Array {
    const whole = new Uint8Array(this.size);
    this.views.forEach((view, index) => whole.set(this.parts[index]!, view.byteOffset));
    return whole;
  }
}
