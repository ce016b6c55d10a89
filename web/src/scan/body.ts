// A scan's search tree and rims, and the patient's triangles, apart from those of the table and of loose pieces.
// It takes longer than reading the scan does, so a worker makes it; what it hands over are plain buffers, made once for each scan.
import { BufferAttribute, BufferGeometry } from "three";
import { MeshBVH, type SerializedBVH } from "three-mesh-bvh";
import type { CutPlane, Scan, Vector } from "../api/types";
import { borderEdges } from "./borders";
import { croppedFaces, type Crops } from "./crop";
import { type Drawable, drawableOf, type TablePlane } from "./drawable";
import { reliefOf } from "./relief";

/** What picking and drawing need of a surface. */
export interface Outline {
  readonly tree: SerializedBVH; // without its index, which is the surface's
  readonly rims: Float32Array; // as of borderEdges
}

export interface Body {
  readonly drawable: Drawable;
  /** null where all of the scan is the patient, or nothing is */
  readonly part: BodyPart | null;
  /** by vertex, see relief.ts; null: not asked for */
  readonly relief: Uint8Array | null;
}

export interface BodyPart extends Outline {
  readonly index: Uint32Array; // the patient's triangles, of the scan's vertices
  readonly faces: Uint32Array; // which of the scan's triangles each of them is
}

/** The whole scan, and the patient in it: a separate surface where there is anything else. */
export interface ScanParts {
  readonly whole: BufferGeometry;
  readonly drawable: Drawable | null; // not known yet
  readonly body: BufferGeometry | null;
}

/** What the worker is asked; metres in the scan's own axes. */
export interface BodyQuestion {
  readonly positions: Float32Array;
  readonly index: Uint32Array;
  readonly isSplit: boolean; // vertices may stand several times at one place
  readonly cut: CutByService;
  readonly crops: Crops; // hidden by hand
  readonly wantsRelief: boolean; // nothing but its shape is there to see
}

/** What the service has found to be no patient. */
export interface CutByService {
  readonly table: TablePlane | null;
  readonly background: readonly CutPlane[]; // floors and walls
  readonly others: readonly Vector[]; // a place on each piece beside the patient
}

export const NOTHING_CUT: CutByService = { table: null, background: [], others: [] };

export type Surface = Pick<BodyQuestion, "positions" | "index" | "isSplit">;

const BACKGROUND_BAND = 0.015; // metres: its noise, and more than the service's own band

/** Where the service names no table: the direction that a supine patient's table would face. */
export function cutByService(info: Pick<Scan, "stance" | "frame" | "table" | "background" | "other_pieces">): CutByService {
  const guess = info.stance.proposed === "supine" ? { normal: info.frame.front, height: null } : null;
  const table = info.table ? { normal: info.table.normal, height: info.table.height_m } : guess;
  return { table, background: info.background ?? [], others: info.other_pieces ?? [] };
}

export function outlineOf({ positions, index, isSplit }: Surface): Outline {
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(index, 1));
  const tree = MeshBVH.serialize(new MeshBVH(geometry, { indirect: true }), { cloneBuffers: false });
  tree.index = null; // whoever asks has it
  return { tree, rims: borderEdges(positions, index, isSplit) };
}

/** Gives a surface the tree that was made of it. */
export function setTree(geometry: BufferGeometry, { tree }: Outline): void {
  geometry.boundsTree = MeshBVH.deserialize(tree, geometry, { setIndex: false });
}

/** What is hidden by hand is no skin either, unless that were all of it. */
function without(hidden: Uint8Array, drawable: Drawable): Drawable {
  const isSkin = drawable.isSkin.map((is, face) => (hidden[face] ? 0 : is));
  const count = isSkin.reduce((sum, is) => sum + is, 0);
  return count === 0 ? drawable : { ...drawable, isSkin, count };
}

/** By triangle: 1 where it touches a floor or wall, or lies behind it. */
export function backgroundFaces(positions: ArrayLike<number>, index: ArrayLike<number>, planes: readonly CutPlane[]): Uint8Array {
  const found = new Uint8Array(index.length / 3);
  for (const { normal, height_m } of planes) {
    for (let i = 0; i < index.length; i += 1) {
      const at = 3 * index[i]!;
      const height = positions[at]! * normal[0] + positions[at + 1]! * normal[1] + positions[at + 2]! * normal[2] - height_m;
      if (height < BACKGROUND_BAND) found[(i / 3) | 0] = 1;
    }
  }
  return found;
}

/** The triangles that are left, as a scan of their own: each piece is judged beside them and not beside a wall. */
function drawableWithout(background: Uint8Array, positions: ArrayLike<number>, index: Uint32Array, { table, others }: CutByService): Drawable {
  if (!background.includes(1)) return drawableOf(positions, index, table, others);
  const kept = index.filter((_, i) => !background[(i / 3) | 0]);
  const left = drawableOf(positions, kept, table, others);
  let next = 0;
  const [isSkin, outwards] = [new Uint8Array(background.length), new Int8Array(background.length).fill(1)];
  background.forEach((is, face) => {
    if (is) return;
    isSkin[face] = left.isSkin[next]!;
    outwards[face] = left.outwards[next]!;
    next += 1;
  });
  return { ...left, isSkin, outwards };
}

export function bodyOf({ positions, index, isSplit, cut, crops, wantsRelief }: BodyQuestion): Body {
  const relief = wantsRelief ? reliefOf(positions, index) : null;
  const drawable = without(croppedFaces(positions, index, crops), drawableWithout(backgroundFaces(positions, index, cut.background), positions, index, cut));
  const { isSkin, count } = drawable;
  if (count === 0 || count === isSkin.length) return { drawable, relief, part: null };
  const [hers, faces] = [new Uint32Array(3 * count), new Uint32Array(count)];
  let next = 0;
  isSkin.forEach((is, face) => {
    if (!is) return;
    hers.set(index.subarray(3 * face, 3 * face + 3), 3 * next);
    faces[next] = face;
    next += 1;
  });
  return { drawable, relief, part: { index: hers, faces, ...outlineOf({ positions, index: hers, isSplit }) } };
}

/** The corners of those triangles that are 1. */
export const indexOf = (index: ArrayLike<number>, faces: Uint8Array): Uint32Array => Uint32Array.from(index).filter((_, i) => faces[(i / 3) | 0]);

/** The scan's surface with the patient's triangles only; it shares the vertices of the whole. */
export function partOf(whole: BufferGeometry, hers: BodyPart): BufferGeometry {
  const part = new BufferGeometry();
  for (const [name, attribute] of Object.entries(whole.attributes)) part.setAttribute(name, attribute);
  part.setIndex(new BufferAttribute(hers.index, 1));
  part.boundingSphere = whole.boundingSphere; // as large at most; over all vertices it would take as long as a frame may
  setTree(part, hers);
  return part;
}
