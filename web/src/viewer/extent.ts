// How large the body is as seen upright, without letting a few stray fragments of a scan decide.
import { Box3, type Matrix4, Vector3 } from "three";

const SAMPLES = 20000;
const STRAY = 0.004; // share of the points at each end of an axis that may lie outside

/** Box, in the axes that `turn` leads to, around nearly all of the points (x y z in a row), or of those that `used` names. */
export function extent(positions: ArrayLike<number>, turn: Matrix4, used: ArrayLike<number> | null = null): Box3 {
  const count = used?.length ?? positions.length / 3;
  const step = Math.max(1, Math.floor(count / SAMPLES));
  const axes: [number[], number[], number[]] = [[], [], []];
  const point = new Vector3();
  for (let i = 0; i < count; i += step) {
    const at = 3 * (used?.[i] ?? i);
    point.set(positions[at]!, positions[at + 1]!, positions[at + 2]).applyMatrix4(turn);
    axes[0].push(point.x);
    axes[1].push(point.y);
    axes[2].push(point.z);
  }
  for (const axis of axes) axis.sort((a, b) => a - b);
  const at = (share: number): Vector3 =>
    new Vector3(...axes.map((axis) => axis[Math.round(share * (axis.length - 1))] ?? 0));
  return new Box3(at(STRAY), at(1 - STRAY));
}
