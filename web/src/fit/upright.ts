// How the patient stands by the fitted rig: its bones along the spine have axes of their own, which no belly or breast tilts.
import type { Frame, Result, Vector } from "../api/types";
import { tidyFrame } from "../viewer/frame";

/** Where a bone's rotation (x, y, z, w) takes a unit vector of the body's axes: +Y head, +Z front. */
function turned([x, y, z, w]: readonly [number, number, number, number], [a, b, c]: Vector): Vector {
  const [u, v, t] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * u + y * t - z * v, b + w * v + z * u - x * t, c + w * t + x * v - y * u];
}

/** The mean of the bones without a side; null where a result of another version has none. */
export function frameOfRig(result: Pick<Result, "parameters"> | { readonly parameters?: undefined }): Frame | null {
  const bones = (result.parameters?.bones ?? []).filter(({ name }) => !/_[LR]$/.test(name));
  if (bones.length === 0) return null;
  const along = (axis: Vector): Vector =>
    bones.map(({ rotation_xyzw: q }) => turned(q, axis)).reduce<Vector>((sum, each) => [sum[0] + each[0], sum[1] + each[1], sum[2] + each[2]], [0, 0, 0]);
  return tidyFrame({ up: along([0, 1, 0]), front: along([0, 0, 1]) });
}
