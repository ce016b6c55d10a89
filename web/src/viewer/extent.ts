// How large the body is as seen upright, without letting a few stray fragments of a scan decide.
import { Box3, type Matrix4, Vector3 } from "three";

const SAMPLES = 20000;
const STRAY = 0.004; // share of the points at each end of an axis that may lie outside

/** Box, in the axes that `turn` leads to, around nearly all of the points (x y z in a row), or of those that `used` names. */
export function extent(positions: ArrayLike<number>, turn: Matrix4, used: ArrayLike<number> | null = null): Box3 {
  const count = used?.length ?? positions.length / 3;
  const step = Math.max(1, Math.floor(count / SAMPLES));
  const taken = Math.ceil(count / step);
  const axes = [new Float64Array(taken), new Float64Array(taken), new Float64Array(taken)] as const; // sorted without asking a function
  const point = new Vector3();
  for (let i = 0; i < taken; i += 1) {
    const at = 3 * (used?.[i * step] ?? i * step);
    point.set(positions[at]!, positions[at + 1]!, positions[at + 2]).applyMatrix4(turn);
    axes[0][i] = point.x;
    axes[1][i] = point.y;
    axes[2][i] = point.z;
  }
  for (const axis of axes) axis.sort();
  const at = (share: number): Vector3 =>
    new Vector3(...axes.map((axis) => axis[Math.round(share * (axis.length - 1))] ?? 0));
  return new Box3(at(STRAY), at(1 - STRAY));
}
