// Two cameras that look at two bodies from the same side: the pose of one, expressed in its torso's frame, is the other's.
// All matrices are rigid and in metres; a torso's frame has the patient's left, up and front as axes.
import { MathUtils, Matrix4, Vector3 } from "three";
import type { Frame, Vector } from "../api/types";
import { frameFromPicks, type Picks, picksOf } from "../landmarks/picks";
import { metresFromMm } from "../ui/units";
import { leftOf } from "../viewer/frame";
import type { Workspace } from "./state";

export interface Pose {
  readonly eye: Vector3;
  readonly target: Vector3;
}

// The breastbone is the part of the trunk that keeps its shape from standing to supine; the belly is not.
const RIGID = ["suprasternal_notch", "mid_sternum", "xiphoid"];

function basis(frame: Frame, origin: Vector3): Matrix4 {
  return new Matrix4().makeBasis(new Vector3(...leftOf(frame)), new Vector3(...frame.up), new Vector3(...frame.front)).setPosition(origin);
}

/** Takes coordinates of the torso to the scan's own, from landmarks in millimetres; null when they say too little. */
export function torsoFromLandmarks(picks: Picks): Matrix4 | null {
  const frame = frameFromPicks(picks);
  const points = RIGID.flatMap((name) => (picks[name] ? [picks[name]] : []));
  if (!frame || points.length === 0) return null;
  const origin = points.reduce((sum, point) => sum.add(new Vector3(...point.map(metresFromMm))), new Vector3()).divideScalar(points.length);
  return basis(frame, origin);
}

/** By the fitted landmarks, or by those that were placed. */
export function torsoOf({ fit, picks }: Pick<Workspace, "fit" | "picks">): Matrix4 | null {
  const fitted = fit?.result ? torsoFromLandmarks(picksOf({ landmarks: fit.result.landmarks, unit: fit.result.scan.unit })) : null;
  return fitted ?? torsoFromLandmarks(picks.present);
}

/** Without landmarks the body stands upright by its frame, and its middle serves as origin. */
export const torsoFromFrame = (frame: Frame, middle: Vector): Matrix4 => basis(frame, new Vector3(...middle));

const STEEP = [0.1, 0.35] as const; // sines of the angle between the gaze and the vertical
const LEAST = 1e-4; // of these: a gaze along the vertical has no upper edge

/**
 * The pose of the second camera.  `world` takes each scan's coordinates to those of its view, `torso` those of its
 * torso to the scan's.
 *
 * Both views keep the vertical upright.  From above or below a torso that leans a few degrees more would stand turned by any
 * angle on the picture: there the second picture's upper edge is the first one's, and not the eye's exact place.
 */
export function linkedPose(pose: Pose, from: { world: Matrix4; torso: Matrix4 }, to: { world: Matrix4; torso: Matrix4 }): Pose {
  const across = new Matrix4().multiplyMatrices(from.world, from.torso).invert().premultiply(to.torso).premultiply(to.world);
  const [eye, target] = [pose.eye.clone().applyMatrix4(across), pose.target.clone().applyMatrix4(across)];
  const away = eye.distanceTo(target);
  const gaze = eye.clone().sub(target).divideScalar(away);
  const steep = 1 - MathUtils.smoothstep(Math.hypot(gaze.x, gaze.z), ...STEEP);
  if (steep > 0) {
    const upper = upperEdge(pose).transformDirection(across);
    const side = level(gaze).multiplyScalar(Math.hypot(gaze.x, gaze.z)).addScaledVector(level(upper), -gaze.y * Math.hypot(upper.x, upper.z)).normalize();
    side.multiplyScalar(Math.max(Math.hypot(gaze.x, gaze.z), LEAST)).setY(gaze.y);
    eye.copy(target).addScaledVector(gaze.lerp(side, steep).normalize(), away);
  }
  return { eye, target };
}

/** Unit vector, horizontal; to the front for what is vertical. */
const level = ({ x, z }: Vector3): Vector3 => (Math.hypot(x, z) < 1e-9 ? new Vector3(0, 0, 1) : new Vector3(x, 0, z).normalize());

/** Unit vector to the upper edge of what the camera sees, in its view's axes. */
function upperEdge({ eye, target }: Pose): Vector3 {
  const gaze = eye.clone().sub(target).normalize();
  return level(gaze).multiplyScalar(-gaze.y).setY(Math.hypot(gaze.x, gaze.z));
}
