// A point on a mesh as (face, barycentric): where it is, and which way the surface looks there, for any posed vertices.
import { type BufferGeometry, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import type { SurfacePoint } from "../../api/types";

export type VertexAt = (vertex: number, target: Vector3) => Vector3;

const a = new Vector3();
const b = new Vector3();
const c = new Vector3();

export function surfacePosition(
  point: SurfacePoint,
  index: ArrayLike<number>,
  vertexAt: VertexAt,
  position: Vector3,
  normal: Vector3,
): void {
  const corner = 3 * point.face;
  if (corner < 0 || corner + 2 >= index.length) throw new Error(`the mesh has no triangle ${point.face}`);
  vertexAt(index[corner]!, a);
  vertexAt(index[corner + 1]!, b);
  vertexAt(index[corner + 2]!, c);
  const [u, v, w] = point.barycentric;
  position.set(0, 0, 0).addScaledVector(a, u).addScaledVector(b, v).addScaledVector(c, w);
  normal.crossVectors(b.sub(a), c.sub(a)).normalize();
}

/** Unit normal of the triangle nearest to a point, of a geometry that has its BVH. */
export function nearestNormal(geometry: BufferGeometry, point: Vector3): Vector3 | null {
  const face = (geometry.boundsTree as MeshBVH | undefined)?.closestPointToPoint(point)?.faceIndex;
  if (face === undefined) return null;
  const { index, attributes } = geometry;
  const [a, b, c] = [0, 1, 2].map((corner) => new Vector3().fromBufferAttribute(attributes.position!, index!.getX(3 * face + corner)));
  return b!.sub(a!).cross(c!.sub(a!)).normalize();
}
