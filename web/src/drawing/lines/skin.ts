// The scan's surface as the pen needs it: the nearest place on it, and where a needle would meet it.
// In millimetres outside, in the metres of the mesh within.
import { type BufferGeometry, DoubleSide, Ray, Vector3 } from "three";
import type { MeshBVH } from "three-mesh-bvh";
import type { Vector } from "../../api/types";
import { type BodyQuestion, bodyOf, type CutByService, NOTHING_CUT, partOf, type ScanParts } from "../../scan/body";
import { NO_CROPS } from "../../scan/crop";
import type { Drawable } from "../../scan/drawable";
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
  /** Whether a hand may draw there: on the patient, on the side of a triangle that looks out and to the eye; all in mm. */
  mayDraw(hit: { readonly face: number; readonly point: Vector }, eye: Vector): boolean;
}

type FoundParts = ScanParts & { readonly drawable: Drawable };

const toMetres = (at: Vector): Vector3 => new Vector3(metresFromMm(at[0]), metresFromMm(at[1]), metresFromMm(at[2]));
const toMm = (at: Vector3): Vector => [mmFromMetres(at.x), mmFromMetres(at.y), mmFromMetres(at.z)];
const REACH = 0.25; // metres that a needle goes to each side; half a torso

const questionOf = (whole: BufferGeometry, cut: CutByService): BodyQuestion => ({
  positions: whole.attributes.position!.array as Float32Array,
  index: Uint32Array.from(whole.index!.array),
  isSplit: whole.hasAttribute("uv"),
  cut,
  crops: NO_CROPS,
  wantsRelief: false,
});

/** The patient in a scan, found here and now. */
export function partsOf(whole: BufferGeometry, cut: CutByService): FoundParts {
  const { drawable, part } = bodyOf(questionOf(whole, cut));
  return { whole, drawable, body: part && partOf(whole, part) };
}

/** `whole` has an index and its BVH as `boundsTree`. */
export const skinOf = (whole: BufferGeometry, cut: CutByService = NOTHING_CUT): Skin => skinOn(partsOf(whole, cut));

export function skinOn({ whole, drawable, body }: FoundParts): Skin {
  const geometry = body ?? whole;
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
    mayDraw({ face, point }, eye) {
      if (body !== null && !drawable.isSkin[face]) return false;
      [a, b, c].forEach((corner, k) => corner.fromBufferAttribute(position, whole.index!.getX(3 * face + k)));
      const outwards = new Vector3().crossVectors(b.sub(a), c.sub(a)).multiplyScalar(drawable.outwards[face] ?? 1);
      return outwards.dot(toMetres(eye).sub(toMetres(point))) > 0;
    },
  };
}

/** The skin of whatever scan is on the screen; made once for each. */
export function skinFrom(parts: () => ScanParts | null, cut: () => CutByService = () => NOTHING_CUT): () => Skin | null {
  let made: { of: BufferGeometry; drawable: Drawable | null; skin: Skin } | null = null;
  return () => {
    const now = parts();
    if (!now) return null;
    const { whole, drawable, body } = now;
    // Who draws before the worker has answered does not wait for it.
    if (made?.of !== whole || made.drawable !== drawable) made = { of: whole, drawable, skin: drawable ? skinOn({ whole, drawable, body }) : skinOf(whole, cut()) };
    return made.skin;
  };
}
