// A compressed GLB -> a plain one: the same document, its arrays and pictures unpacked.  What draws is left to the service.
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";
import type { DracoMesh } from "./draco";
import { type Accessor, Binary, type Document, type Json, openGlb, packGlb, UNSIGNED_INT } from "./glb";
import { BadContainer, Budget, checkTriangles } from "./limits";
import * as text from "./text";

const DRACO = "KHR_draco_mesh_compression";
const MESHOPT = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const PICTURES = ["EXT_texture_webp", "EXT_texture_avif"];
const UNPACKED = new Set([DRACO, ...MESHOPT, ...PICTURES]);
const PLAIN_PICTURES = new Set(["image/jpeg", "image/png"]);
const LEFT_OUT = ["animations", "cameras", "extras"]; // what a scan has none of, or what says more than its triangles

export interface Tools {
  /** Opened only for a file that needs it. */
  draco(): Promise<(data: Uint8Array, wanted: Record<string, readonly [number, Accessor]>, budget: Budget) => DracoMesh>;
  /** The same picture as a JPEG or PNG; null when it cannot be decoded. */
  plainPicture(bytes: Uint8Array, kind: string): Promise<{ bytes: Uint8Array; kind: string } | null>;
}

export async function decodeGlb(bytes: Uint8Array, tools: Tools): Promise<Uint8Array<ArrayBuffer>> {
  const { document, binary } = openGlb(bytes);
  const budget = new Budget();
  if ([...(document.buffers ?? []), ...(document.images ?? [])].some(({ uri }) => uri !== undefined && !uri.startsWith("data:"))) throw new BadContainer(text.elsewhere);
  const views = await plainViews(document, binary, budget);
  const packed = new Binary();
  keepArrays(document, views, packed);
  await unpackPrimitives(document, views, packed, tools, budget);
  await unpackPictures(document, views, packed, tools, budget);
  for (const name of LEFT_OUT) Reflect.deleteProperty(document, name);
  for (const list of ["extensionsUsed", "extensionsRequired"] as const) if (document[list]) document[list] = document[list].filter((name) => !UNPACKED.has(name));
  const whole = packed.bytes();
  return packGlb({ ...document, asset: { version: "2.0" }, bufferViews: packed.views, buffers: [{ byteLength: whole.length }] }, whole);
}

/** The views that accessors name, in the new binary part; what was compressed in other ways comes later. */
function keepArrays(document: Document, views: View[], packed: Binary): void {
  const places = new Map<number, number>();
  const place = (of: { bufferView?: number } | undefined): void => {
    if (of?.bufferView === undefined) return;
    const view = views[of.bufferView];
    if (!view) throw new BadContainer(text.damaged);
    const known = places.get(of.bufferView) ?? packed.add(view.content, view.stride);
    places.set(of.bufferView, known);
    of.bufferView = known;
  };
  for (const accessor of document.accessors ?? []) {
    const sparse = accessor.sparse as undefined | Record<"indices" | "values", { bufferView?: number }>;
    [accessor, sparse?.indices, sparse?.values].forEach(place);
  }
}

interface View {
  readonly content: Uint8Array;
  readonly stride?: number;
}

/** Each buffer view's bytes; compressed ones unpacked. */
async function plainViews(document: Document, binary: Uint8Array, budget: Budget): Promise<View[]> {
  const buffers = (document.buffers ?? []).map(({ uri }, index) => (uri === undefined ? (index === 0 ? binary : new Uint8Array()) : fromAddress(uri)));
  const part = (of: { buffer: number; byteOffset?: number; byteLength: number }): Uint8Array => {
    const start = of.byteOffset ?? 0;
    const content = buffers[of.buffer]?.subarray(start, start + of.byteLength);
    if (content?.length !== of.byteLength) throw new BadContainer(text.damaged);
    return content;
  };
  const views: View[] = [];
  for (const view of document.bufferViews ?? []) {
    const packed = MESHOPT.map((name) => view.extensions?.[name]).find((found) => found !== undefined);
    const { byteStride: stride } = view;
    if (!packed) {
      budget.take(view.byteLength);
      views.push({ content: part(view), ...(stride === undefined ? {} : { stride }) });
      continue;
    }
    const { count, byteStride, mode, filter } = packed as unknown as { count: number; byteStride: number; mode: string; filter?: string };
    if (!(count >= 0 && byteStride > 0 && byteStride <= 256)) throw new BadContainer(text.damaged);
    budget.take(count * byteStride);
    await MeshoptDecoder.ready;
    const content = new Uint8Array(count * byteStride);
    MeshoptDecoder.decodeGltfBuffer(content, count, byteStride, part(packed as unknown as { buffer: number; byteLength: number }), mode, filter);
    views.push({ content, ...(mode === "ATTRIBUTES" ? { stride: byteStride } : {}) });
  }
  return views;
}

