// Lines on the skin, on bodies whose true distances are known: a sphere, a plate with a hole.
import { BufferGeometry, Float32BufferAttribute, PlaneGeometry, SphereGeometry, Vector3 } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { expect, test } from "vitest";
import type { Vector } from "../../src/api/types";
import { bridgedAt, closedUp, cornerAdded, cornerAt, cornerMoved, cornerRemoved, extended, lineAlong, lineThrough, openedUp, partsOf } from "../../src/drawing/lines/edits";
import { gap, INK, lengthOf, type OwnLine } from "../../src/drawing/lines/lines";
import { type Skin, skinOf } from "../../src/drawing/lines/skin";
import { BRIDGE_MM, circle, cornersOf, evenly, freehand, STEP_MM, way } from "../../src/drawing/lines/strokes";

const RADIUS = 100; // mm
const CHORD = 0.05; // mm that a facet of the sphere lies under it: 100 (1 - cos(pi / 128)) would be 0.03

function withTree(geometry: BufferGeometry): Skin {
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  return skinOf(geometry);
}

const ball = withTree(new SphereGeometry(RADIUS / 1000, 256, 128));
const onBall = (longitude: number, latitude = 0): Vector => {
  const [a, b] = [(longitude * Math.PI) / 180, (latitude * Math.PI) / 180];
  return [RADIUS * Math.cos(b) * Math.sin(a), RADIUS * Math.sin(b), RADIUS * Math.cos(b) * Math.cos(a)];
};

/** 200 mm square in z = 0 with a square hole of 40 mm in its middle. */
function plate(): Skin {
  const full = new PlaneGeometry(0.2, 0.2, 40, 40);
  const position = full.attributes.position!;
  const kept: number[] = [];
  const index = full.index!.array;
  for (let i = 0; i < index.length; i += 3) {
    const middle = [0, 1, 2].reduce((sum, k) => sum.add(new Vector3().fromBufferAttribute(position, index[i + k]!)), new Vector3()).divideScalar(3);
    if (Math.abs(middle.x) > 0.02 || Math.abs(middle.y) > 0.02) kept.push(index[i]!, index[i + 1]!, index[i + 2]!);
  }
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(position.array, 3)).setIndex(kept);
  return withTree(geometry);
}

const farthest = (skin: Skin, points: readonly Vector[]): number => Math.max(...points.map((point) => skin.nearest(point).away));
const widest = (points: readonly Vector[]): number => Math.max(...points.slice(1).map((point, i) => gap(points[i]!, point)));

test("even steps keep both ends and the length of a straight line", () => {
  const points = evenly([[0, 0, 0], [3, 0, 0], [10.9, 0, 0]]);
  expect(points).toHaveLength(6);
  expect(points[0]).toEqual([0, 0, 0]);
  expect(points.at(-1)).toEqual([10.9, 0, 0]);
  for (let i = 1; i < points.length; i += 1) expect(gap(points[i - 1]!, points[i]!)).toBeCloseTo(10.9 / 5, 9);
});

test("the way between two places of a sphere is the great circle, on the skin, in steps of two millimetres", () => {
  const points = way(ball, onBall(-40, 10), onBall(50, 10));
  expect(farthest(ball, points)).toBeLessThan(1e-3);
  expect(widest(points)).toBeLessThan(1.3 * STEP_MM);
  const [a, b] = [onBall(-40, 10), onBall(50, 10)].map((at) => new Vector3(...at)) as [Vector3, Vector3];
  const true_mm = RADIUS * a.angleTo(b);
  expect(Math.abs(lengthOf({ points, closed: false }) - true_mm)).toBeLessThan(0.005 * true_mm);
  const plane = a.clone().cross(b).normalize();
  expect(Math.max(...points.map((point) => Math.abs(plane.dot(new Vector3(...point)))))).toBeLessThan(1);
});

