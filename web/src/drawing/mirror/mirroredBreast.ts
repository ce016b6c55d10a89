// The left breast laid on the right: its fitted skin mirrored in the patient's plane of symmetry, and how far each place of it
// stands out beyond the skin that is there.  A picture of asymmetry, not a verdict: nearly every woman has some.
import { type BufferGeometry, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import type { Result, Vector } from "../../api/types";
import { picksOf } from "../../landmarks/picks";
import { metresFromMm, mmFromMetres } from "../../ui/units";
import { dot } from "../../viewer/frame";
import { nearestNormal } from "../../viewer/lines/surfacePoints";
import { type MirrorPlane, mirroredPoint, mirrorPlane } from "./mirror";

const FADE = 0.2; // of that reach, in which it fades
const REACH = 0.95; // of the nipple's distance from the plane: nearly to the midline, and not out onto the arm

export interface MirroredBreast {
  /** x y z in a row, metres, scan's axes */
  readonly positions: Float32Array;
  readonly index: Uint32Array;
  /** by vertex, mm along the normal: above zero where the left stands out farther than the right */
  readonly beyond: Float32Array;
  /** by vertex: 1 on the breast, going to 0 at the rim of what was cut out, which is nobody's shape */
  readonly share: Float32Array;
}

export interface Asymmetry {
  readonly medianMm: number; // of the amounts
  readonly mostMm: number; // with 95 % below it: single vertices at the patch's rim say little
}

/** `fitted` has its tree; null where the result has no nipples or no plane. */
export function mirroredBreast(fitted: BufferGeometry, result: Pick<Result, "landmarks" | "median_plane" | "scan">): MirroredBreast | null {
  const plane = mirrorPlane(result);
  const nipple = picksOf({ landmarks: result.landmarks, unit: result.scan.unit }).nipple_L;
  if (!plane || !nipple) return null;
  const from = heightOver(plane, nipple);
  const position = fitted.attributes.position!;
  const at = (vertex: number): Vector => [mmFromMetres(position.getX(vertex)), mmFromMetres(position.getY(vertex)), mmFromMetres(position.getZ(vertex))];
  const inwards = Array.from({ length: position.count }, (_, vertex) => {
    const point = at(vertex);
    const away = Math.hypot(point[0] - nipple[0], point[1] - nipple[1], point[2] - nipple[2]);
    return Math.min(heightOver(plane, point), REACH * from - away); // mm from the rim
  });
  const isOfBreast = inwards.map((mm) => mm > 0);
  const numbers = new Map<number, number>();
  const index: number[] = [];
  const all = fitted.index!.array;
  const numberOf = (vertex: number): number => {
    let number = numbers.get(vertex);
    if (number === undefined) numbers.set(vertex, (number = numbers.size));
    return number;
  };
  const skin = fitted.groups[0]?.count ?? all.length; // the lids come after it, see viewer/openings.ts
  for (let i = 0; i < skin; i += 3) {
    const [a, b, c] = [all[i]!, all[i + 1]!, all[i + 2]!];
    if (isOfBreast[a] && isOfBreast[b] && isOfBreast[c]) index.push(numberOf(a), numberOf(c), numberOf(b)); // a mirror turns triangles round
  }
  if (index.length === 0) return null;
  const positions = new Float32Array(3 * numbers.size);
  const [beyond, share] = [new Float32Array(numbers.size), new Float32Array(numbers.size)];
  for (const [vertex, number] of numbers) {
    const place = new Vector3(...mirroredPoint(plane, at(vertex)).map(metresFromMm));
    place.toArray(positions, 3 * number);
    beyond[number] = signedGap(fitted, place);
    share[number] = Math.min(1, inwards[vertex]! / (FADE * REACH * from));
  }
  return { positions, index: Uint32Array.from(index), beyond, share };
}

const heightOver = ({ normal, offset }: MirrorPlane, point: Vector): number => dot(point, normal) - offset;

/** mm from the nearest skin, above zero outside. */
function signedGap(fitted: BufferGeometry, place: Vector3): number {
  const found = (fitted.boundsTree as MeshBVH).closestPointToPoint(place)!;
  const outwards = nearestNormal(fitted, place)!;
  const off = place.clone().sub(found.point);
  return mmFromMetres(off.length()) * (off.dot(outwards) < 0 ? -1 : 1);
}

export function asymmetryOf({ beyond }: Pick<MirroredBreast, "beyond">): Asymmetry {
  const sorted = Array.from(beyond, Math.abs).sort((a, b) => a - b);
  const at = (share: number): number => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
  return { medianMm: at(0.5), mostMm: at(0.95) };
}