function fromAddress(uri: string): Uint8Array {
  const comma = uri.indexOf(",");
  if (!uri.slice(0, comma).endsWith(";base64")) throw new BadContainer(text.damaged);
  return Uint8Array.from(atob(uri.slice(comma + 1)), (letter) => letter.charCodeAt(0));
}

async function unpackPrimitives(document: Document, views: View[], packed: Binary, tools: Tools, budget: Budget): Promise<void> {
  const accessors = document.accessors ?? [];
  let triangles = 0;
  for (const primitive of (document.meshes ?? []).flatMap(({ primitives }) => primitives)) {
    triangles += (accessors[primitive.indices ?? primitive.attributes.POSITION!]?.count ?? 0) / 3;
    checkTriangles(triangles);
    const compressed = primitive.extensions?.[DRACO] as undefined | { bufferView: number; attributes: Record<string, number> };
    if (!compressed) continue;
    const content = views[compressed.bufferView]?.content;
    if (!content || primitive.mode !== undefined && primitive.mode !== 4) throw new BadContainer(text.damaged);
    const named = Object.entries(compressed.attributes).filter(([name]) => primitive.attributes[name] !== undefined);
    const wanted = Object.fromEntries(named.map(([name, id]) => [name, [id, accessors[primitive.attributes[name]!]!] as const]));
    const mesh = (await tools.draco())(content, wanted, budget);
    for (const [name, array] of Object.entries(mesh.attributes)) {
      const number = primitive.attributes[name]!;
      accessors[number] = { ...accessors[number]!, bufferView: packed.add(array), byteOffset: 0, count: mesh.points };
    }
    accessors.push({ bufferView: packed.add(mesh.indices), componentType: UNSIGNED_INT, count: mesh.indices.length, type: "SCALAR" });
    primitive.indices = accessors.length - 1;
    Reflect.deleteProperty(primitive.extensions!, DRACO);
  }
}

/** JPEG and PNG stay byte for byte; pictures of newer kinds are decoded by the browser and written as such. */
async function unpackPictures(document: Document, views: View[], packed: Binary, tools: Tools, budget: Budget): Promise<void> {
  for (const texture of document.textures ?? []) {
    const newer = PICTURES.map((name) => texture.extensions?.[name]?.source).find((source) => typeof source === "number");
    if (newer !== undefined) texture.source = newer;
    if (texture.extensions) for (const name of PICTURES) Reflect.deleteProperty(texture.extensions, name);
  }
  const images: Json[] = [];
  for (const { bufferView, uri, mimeType } of document.images ?? []) {
    const content = uri !== undefined ? fromAddress(uri) : views[bufferView!]?.content;
    const kind = mimeType ?? uri?.slice("data:".length, uri.indexOf(";")) ?? "";
    if (!content) throw new BadContainer(text.damaged);
    const plain = PLAIN_PICTURES.has(kind) ? { bytes: content, kind } : await tools.plainPicture(content, kind);
    const picture = plain ?? { bytes: new Uint8Array(1), kind: "image/png" }; // the service says that it was left out
    if (plain?.bytes !== content) budget.take(picture.bytes.length);
    images.push({ mimeType: picture.kind, bufferView: packed.add(picture.bytes) });
  }
  if (document.images) document.images = images;
}
