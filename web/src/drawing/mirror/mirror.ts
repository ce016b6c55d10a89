// A line on the patient's other side: mirrored in the fitted body's median plane, then laid on the skin that is there.
import type { Result, Vector } from "../../api/types";
import { isUnit, mmFrom } from "../../ui/units";
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

/** The fitted body's own, in which the service measures too; null in results of earlier versions. */
export function mirrorPlane({ median_plane: plane, scan }: Pick<Result, "median_plane" | "scan">): MirrorPlane | null {
  return plane ? { normal: plane.normal, offset: mmFrom(plane.offset, isUnit(scan.unit) ? scan.unit : "mm") } : null;
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
