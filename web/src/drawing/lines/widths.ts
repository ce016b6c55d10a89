// How wide the band of a line is at each of its points.
import type { DrawingFile } from "../../api/types";
import { KNOWN_MM } from "../../fit/verdict";

type Line = Pick<DrawingFile["shapes"][number], "points" | "error_mm" | "line_error_mm">;

/** What a line's radii, which count in all directions, are to be multiplied with to stand for its line error, across it. */
function acrossOf({ error_mm, line_error_mm }: Pick<Line, "error_mm" | "line_error_mm">): number {
  const squares = (error_mm ?? []).flatMap((mm) => (mm === null ? [] : [mm * mm]));
  const mean = Math.sqrt(squares.reduce((sum, each) => sum + each, 0) / squares.length);
  return line_error_mm == null || !(mean > 0) ? 1 : line_error_mm / mean;
}

/** Across the line, mm, of each of its points; NaN where it is not known, or so large that nothing is. */
export function widthsOf(line: Line): number[] {
  const across = acrossOf(line);
  return line.points.map((_, i) => {
    const mm = across * (line.error_mm?.[i] ?? NaN);
    return mm <= KNOWN_MM ? mm : NaN;
  });
}
