// The lines of the measure that is pointed at, as they run on one of the scans.
import type { Measure, MeasuresFile, Vector } from "../../api/types";
import { measureKey, saidOf } from "./measuresTable";

export interface MeasuredLine {
  readonly side: "left" | "right" | "value";
  readonly points: readonly Vector[]; // mm, scan's axes
  readonly isStraight: boolean; // it may lead through the body
  readonly label: Vector; // where its length stands
  readonly says: string; // "" where the line is part of a ratio
}

const UNITS: Record<Measure["unit"], string> = { mm: "\u00a0mm", ml: "\u00a0ml", "1": "", grade: "" };

/** `stance`: what the table calls the scan; none for a change, and in a table of an older version. */
export function measuredLines(file: Pick<MeasuresFile, "measures"> | null, stance: string, key: string | null): MeasuredLine[] {
  const row = file?.measures.find((each) => each.stance === stance && measureKey(each) === key);
  if (!row?.paths) return [];
  const { paths } = row;
  return (["left", "right", "value"] as const).flatMap((side) => {
    const points = paths[side];
    if (!points || points.length < 2) return [];
    const says = row[side] === null || row.unit === "1" ? "" : saidOf(row, side) + UNITS[row.unit];
    return [{ side, points, isStraight: points.length === 2, label: middleOf(points), says }];
  });
}

/** Half way along an open line; the middle of what a closed one goes around. */
function middleOf(points: readonly Vector[]): Vector {
  const isClosed = points.length > 2 && points[0]!.every((value, axis) => value === points.at(-1)![axis]);
  const count = points.length;
  if (!isClosed && count > 2) return points[Math.floor(count / 2)]!;
  return [0, 1, 2].map((axis) => points.reduce((sum, point) => sum + point[axis]!, 0) / count) as Vector;
}