test("a way round more than the chord shows stays on the same side", () => {
  const points = way(ball, onBall(-80), onBall(80));
  expect(Math.min(...points.map(([, , z]) => z))).toBeGreaterThan(0);
  expect(Math.abs(lengthOf({ points, closed: false }) - (RADIUS * 160 * Math.PI) / 180)).toBeLessThan(2);
});

test("a stroke follows the hand: every hit within a millimetre of the line, the line on the skin", () => {
  const hits = Array.from({ length: 30 }, (_, i) => onBall(-30 + 2 * i, 12 * Math.sin(i / 5)));
  const points = freehand(ball, hits);
  expect(farthest(ball, points)).toBeLessThan(1e-3);
  for (const hit of hits) expect(Math.min(...points.map((point) => gap(point, hit)))).toBeLessThan(STEP_MM / 2 + 0.5);
  expect(widest(points)).toBeLessThan(1.3 * STEP_MM);
});

test("a circle has its radius along the skin in every direction", () => {
  const rim = circle(ball, onBall(20, 15), 30);
  const centre = new Vector3(...onBall(20, 15));
  for (const point of rim) {
    const along = RADIUS * centre.angleTo(new Vector3(...point));
    expect(Math.abs(along - 30)).toBeLessThan(0.3);
  }
  expect(farthest(ball, rim)).toBeLessThan(CHORD);
  expect(lengthOf({ points: rim, closed: true })).toBeCloseTo(2 * Math.PI * RADIUS * Math.sin(0.3), 0);
});

test("over a hole the line has one long step, which the picture fills with dashes", () => {
  const points = way(plate(), [-60, 0, 0], [60, 0, 0]);
  const long = points.slice(1).filter((point, i) => gap(points[i]!, point) > BRIDGE_MM);
  expect(long).toHaveLength(1);
  expect(farthest(plate(), points)).toBeLessThan(1e-3);
  const seen = bridgedAt(points, false, BRIDGE_MM);
  const over = seen.points.filter((_, i) => seen.bridged[i]);
  expect(over.length).toBeGreaterThan(15);
  for (const [x, y] of over) expect(Math.max(Math.abs(x), Math.abs(y))).toBeLessThan(20.01);
});

test("what is guessed is dashed and stays a guess where nobody touches the line; what a hand has moved lies on the skin", () => {
  const points = way(ball, onBall(-40), onBall(40));
  const middle = (at: Vector): boolean => Math.abs(at[0]) < 12;
  const line = lineAlong("a", INK, points, false, points.map(middle));
  const guessed = ({ points: all, bridged }: OwnLine): Vector[] => all.filter((_, i) => bridged?.[i]);
  expect(guessed(line).length).toBeGreaterThan(8);
  const seen = bridgedAt(line.points, false, BRIDGE_MM, line.bridged);
  expect(seen.points.filter((_, i) => seen.bridged[i])).toEqual(guessed(line));
  expect(guessed(extended(ball, line, onBall(60)))).toEqual(guessed(line));
  const last = line.corners.length - 1;
  expect(guessed(cornerRemoved(ball, cornerAdded(line, onBall(-30)).line, 0)!)).toEqual(guessed(line));
  expect(guessed(cornerMoved(ball, cornerAdded(line, onBall(25)).line, last + 1, onBall(40, 5)))).toEqual(guessed(line));
  const moved = cornerMoved(ball, cornerAdded(line, onBall(0)).line, cornerAdded(line, onBall(0)).corner, onBall(0, 4));
  expect("bridged" in moved).toBe(false);
  expect("bridged" in lineAlong("a", INK, points, false, points.map(() => false))).toBe(false);
});

test("corners are where a line bends, and its ends", () => {
  const bend: Vector[] = [...evenly([[0, 0, 0], [40, 0, 0]]), ...evenly([[40, 0, 0], [40, 30, 0]]).slice(1)];
  expect(cornersOf(bend, false).map((i) => bend[i])).toEqual([[0, 0, 0], [40, 0, 0], [40, 30, 0]]);
  const ring = circle(ball, onBall(0), 25);
  expect(cornersOf(ring, true).length).toBeGreaterThan(4);
});

