// A line on the patient's other side: mirrored in the plane between the fitted model's left and right landmarks, then laid
// on the skin that is there.
import type { Result, Vector } from "../../api/types";
import { picksOf } from "../../landmarks/picks";
import { dot } from "../../viewer/frame";
import { lineAlong } from "../lines/edits";
import { gap, type OwnLine } from "../lines/lines";
import type { OnSkin, Skin } from "../lines/skin";
import { BRIDGE_MM, onSkin, way } from "../lines/strokes";

/** Points p with normal · p = offset; mm in the scan's own axes, the unit normal to the patient's left. */
export interface MirrorPlane {
  readonly normal: Vector;
  readonly offset: number;
}

const BESIDE_MM = 25; // the nearest skin lies so far to the side, not below: a hole under a breast is twice as wide, more is not scanned
const AWAY_MM = 60; // in any direction: as far as a breast stands out from a chest without one

/** Between the fitted model's pairs, the wider of which decide more; null where a result has no pair. */
export function mirrorPlane(result: Pick<Result, "landmarks" | "scan">): MirrorPlane | null {
  const at = picksOf({ landmarks: result.landmarks, unit: result.scan.unit });
  const pairs = Object.keys(at).flatMap((name) => {
    const [left, right] = [at[name]!, at[name.replace(/_L$/, "_R")]];
    return name.endsWith("_L") && right ? [{ left, right }] : [];
  });
  const across = pairs.reduce<Vector>((sum, { left, right }) => [sum[0] + left[0] - right[0], sum[1] + left[1] - right[1], sum[2] + left[2] - right[2]], [0, 0, 0]);
  const length = Math.hypot(...across);
  if (length < 1) return null;
  const normal: Vector = [across[0] / length, across[1] / length, across[2] / length];
  const heights = pairs.map(({ left, right }) => (dot(left, normal) + dot(right, normal)) / 2);
  return { normal, offset: heights.reduce((sum, height) => sum + height, 0) / heights.length };
}

export function mirroredPoint({ normal, offset }: MirrorPlane, point: Vector): Vector {
  const twice = 2 * (dot(point, normal) - offset);
  return [point[0] - twice * normal[0], point[1] - twice * normal[1], point[2] - twice * normal[2]];
}

/** How far beside the skin, and not above or below it, a place lies, mm. */
function beside(place: Vector, { point, normal }: OnSkin): number {
  const off: Vector = [place[0] - point[0], place[1] - point[1], place[2] - point[2]];
  return Math.sqrt(Math.max(0, dot(off, off) - dot(off, normal) ** 2));
}

/** The line on the other side, without a name of its own; null where no skin was scanned there. */
export function mirroredLine(skin: Skin, plane: MirrorPlane, line: OwnLine): OwnLine | null {
  const places = line.points.map((point) => mirroredPoint(plane, point));
  const laid = places.map((place) => skin.nearest(place));
  if (laid.some((on, i) => on.away > AWAY_MM || beside(places[i]!, on) > BESIDE_MM)) return null;
  const hits = laid.map(({ point }) => point);
  const points = onSkin(skin, joined(skin, line, hits));
  if (line.closed && points.length > 1) points.pop(); // the first one again
  if (points.length < 2) return null;
  const { bridged } = line;
  const nearest = (at: Vector): number => hits.reduce((best, hit, i) => (gap(hit, at) < gap(hits[best]!, at) ? i : best), 0);
  return lineAlong(line.name, line.color, points, line.closed, bridged && points.map((point) => bridged[nearest(point)]!));
}

/** Where the other side bends more, neighbours come down far apart: skin leads from one to the next.  A bridged hole stays one. */
function joined(skin: Skin, { points, closed }: OwnLine, hits: readonly Vector[]): Vector[] {
  const count = hits.length;
  const all: Vector[] = [];
  hits.forEach((hit, i) => {
    all.push(hit);
    if (i === count - 1 && !closed) return;
    const next = (i + 1) % count;
    const wasWhole = gap(points[i]!, points[next]!) <= BRIDGE_MM;
    if (wasWhole && gap(hit, hits[next]!) > BRIDGE_MM) all.push(...way(skin, hit, hits[next]!).slice(1, -1));
  });
  return closed ? [...all, hits[0]!] : all;
}
