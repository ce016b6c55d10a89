// From a place on the screen to a point on the scan: pointer → ray → BVH → triangle.
import { Raycaster, Vector2, Vector3 } from "three";
import type { Vector } from "../api/types";
import { mmFromMetres } from "../units";
import type { ScanMesh } from "./ScanMesh";
import type { Viewer } from "./Viewer";

export interface Hit {
  /** scan's frame, millimetres, as landmarks are stored */
  point: Vector;
  face: number;
}

const raycaster = new Raycaster();
raycaster.firstHitOnly = true;

/** `clientX`, `clientY` as in pointer events; null beside the scan. */
export function pickAt(viewer: Viewer, scan: ScanMesh, clientX: number, clientY: number): Hit | null {
  if (!scan.mesh) return null;
  const box = viewer.host.getBoundingClientRect();
  const at = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
  viewer.scene.updateMatrixWorld();
  raycaster.setFromCamera(at, viewer.camera);
  const hit = raycaster.intersectObject(scan.mesh, false)[0];
  if (!hit) return null;
  const point = viewer.body.worldToLocal(hit.point.clone());
  return { point: point.toArray().map(mmFromMetres) as Vector, face: hit.faceIndex ?? -1 };
}

const AVERTED = 0.25; // cosine; a rim seen from the side still counts as seen
const SLACK = 0.006; // metres that a point may lie under the surface and still count as seen

/**
 * True when the scan stands between the eye and the point (scan's frame, metres), or when the skin there looks away:
 * through the holes of a scan its far side would seem near.
 */
export function isHidden(viewer: Viewer, scan: ScanMesh, point: Vector3, normal: Vector3 | null): boolean {
  if (!scan.mesh) return false;
  const target = viewer.body.localToWorld(point.clone());
  const away = target.sub(viewer.camera.position);
  const distance = away.length();
  const outwards = normal?.clone().transformDirection(viewer.body.matrixWorld);
  if (outwards && outwards.dot(away) > AVERTED * distance) return true;
  raycaster.set(viewer.camera.position, away.normalize());
  const hit = raycaster.intersectObject(scan.mesh, false)[0];
  return hit !== undefined && hit.distance < distance - SLACK;
}