function clicked(): OwnLine {
  const two = lineThrough(ball, "a", INK, onBall(-20), onBall(0));
  return extended(ball, extended(ball, two, onBall(0, 25)), onBall(-20, 25));
}

test("clicks make corners; the ring closes along the skin and opens again", () => {
  const line = clicked();
  expect(line.corners).toHaveLength(4);
  for (const [i, at] of [onBall(-20), onBall(0), onBall(0, 25), onBall(-20, 25)].entries()) expect(gap(cornerAt(line, i), at)).toBeLessThan(CHORD + 0.05);
  const ring = closedUp(ball, line);
  expect(ring.closed).toBe(true);
  expect(ring.corners).toHaveLength(4);
  expect(widest([...ring.points, ring.points[0]!])).toBeLessThan(1.3 * STEP_MM);
  expect(openedUp(ring).points).toEqual(line.points);
});

test("parts put together are the line again", () => {
  for (const line of [clicked(), closedUp(ball, clicked())]) {
    const parts = partsOf(line);
    expect(parts).toHaveLength(line.closed ? 4 : 3);
    expect(parts.flatMap((part) => part.slice(0, -1)).length + (line.closed ? 0 : 1)).toBe(line.points.length);
  }
});

test("a moved corner takes its two parts along on the skin and leaves the others point by point", () => {
  for (const line of [clicked(), closedUp(ball, clicked())]) {
    const to = onBall(8, -6);
    const moved = cornerMoved(ball, line, 1, to);
    expect(gap(cornerAt(moved, 1), to)).toBeLessThan(CHORD + 0.05);
    expect(farthest(ball, moved.points)).toBeLessThan(1e-3);
    expect(widest(moved.points)).toBeLessThan(1.6 * STEP_MM);
    expect(partsOf(moved)[2]).toEqual(partsOf(line)[2]);
    expect(cornerAt(moved, 0)).toEqual(cornerAt(line, 0));
    expect(cornerAt(moved, 2)).toEqual(cornerAt(line, 2));
  }
  const first = cornerMoved(ball, closedUp(ball, clicked()), 0, onBall(-24, -4));
  expect(first.corners).toHaveLength(4);
  expect(gap(cornerAt(first, 0), onBall(-24, -4))).toBeLessThan(0.1);
});

test("without a corner the line goes straight on; without enough of them there is no line", () => {
  const line = clicked();
  const without = cornerRemoved(ball, line, 1)!;
  expect(without.corners).toHaveLength(3);
  expect(cornerAt(without, 1)).toEqual(cornerAt(line, 2));
  expect(farthest(ball, without.points)).toBeLessThan(1e-3);
  expect(cornerRemoved(ball, line, 0)!.points[0]).toEqual(cornerAt(line, 1));
  expect(cornerRemoved(ball, line, 3)!.points.at(-1)).toEqual(cornerAt(line, 2));
  expect(cornerRemoved(ball, lineThrough(ball, "b", INK, onBall(0), onBall(9)), 1)).toBeNull();
  const ring = closedUp(ball, line);
  for (const corner of [0, 1, 2, 3]) {
    const less = cornerRemoved(ball, ring, corner)!;
    expect(less.corners).toHaveLength(3);
    expect(widest([...less.points, less.points[0]!])).toBeLessThan(1.4 * STEP_MM);
  }
});

test("a new corner is a point of the line, in order", () => {
  const line = lineAlong("c", INK, way(ball, onBall(-10), onBall(10)), false);
  const { line: more, corner } = cornerAdded(line, onBall(1));
  expect(more.corners).toHaveLength(line.corners.length + 1);
  expect(gap(cornerAt(more, corner), onBall(1))).toBeLessThan(STEP_MM);
  expect(more.points).toBe(line.points);
});
