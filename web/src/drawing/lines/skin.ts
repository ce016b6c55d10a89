// The scan's surface as the pen needs it: the nearest place on it, and where a needle would meet it.
// In millimetres outside, in the metres of the mesh within.
import { type BufferGeometry, DoubleSide, Ray, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import type { Vector } from "../../api/types";
import { metresFromMm, mmFromMetres } from "../../ui/units";

export interface OnSkin {
  readonly point: Vector;
  readonly normal: Vector; // unit, outwards
  readonly away: number; // mm from where it was looked for
}

export interface Skin {
  nearest(place: Vector): OnSkin;
  /** Along the line through `place` with this direction, the meeting nearest to it whose outside looks that way. */
  needle(place: Vector, direction: Vector): OnSkin | null;
  /** Whether a hand may draw there: on the side of a triangle that looks out and to the eye; all in mm. */
  mayDraw(hit: { readonly face: number; readonly point: Vector }, eye: Vector): boolean;
}

const toMetres = (at: Vector): Vector3 => new Vector3(metresFromMm(at[0]), metresFromMm(at[1]), metresFromMm(at[2]));
const toMm = (at: Vector3): Vector => [mmFromMetres(at.x), mmFromMetres(at.y), mmFromMetres(at.z)];
const REACH = 0.25; // metres that a needle goes to each side; half a torso

/** Of a surface that has an index and its BVH as `boundsTree`. */
export function skinOf(geometry: BufferGeometry): Skin {
  const bvh = geometry.boundsTree as MeshBVH;
  const index = geometry.index!;
  const position = geometry.attributes.position!;
  const [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];

  function normalOf(face: number): Vector3 {
    a.fromBufferAttribute(position, index.getX(3 * face));
    b.fromBufferAttribute(position, index.getX(3 * face + 1));
    c.fromBufferAttribute(position, index.getX(3 * face + 2));
    return new Vector3().crossVectors(b.sub(a), c.sub(a)).normalize();
  }

  return {
    nearest(place) {
      const from = toMetres(place);
      const found = bvh.closestPointToPoint(from);
      if (!found) throw new Error("the scan has no triangles");
      return { point: toMm(found.point), normal: normalOf(found.faceIndex).toArray(), away: mmFromMetres(found.distance) };
    },
    needle(place, direction) {
      const middle = toMetres(place);
      const along = new Vector3(...direction).normalize();
      const ray = new Ray(middle.clone().addScaledVector(along, REACH), along.clone().negate());
      let best: OnSkin | null = null;
      for (const hit of bvh.raycast(ray, DoubleSide)) {
        const away = mmFromMetres(hit.point.distanceTo(middle));
        if (away > mmFromMetres(REACH) || (best && best.away <= away)) continue;
        const normal = normalOf(hit.faceIndex!);
        if (normal.dot(along) > 0) best = { point: toMm(hit.point), normal: normal.toArray(), away };
      }
      return best;
    },
    mayDraw: ({ face, point }, eye) => normalOf(face).dot(toMetres(eye).sub(toMetres(point))) > 0,
  };
}

/** The skin of whatever scan is on the screen, once it can be picked on; made once for each. */
export function skinFrom(geometry: () => BufferGeometry | null): () => Skin | null {
  let made: { readonly of: unknown; readonly skin: Skin } | null = null;
  return () => {
    const now = geometry();
    if (!now?.boundsTree) return null;
    if (made?.of !== now.boundsTree) made = { of: now.boundsTree, skin: skinOf(now) };
    return made.skin;
  };
}
