// Which points of a line are seen, and the outline of the body: only what faces the eye and is not behind something.
import { type BufferGeometry, DoubleSide, Ray, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import type { Vector } from "../api/types";
import { metresFromMm, mmFromMetres } from "../ui/units";
import { nearestNormal } from "../viewer/lines/surfacePoints";
import { type Camera, towardsEye } from "./camera";

const AVERTED = -0.1; // cosine; a rim seen from the side still counts as seen
const SLACK = 0.006; // metres that a point may lie under the skin and still count as seen

/** `skin`, metres, has its tree as `boundsTree`. */
export function isSeen(skin: BufferGeometry, camera: Camera, point: Vector): boolean {
  const at = new Vector3(...point.map(metresFromMm));
  const to = new Vector3(...towardsEye(camera, point));
  const normal = nearestNormal(skin, at);
  return !(normal && normal.dot(to) < AVERTED) && isFree(skin, at, to);
}

/** Nothing of the surface lies between the point and the eye. */
const isFree = (skin: BufferGeometry, at: Vector3, to: Vector3): boolean =>
  (skin.boundsTree as MeshBVH).raycastFirst(new Ray(at.clone().addScaledVector(to, SLACK), to), DoubleSide) === null;

/** Edges between a triangle that faces the eye and one that does not, or with one triangle that does; mm, where they are seen. */
export function outlineOf(body: BufferGeometry, camera: Camera): [Vector, Vector][] {
  const position = body.attributes.position!;
  const index = body.index!.array;
  const at = (vertex: number): Vector => [mmFromMetres(position.getX(vertex)), mmFromMetres(position.getY(vertex)), mmFromMetres(position.getZ(vertex))];
  const edges = new Map<number, { readonly ends: [number, number]; readonly facing: boolean[] }>();
  const count = position.count;
  const [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];
  for (let corner = 0; corner < index.length; corner += 3) {
    a.fromBufferAttribute(position, index[corner]!);
    b.fromBufferAttribute(position, index[corner + 1]!);
    c.fromBufferAttribute(position, index[corner + 2]!);
    const to = towardsEye(camera, at(index[corner]!));
    const isFacing = b.sub(a).cross(c.sub(a)).dot(new Vector3(...to)) > 0;
    for (let k = 0; k < 3; k += 1) {
      const [one, other] = [index[corner + k]!, index[corner + ((k + 1) % 3)]!];
      const key = Math.min(one, other) * count + Math.max(one, other);
      const edge = edges.get(key);
      if (edge) edge.facing.push(isFacing);
      else edges.set(key, { ends: [one, other], facing: [isFacing] });
    }
  }
  const rims = [...edges.values()].filter(({ facing }) => (facing.length > 1 ? facing[0] !== facing[1] : facing[0]));
  // On the rim itself every triangle is seen from the side.
  const isSeenRim = (point: Vector): boolean => isFree(body, new Vector3(...point.map(metresFromMm)), new Vector3(...towardsEye(camera, point)));
  return rims.map(({ ends: [one, other] }): [Vector, Vector] => [at(one), at(other)]).filter(([one]) => isSeenRim(one));
}
