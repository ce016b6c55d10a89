// Found lines as plain values: read from the service's answer, joined at their ends, made into lines of the plan.
import type { Ink, Vector } from "../api/types";
import { lineAlong } from "../drawing/lines/edits";
import { gap, type OwnLine } from "../drawing/lines/lines";
import type { InkDecided } from "../drawing/state";
import { BRIDGE_MM, evenly } from "../drawing/lines/strokes";
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
    return { name: `${stem} ${number}`, ids: [name], kind, marker, color: shape.color ?? "#101010", closed: shape.closed ?? false, points, bridged: points.map((_, i) => shape.bridged?.[i] ?? false), lengthMm };
  });
}

/** What is known to be decided when a scan is opened: what the service keeps as dropped, and what is a line of the plan already, which the line says itself or, in older plans, where it runs. */
export function decidedBefore(found: readonly FoundLine[], kept: readonly string[], planned: readonly OwnLine[]): InkDecided {
  const decided: Record<string, "accepted" | "dropped"> = {};
  for (const line of found) if (planned.some((own) => line.ids.some((id) => own.ink?.includes(id)) || isSame(line, own))) for (const id of line.ids) decided[id] = "accepted";
  for (const id of kept) decided[id] ??= "dropped";
  return decided;
}

function isSame({ points }: FoundLine, own: OwnLine): boolean {
  const near = (at: Vector): boolean => own.points.some((point) => gap(point, at) < SAME_MM);
  return [0, 0.25, 0.5, 0.75, 1].every((share) => near(points[Math.round(share * (points.length - 1))]!));
}

/** As the pen would have drawn it. */
export function asOwn({ name, ids, color, closed, points, bridged }: FoundLine): OwnLine {
  const round = closed ? [...points, points[0]!] : points;
  const spaced = evenly(round);
  const guessed = guessedAlong(round, closed ? [...bridged, bridged[0]!] : bridged, spaced.length);
  const count = closed ? spaced.length - 1 : spaced.length;
  return { ...lineAlong(name, color, spaced.slice(0, count), closed, guessed.slice(0, count)), ink: ids };
}

/** Of so many even steps along the points, which are guessed: beside a point that is, or over a gap that a person has joined. */
function guessedAlong(points: readonly Vector[], bridged: readonly boolean[], count: number): boolean[] {
  const along = [0];
  for (let i = 1; i < points.length; i += 1) along.push(along[i - 1]! + gap(points[i - 1]!, points[i]!));
  const total = along.at(-1)!;
  let k = 1;
  return Array.from({ length: count }, (_, i) => {
    const at = (i * total) / (count - 1);
    while (k < along.length - 1 && along[k]! < at) k += 1;
    const isInside = at > along[k - 1]! && at < along[k]!;
    const isGap = isInside && along[k]! - along[k - 1]! > BRIDGE_MM;
    return isGap || bridged[at < along[k]! ? k - 1 : k]! || (isInside && bridged[k]!);
  });
}

interface Joint {
  readonly other: FoundLine;
  readonly gapMm: number;
  readonly points: readonly Vector[];
  readonly bridged: readonly boolean[];
}

/** The open line whose end is nearest to an end of this one, and both as one; null where there is none. */
export function nearestJoint(line: FoundLine, all: readonly FoundLine[]): Joint | null {
  let best: Joint | null = null;
  if (line.closed) return null;
  for (const other of all) {
    if (other === line || other.closed) continue;
    for (const first of [line, reversed(line)]) {
      for (const second of [other, reversed(other)]) {
        const gapMm = gap(first.points.at(-1)!, second.points[0]!);
        if (best === null || gapMm < best.gapMm) best = { other, gapMm, points: [...first.points, ...second.points], bridged: [...first.bridged, ...second.bridged] };
      }
    }
  }
  return best;
}

const reversed = (line: FoundLine): FoundLine => ({ ...line, points: line.points.toReversed(), bridged: line.bridged.toReversed() });
