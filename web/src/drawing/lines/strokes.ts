// Lines on the skin: the shortest-looking way between two places, even spacing, circles, and what follows a moved corner.
import type { Vector } from "../../api/types";
import { cross, dot } from "../../viewer/frame";
import { gap, lengthOf } from "./lines";
import type { Skin } from "./skin";

export const STEP_MM = 2; // between points: finer than a pen's line is wide
export const BRIDGE_MM = 6; // a longer step leads over a hole: three steps without skin
const HOLE_MM = 45; // the shadow under a breast is scanned as a hole of up to four centimetres
const DETOUR = 1.3; // times the straight distance: over a silhouette to what lies far behind it is a jump, also where skin leads there unseen
const TENSION_ROUNDS = 8; // of pulling a way straight; the halving before has done most of it
const CORNER_MM = 3.5; // a bend that sticks out so far is a corner of its own
const CORNER_EVERY_MM = 40; // and a long smooth part gets one at least so often

const plus = (a: Vector, b: Vector, share = 1): Vector => [a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]];
const between = (a: Vector, b: Vector, share: number): Vector => [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

function unit(v: Vector): Vector | null {
  const length = Math.hypot(...v);
  return length > 1e-9 ? [v[0] / length, v[1] / length, v[2] / length] : null;
}

/** Points at even steps of about `step` along a polyline; both ends stay. */
export function evenly(points: readonly Vector[], step = STEP_MM): Vector[] {
  if (points.length < 2) return [...points];
  const along = [0];
  for (let i = 1; i < points.length; i += 1) along.push(along[i - 1]! + gap(points[i - 1]!, points[i]!));
  const total = along.at(-1)!;
  const count = Math.max(1, Math.round(total / step));
  const out: Vector[] = [points[0]!];
  let k = 1;
  for (let i = 1; i < count; i += 1) {
    const wanted = (i * total) / count;
    while (along[k]! < wanted) k += 1;
    const span = along[k]! - along[k - 1]!;
    out.push(between(points[k - 1]!, points[k]!, span > 0 ? (wanted - along[k - 1]!) / span : 0));
  }
  return [...out, points.at(-1)!];
}

/** Even steps, each point put on the skin; over a hole the rims stay where they are and nothing stands between. */
export function onSkin(skin: Skin, points: readonly Vector[]): Vector[] {
  const last = points.at(-1);
  const spaced = evenly(points).map((point) => skin.nearest(point).point);
  const out: Vector[] = [];
  for (const point of spaced) if (out.length === 0 || gap(out.at(-1)!, point) > STEP_MM / 4) out.push(point);
  if (last && out.length > 1 && spaced.length > 1) out[out.length - 1] = skin.nearest(last).point;
  return out;
}

/** From a to b along the skin: halved again and again, each middle put on the skin, then pulled straight. */
export function way(skin: Skin, a: Vector, b: Vector): Vector[] {
  const from = skin.nearest(a);
  const to = skin.nearest(b);
  const halve = (p: Vector, pn: Vector, q: Vector, qn: Vector, depth: number): Vector[] => {
    if (depth === 0 || gap(p, q) < STEP_MM) return [p];
    const middle = between(p, q, 0.5);
    const direction = unit(plus(pn, qn));
    const near = skin.nearest(middle);
    const met = direction && skin.needle(middle, direction);
    // The needle keeps to the side that both ends look to; through a hole it would find the back, farther than any rim.
    const on = met && met.away < near.away + gap(p, q) / 2 ? met : near;
    return [...halve(p, pn, on.point, on.normal, depth - 1), ...halve(on.point, on.normal, q, qn, depth - 1)];
  };
  let points = [...halve(from.point, from.normal, to.point, to.normal, 8), to.point];
  for (let round = 0; round < TENSION_ROUNDS; round += 1) {
    points = points.map((point, i) => {
      const [before, after] = [points[i - 1], points[i + 1]];
      if (!before || !after || gap(before, point) > BRIDGE_MM || gap(point, after) > BRIDGE_MM) return point;
      return skin.nearest(between(before, after, 0.5)).point;
    });
  }
  return onSkin(skin, points);
}

/** Longest distance between neighbours. */
const widest = (points: readonly Vector[]): number => points.reduce((most, point, i) => (i === 0 ? 0 : Math.max(most, gap(points[i - 1]!, point))), 0);

/** With both ends: where no skin leads across, a way may never arrive. */
const wholeWay = (skin: Skin, a: Vector, b: Vector): Vector[] => [a, ...way(skin, a, b), b];

/** Skin leads from one place to the other, and not by a long way round through what the eye does not see. */
export function isJoined(skin: Skin, a: Vector, b: Vector): boolean {
  const away = gap(a, b);
  if (away <= BRIDGE_MM) return true;
  const between = wholeWay(skin, a, b);
  return widest(between) <= BRIDGE_MM && lengthOf({ points: between, closed: false }) <= DETOUR * away;
}

/** Between two clicks a hole of the scan is bridged, dashed; wider than that it is air. */
export const leadsOver = (skin: Skin, a: Vector, b: Vector): boolean => widest(wholeWay(skin, a, b)) <= HOLE_MM;

/** What a hand draws, hit by hit. */
export interface HandStrokes {
  /** null: the hand is beside the skin. */
  add(hit: Vector | null): void;
  /** so far, without specks */
  strokes(): Vector[][];
}

/**
 * Each part of a hand's way that stays on the skin.  A hand that jumps to another part of the body, or comes back onto
 * the skin elsewhere, begins a new stroke there: no line leads through air.
 */
export function handStrokes(skin: Skin): HandStrokes {
  const all: Vector[][] = [];
  let [last, hasLeft]: [Vector | null, boolean] = [null, false];
  return {
    add(hit) {
      if (!hit) {
        hasLeft = true;
        return;
      }
      const goesOn = last !== null && (hasLeft ? gap(last, hit) <= BRIDGE_MM : isJoined(skin, last, hit));
      if (goesOn) all.at(-1)!.push(hit);
      else all.push([hit]);
      [last, hasLeft] = [hit, false];
    },
    strokes: () => all.filter((stroke) => lengthOf({ points: stroke, closed: false }) >= STEP_MM),
  };
}

/** What a hand drew on the skin: hits in a row, with gaps where it was quick. */
export function freehand(skin: Skin, hits: readonly Vector[]): Vector[] {
  const dense: Vector[] = [];
  hits.forEach((hit, i) => {
    const before = hits[i - 1];
    if (before && gap(before, hit) > BRIDGE_MM) dense.push(...way(skin, before, hit).slice(1, -1));
    dense.push(hit);
  });
  const spaced = evenly(dense);
  // Pixels and a trembling hand: a third of what sticks out is taken back.
  const calm = spaced.map((point, i) => {
    const [before, after] = [spaced[i - 1], spaced[i + 1]];
    return before && after && gap(before, after) < 3 * STEP_MM ? between(point, between(before, after, 0.5), 0.5) : point;
  });
  return onSkin(skin, calm);
}

/** All places at `radius` mm along the skin: walked straight on from the centre in all directions. */
export function circle(skin: Skin, centre: Vector, radius: number): Vector[] {
  const start = skin.nearest(centre);
  const axis: Vector = Math.abs(start.normal[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0];
  const across = unit(cross(start.normal, axis))!;
  const up = cross(start.normal, across);
  const count = Math.max(24, Math.ceil((2 * Math.PI * radius) / STEP_MM));
  const rim = Array.from({ length: count }, (_, k) => {
    const angle = (2 * Math.PI * k) / count;
    let direction = plus(across.map((value) => value * Math.cos(angle)) as Vector, up, Math.sin(angle));
    let at = start;
    for (let gone = 0; gone < radius - 1e-9; ) {
      const step = Math.min(1, radius - gone);
      const next = skin.nearest(plus(at.point, direction, step));
      const moved = minus(next.point, at.point);
      const went = Math.hypot(...moved);
      if (went < step / 20) break; // the rim of the scan
      gone += went;
      direction = unit(minus(moved, next.normal.map((value) => value * dot(moved, next.normal)) as Vector)) ?? direction;
      at = next;
    }
    return at.point;
  });
  return rim;
}

/** Where a line bends, and often enough between: the points that are worth moving. */
export function cornersOf(points: readonly Vector[], closed: boolean): number[] {
  const last = points.length - 1;
  if (last < 1) return points.length === 1 ? [0] : [];
  const found = new Set<number>([0]);
  if (!closed) found.add(last);
  const split = (from: number, to: number): void => {
    if (to - from < 2) return;
    const chord = unit(minus(points[to]!, points[from]!));
    let [worst, at] = [0, from];
    for (let i = from + 1; i < to; i += 1) {
      const out = minus(points[i]!, points[from]!);
      const off = chord ? Math.hypot(...cross(chord, out)) : Math.hypot(...out);
      if (off > worst) [worst, at] = [off, i];
    }
    const isLong = (to - from) * STEP_MM > CORNER_EVERY_MM;
    if (worst <= CORNER_MM && !isLong) return;
    if (worst <= CORNER_MM) at = Math.round((from + to) / 2);
    found.add(at);
    split(from, at);
    split(at, to);
  };
  if (closed) {
    const middle = Math.round(last / 2); // a closed line has no chord: its two halves have
    found.add(middle);
    split(0, middle);
    split(middle, last);
  } else split(0, last);
  return [...found].sort((one, other) => one - other);
}
