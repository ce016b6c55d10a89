// Changing a line by its corners.  A line is cut at them into parts; what is not touched stays point by point.
import type { Vector } from "../../api/types";
import { gap, guessedAt, type OwnLine } from "./lines";
import type { Skin } from "./skin";
import { cornersOf, evenly, onSkin, way } from "./strokes";

const EVEN_ROUNDS = 12; // of a binomial of width 2: evens out over some ten millimetres

/** From corner to corner, both ends in each part. */
type Part = readonly Vector[];

export function partsOf({ points, corners, closed }: OwnLine): Part[] {
  const parts = corners.slice(1).map((to, i) => points.slice(corners[i], to + 1));
  if (closed && corners.length > 0) parts.push([...points.slice(corners.at(-1)), ...points.slice(0, corners[0]! + 1)]);
  return parts;
}

function joined(line: OwnLine, parts: readonly Part[], closed = line.closed): OwnLine {
  const points: Vector[] = [];
  const corners: number[] = [];
  for (const part of parts) {
    corners.push(points.length);
    points.push(...part.slice(0, -1));
  }
  if (!closed && parts.length > 0) {
    corners.push(points.length);
    points.push(parts.at(-1)!.at(-1)!);
  }
  // What was guessed stays a guess where nobody has touched it; what a hand has moved lies on the skin.
  const { bridged, ...rest } = line;
  const guessed = new Set(line.points.filter((_, i) => bridged?.[i]));
  return guessedAt({ ...rest, closed, points, corners }, points.map((point) => guessed.has(point)));
}

export const cornerAt = (line: OwnLine, corner: number): Vector => line.points[line.corners[corner]!]!;

/** A new line through two clicks. */
export function lineThrough(skin: Skin, name: string, color: string, a: Vector, b: Vector): OwnLine {
  return joined({ name, color, closed: false, points: [], corners: [] }, [way(skin, a, b)]);
}

export function lineAlong(name: string, color: string, points: readonly Vector[], closed: boolean, bridged?: readonly boolean[] | null): OwnLine {
  return guessedAt({ name, color, closed, points, corners: cornersOf(points, closed) }, bridged);
}

/** Goes on from the line's end. */
export const extended = (skin: Skin, line: OwnLine, to: Vector): OwnLine => joined(line, [...partsOf(line), way(skin, line.points.at(-1)!, to)]);

export function closedUp(skin: Skin, line: OwnLine): OwnLine {
  if (line.closed || line.corners.length < 2) return line;
  return joined(line, [...partsOf(line), way(skin, line.points.at(-1)!, line.points[0]!)], true);
}

/** A closed line is opened again: its last part goes. */
export const openedUp = (line: OwnLine): OwnLine => (line.closed && line.corners.length > 2 ? joined(line, partsOf(line).slice(0, -1), false) : line);

/** The corner goes to `to`; both parts beside it follow on the skin, the less the farther away. */
export function cornerMoved(skin: Skin, line: OwnLine, corner: number, to: Vector): OwnLine {
  const from = cornerAt(line, corner);
  const shift: Vector = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
  const parts = partsOf(line);
  const before = corner > 0 ? corner - 1 : line.closed ? parts.length - 1 : -1;
  const after = corner < parts.length ? corner : -1;
  if (before === after) return line; // closed with a single corner: nothing that could follow
  if (before >= 0) parts[before] = follow(skin, parts[before]!, shift, false);
  if (after >= 0) parts[after] = follow(skin, parts[after]!, shift, true);
  return joined(line, parts);
}

const difference = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** One end of the part is shifted, the other stays. */
function follow(skin: Skin, part: Part, shift: Vector, isStart: boolean): Part {
  const count = Math.max(1, part.length - 1);
  const moved = part.map((point, i): Vector => {
    const share = isStart ? 1 - i / count : i / count;
    return [point[0] + share * shift[0], point[1] + share * shift[1], point[2] + share * shift[2]];
  });
  const [first, last] = [part[0]!, part.at(-1)!];
  // Where the skin bends, neighbours may come down on different sides of a fold: how far each went is evened out.
  let went = moved.map((point, i) => difference(skin.nearest(point).point, part[i]!));
  for (let round = 0; round < EVEN_ROUNDS; round += 1) {
    went = went.map((way, i) => {
      const [before, after] = [went[i - 1], went[i + 1]];
      return before && after ? [0, 1, 2].map((k) => (before[k]! + 2 * way[k]! + after[k]!) / 4) as Vector : way;
    });
  }
  const laid = onSkin(skin, part.map((point, i): Vector => [point[0] + went[i]![0], point[1] + went[i]![1], point[2] + went[i]![2]]));
  if (isStart) laid[laid.length - 1] = last;
  else laid[0] = first;
  return laid.length > 1 ? laid : [laid[0] ?? first, isStart ? last : (laid[0] ?? last)];
}

/** Without that corner the line goes straight from its neighbour to the next; null when nothing is left. */
export function cornerRemoved(skin: Skin, line: OwnLine, corner: number): OwnLine | null {
  const parts = partsOf(line);
  const isEnd = !line.closed && (corner === 0 || corner === parts.length);
  if (parts.length < (line.closed ? 3 : 2)) return null;
  if (isEnd) return joined(line, corner === 0 ? parts.slice(1) : parts.slice(0, -1));
  const before = corner > 0 ? corner - 1 : parts.length - 1;
  const straight = way(skin, parts[before]![0]!, parts[corner]!.at(-1)!);
  if (corner === 0) return joined(line, [...parts.slice(1, -1), straight]);
  return joined(line, [...parts.slice(0, before), straight, ...parts.slice(corner + 1)]);
}

/** A new corner at the line's point nearest to `at`; says which one it is. */
export function cornerAdded(line: OwnLine, at: Vector): { line: OwnLine; corner: number } {
  const nearest = line.points.reduce((best, point, i) => (gap(point, at) < gap(line.points[best]!, at) ? i : best), 0);
  const corners = [...new Set([...line.corners, nearest])].sort((one, other) => one - other);
  return { line: { ...line, corners }, corner: corners.indexOf(nearest) };
}

/** For the picture: over a hole there are points in a straight row, marked as not on the skin; `guessed` are those that are it already. */
export function bridgedAt(points: readonly Vector[], closed: boolean, longest: number, guessed?: readonly boolean[]): { points: Vector[]; bridged: boolean[] } {
  const out: { points: Vector[]; bridged: boolean[] } = { points: [], bridged: [] };
  points.forEach((point, i) => {
    out.points.push(point);
    out.bridged.push(guessed?.[i] ?? false);
    const next = points[i + 1] ?? (closed ? points[0] : undefined);
    if (!next || gap(point, next) <= longest) return;
    const inside = evenly([point, next]).slice(1, -1);
    out.points.push(...inside);
    out.bridged.push(...inside.map(() => true));
  });
  return out;
}
