// Found lines as plain values: read from the service's answer, joined at their ends, made into lines of the plan.
import type { Ink, Vector } from "../api/types";
import { lineAlong } from "../drawing/edits";
import { gap, type OwnLine } from "../drawing/lines";
import type { InkDecided } from "../drawing/state";
import { evenly } from "../drawing/strokes";
import type { FoundLine } from "./state";
import * as text from "./text";

const SAME_MM = 2; // a line of the plan that runs so near all along a found one is that one

/** As the service has them, named by marker and kind. */
export function readInk(found: Ink): FoundLine[] {
  const counts = new Map<string, number>();
  return found.shapes.map((shape): FoundLine => {
    const { name, kind, marker, length_mm: lengthMm, points } = shape;
    const stem = text.ink.stem(shape);
    const number = (counts.get(stem) ?? 0) + 1;
    counts.set(stem, number);
    return { name: `${stem} ${number}`, ids: [name], kind, marker, color: shape.color ?? "#101010", closed: shape.closed ?? false, points, lengthMm };
  });
}

/** What is known to be decided when a scan is opened: what the service keeps as dropped, and what is a line of the plan already. */
export function decidedBefore(found: readonly FoundLine[], kept: readonly string[], planned: readonly OwnLine[]): InkDecided {
  const decided: Record<string, "accepted" | "dropped"> = {};
  for (const line of found) if (planned.some((own) => isSame(line, own))) for (const id of line.ids) decided[id] = "accepted";
  for (const id of kept) decided[id] ??= "dropped";
  return decided;
}

function isSame({ points }: FoundLine, own: OwnLine): boolean {
  const near = (at: Vector): boolean => own.points.some((point) => gap(point, at) < SAME_MM);
  return [0, 0.25, 0.5, 0.75, 1].every((share) => near(points[Math.round(share * (points.length - 1))]!));
}

/** As the pen would have drawn it. */
export function asOwn({ name, color, closed, points }: FoundLine): OwnLine {
  const spaced = closed ? evenly([...points, points[0]!]).slice(0, -1) : evenly(points);
  return lineAlong(name, color, spaced, closed);
}

interface Joint {
  readonly other: FoundLine;
  readonly gapMm: number;
  readonly points: readonly Vector[];
}

/** The open line whose end is nearest to an end of this one, and both as one; null where there is none. */
export function nearestJoint(line: FoundLine, all: readonly FoundLine[]): Joint | null {
  let best: Joint | null = null;
  if (line.closed) return null;
  for (const other of all) {
    if (other === line || other.closed) continue;
    for (const first of [line.points, line.points.toReversed()]) {
      for (const second of [other.points, other.points.toReversed()]) {
        const gapMm = gap(first.at(-1)!, second[0]!);
        if (best === null || gapMm < best.gapMm) best = { other, gapMm, points: [...first, ...second] };
      }
    }
  }
  return best;
}
