// USDZ, USD, USDA and USDC -> a plain GLB, by the parsers that three.js brings.
//
// Pictures are never decoded here: the composer gets a name in place of each one's bytes, and an image loader that hands the
// name back.  So they keep their pixels, and no address that a layer names is ever asked for.
import { ImageLoader, type Material, Matrix3, Mesh, type MeshStandardMaterial, type Texture, Vector2, Vector3 } from "three";
import { unzipSync } from "three/examples/jsm/libs/fflate.module.js";
import { USDAParser } from "three/examples/jsm/loaders/usd/USDAParser.js";
import { USDCParser } from "three/examples/jsm/loaders/usd/USDCParser.js";
import { USDComposer } from "three/examples/jsm/loaders/usd/USDComposer.js";
import { BadContainer, Budget, checkTriangles } from "./limits";
import { plainGlb, type PlainMesh } from "./plainMesh";
import * as text from "./text";

const CRATE = "PXR-USDC";
const LAYER = /\.(usd|usda|usdc)$/i;
const PICTURE = /\.(png|jpe?g)$/i;
const MOST_FILES = 2000;
const PLACE = "picture:"; // before a picture's name, so that no address can be meant

export async function decodeUsd(bytes: Uint8Array): Promise<Uint8Array<ArrayBuffer>> {
  const files = bytes[0] === 0x50 && bytes[1] === 0x4b ? unzipped(bytes) : new Map([["scan.usd", bytes]]);
  const pictures = new Map([...files].filter(([name]) => PICTURE.test(name)));
  const root = [...files.keys()].find((name) => LAYER.test(name)); // a package's first layer is its root
  if (root === undefined) throw new BadContainer(text.noMesh);
  const assets = Object.fromEntries([...files].filter(([name]) => LAYER.test(name)).map(([name, content]) => [name, layer(content)]));
  const places = Object.fromEntries([...pictures.keys()].map((name) => [name, PLACE + name]));
  const composer = withoutPictures(() => new USDComposer(null));
  const scene = composer.compose(assets[root], { ...assets, ...places }, {}, root.includes("/") ? root.slice(0, root.lastIndexOf("/")) : "");
  await Promise.all(composer.texturePromises);
  scene.updateMatrixWorld(true);
  const meshes: PlainMesh[] = [];
  let triangles = 0;
  scene.traverse((node) => {
    if (!(node instanceof Mesh) || !node.visible) return;
    for (const mesh of plainMeshes(node as Mesh)) {
      triangles += mesh.indices.length / 3;
      checkTriangles(triangles);
      meshes.push(mesh);
    }
  });
  if (triangles === 0) throw new BadContainer(text.noMesh);
  return plainGlb(meshes, pictures);
}

function unzipped(bytes: Uint8Array): Map<string, Uint8Array> {
  const budget = new Budget();
  let count = 0;
  const filter = ({ name, originalSize }: { name: string; originalSize: number }): boolean => {
    if (++count > MOST_FILES) throw new BadContainer(text.damaged);
    const isWanted = (LAYER.test(name) || PICTURE.test(name)) && !name.startsWith("__MACOSX/");
    if (isWanted) budget.take(originalSize);
    return isWanted;
  };
  return new Map(Object.entries(unzipSync(bytes, { filter })));
}

function layer(content: Uint8Array): unknown {
  const isCrate = new TextDecoder("latin1").decode(content.subarray(0, CRATE.length)) === CRATE;
  return isCrate ? new USDCParser().parseData(content.slice().buffer) : new USDAParser().parseData(new TextDecoder().decode(content));
}

let isQuiet = false;

/** From here on, for this worker: an "image" is the name of the picture that it stands for. */
function withoutPictures<Made>(make: () => Made): Made {
  if (!isQuiet) {
    ImageLoader.prototype.load = (address, done) => {
      const image = { name: address.startsWith(PLACE) ? address.slice(PLACE.length) : "" };
      done?.(image as unknown as HTMLImageElement);
      return image as unknown as HTMLImageElement;
    };
    isQuiet = true;
  }
  return make();
}

/** One for each material of a mesh. */
function plainMeshes(node: Mesh): PlainMesh[] {
  const { geometry, matrixWorld } = node;
  const places = geometry.getAttribute("position");
  const count = places.count;
  const order = geometry.index ? Uint32Array.from(geometry.index.array) : Uint32Array.from({ length: count }, (_, index) => index);
  const positions = new Float32Array(3 * count);
  const at = new Vector3();
  for (let i = 0; i < count; i++) at.fromBufferAttribute(places, i).applyMatrix4(matrixWorld).toArray(positions, 3 * i);
  if (matrixWorld.determinant() < 0) for (let i = 0; i < order.length; i += 3) [order[i + 1], order[i + 2]] = [order[i + 2]!, order[i + 1]!];
  const materials = [node.material].flat();
  const groups = Array.isArray(node.material) && geometry.groups.length > 0 ? geometry.groups : [{ start: 0, count: Infinity, materialIndex: 0 }];
  return groups.map(({ start, count: length, materialIndex }): PlainMesh => {
    const indices = order.subarray(start, Math.min(order.length, start + length));
    return { positions, indices: indices.slice(0, indices.length - (indices.length % 3)), ...coloured(node, materials[materialIndex ?? 0]) };
  });
}

function coloured({ geometry }: Mesh, material: Material | undefined): Pick<PlainMesh, "colours" | "uv" | "picture"> {
  const map = (material as MeshStandardMaterial | undefined)?.map ?? null;
  const channel = map && map.channel > 0 ? `uv${map.channel}` : "uv";
  const name = (map as Texture<{ name?: string }> | null)?.image.name;
  if (map && name && geometry.hasAttribute(channel)) return { uv: placed(map, geometry.getAttribute(channel)), picture: name };
  if (!geometry.hasAttribute("color")) return {};
  const colours = geometry.getAttribute("color");
  return { colours: Float32Array.from({ length: 3 * colours.count }, (_, i) => [colours.getX((i / 3) | 0), colours.getY((i / 3) | 0), colours.getZ((i / 3) | 0)][i % 3]!) };
}

/** Coordinates in the picture as glTF counts them, from the upper left. */
function placed(map: Texture, uv: { count: number }): Float32Array {
  map.updateMatrix();
  const toPicture = new Matrix3().copy(map.matrix);
  const at = new Vector2();
  const found = new Float32Array(2 * uv.count);
  for (let i = 0; i < uv.count; i++) {
    at.fromBufferAttribute(uv as never, i).applyMatrix3(toPicture);
    found[2 * i] = at.x;
    found[2 * i + 1] = 1 - at.y;
  }
  return found;
}
