// From a place on the screen to a point on the scan: pointer → ray → BVH → triangle.
import { type Mesh, Raycaster, Triangle, Vector3 } from "three";
import type { Vector } from "../api/types";
import { mmFromMetres } from "../ui/units";
import type { Viewer } from "./Viewer";

/** What can be pointed at: a mesh with its BVH, in the axes of the scan; null until it is there. */
export interface Surface {
  readonly mesh: Mesh | null;
  /** Unit vector out of the surface nearest to a point (scan's frame, metres). */
  normalAt(point: Vector3): Vector3 | null;
}

export interface Hit {
  /** scan's frame, millimetres, as landmarks are stored */
  point: Vector;
  face: number;
}

const raycaster = new Raycaster();
raycaster.firstHitOnly = true;

/** `clientX`, `clientY` as in pointer events; null beside the scan. */
export function pickAt(viewer: Viewer, scan: Surface, clientX: number, clientY: number): Hit | null {
  if (!scan.mesh) return null;
  const at = viewer.toCamera(clientX, clientY);
  viewer.scene.updateMatrixWorld();
  raycaster.setFromCamera(at, viewer.camera);
  const hit = raycaster.intersectObject(scan.mesh, false)[0];
  if (!hit) return null;
  const point = viewer.body.worldToLocal(hit.point.clone());
  return { point: point.toArray().map(mmFromMetres) as Vector, face: hit.faceIndex ?? -1 };
}

/** A place on the fitted surface: the corners of its triangle and their shares. */
export interface SurfaceHit {
  corners: [number, number, number];
  weights: [number, number, number];
}

/** What of the fitted surface lies under page pixels; null beside it. */
export function surfaceAt(viewer: Viewer, surface: Mesh | null, clientX: number, clientY: number): SurfaceHit | null {
  const at = viewer.toCamera(clientX, clientY);
  if (!surface?.visible) return null;
  viewer.scene.updateMatrixWorld();
  raycaster.setFromCamera(at, viewer.camera);
  const hit = raycaster.intersectObject(surface, false)[0];
  if (!hit?.face) return null;
  const corners: SurfaceHit["corners"] = [hit.face.a, hit.face.b, hit.face.c];
  const [a, b, c] = corners.map((corner) => new Vector3().fromBufferAttribute(surface.geometry.attributes.position!, corner));
  const weights = Triangle.getBarycoord(viewer.body.worldToLocal(hit.point.clone()), a!, b!, c!, new Vector3());
  return weights ? { corners, weights: weights.toArray() } : null;
}

const AVERTED = 0.25; // cosine; a rim seen from the side still counts as seen
const SLACK = 0.006; // metres that a point may lie under the surface and still count as seen

/**
 * True when the scan stands between the eye and the point (scan's frame, metres), or when the skin there looks away:
 * through the holes of a scan its far side would seem near.
 */
export function isHidden(viewer: Pick<Viewer, "body" | "camera">, scan: Surface, point: Vector3, normal: Vector3 | null): boolean {
  if (!scan.mesh) return false;
  const target = viewer.body.localToWorld(point.clone());
  const away = target.sub(viewer.camera.position);
  const distance = away.length();
  const outwards = normal?.clone().transformDirection(viewer.body.matrixWorld);
  if (outwards && outwards.dot(away) > AVERTED * distance) return true;
  if (!scan.mesh.geometry.boundsTree) return false; // not yet: without its tree a look through a million triangles stops the page
  raycaster.set(viewer.camera.position, away.normalize());
  const hit = raycaster.intersectObject(scan.mesh, false)[0];
  return hit !== undefined && hit.distance < distance - SLACK;
}
