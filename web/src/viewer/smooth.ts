// Lines of drawing files as the curves that they stand for: a point every few millimetres shows its corners when one comes near.
// Between neighbours runs a Catmull-Rom curve; where a line turns sharply that is meant, as in a keyhole pattern, and the
// corner stays.
import { Vector3 } from "three";
import type { Polyline } from "./lines/FatLines";

const PIECES = 4; // of each segment
const CORNER = Math.cos((35 * Math.PI) / 180); // sharper turns are corners

export function smoothed(line: Polyline): Polyline {
  const count = line.points.length / 3;
  if (count < 3) return line;
  const at = (i: number): Vector3 => new Vector3().fromArray(line.points, 3 * ((i + count) % count));
  const hasBoth = (i: number): boolean => line.isClosed || (i > 0 && i < count - 1);
  /** How the curve runs through a point, by one segment's length; null at a corner. */
  const tangent = (i: number): Vector3 | null => {
    if (!hasBoth(i)) return null;
    const [before, after] = [at(i).sub(at(i - 1)), at(i + 1).sub(at(i))];
    const [a, b] = [before.length(), after.length()];
    if (a === 0 || b === 0 || before.dot(after) < CORNER * a * b) return null;
    return before.divideScalar(a).add(after.divideScalar(b)).normalize();
  };
  const tangents = Array.from({ length: count }, (_, i) => tangent(i));
  const points: number[] = [];
  const bridged: boolean[] = [];
  for (let i = 0; i < count; i += 1) {
    const isLast = i === count - 1 && !line.isClosed;
    const [p, q] = [at(i), at(i + 1)];
    points.push(...p.toArray());
    bridged.push(line.bridged?.[i] ?? false);
    if (isLast) continue;
    const next = (i + 1) % count;
    const chord = q.clone().sub(p);
    const length = chord.length();
    const [u, v] = [(tangents[i] ?? chord.clone().divideScalar(length || 1)).clone().multiplyScalar(length), (tangents[next] ?? chord.clone().divideScalar(length || 1)).clone().multiplyScalar(length)];
    const isBridged = (line.bridged?.[i] ?? false) || (line.bridged?.[next] ?? false);
    for (let piece = 1; piece < PIECES; piece += 1) {
      const t = piece / PIECES;
      const [t2, t3] = [t * t, t * t * t];
      const place = p.clone().multiplyScalar(2 * t3 - 3 * t2 + 1).addScaledVector(u, t3 - 2 * t2 + t).addScaledVector(q, 3 * t2 - 2 * t3).addScaledVector(v, t3 - t2);
      points.push(...place.toArray());
      bridged.push(isBridged);
    }
  }
  return { ...line, points: new Float32Array(points), bridged: line.bridged ? bridged : null };
}
