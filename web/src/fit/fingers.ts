// How wide a line's band is, counted in fingers: one to 20 mm across, two to 40, three beyond.  A shape that is read without a
// number, and never a colour.
import type { Result } from "../api/types";
import { capital } from "../languages/words";
import { svg } from "../ui/dom";
import { KNOWN_MM, marginOf } from "./verdict";
import * as text from "./text";

const words = text.fingers;

export type Fingers = 1 | 2 | 3 | null; // null: not known

/** Of a line error, which counts to each side. */
export const fingersOf = (mm: number | null): Fingers => (mm === null || mm > KNOWN_MM ? null : mm <= 10 ? 1 : mm <= 20 ? 2 : 3);

/** "two fingers wide" */
export const wideOf = (mm: number | null): string => words.wide[fingersOf(mm) ?? 0]!;

/** "two fingers wide, ± 16 mm", for those who listen. */
export const saidWide = (mm: number | null): string => (fingersOf(mm) === null ? wideOf(mm) : `${wideOf(mm)}, ${marginOf(mm!)}`);

/** How wide lines of a fit are, for those who listen; those that it has drawn, where it has. */
export function linesWords({ drawn_line_error_mm: drawn, line_error_mm: any }: Pick<Result, "drawn_line_error_mm" | "line_error_mm">): string {
  const said = drawn == null ? text.numbers.lines : text.numbers.drawnLines;
  const mm = drawn ?? any ?? null;
  return mm === null ? "" : `${capital(said)}: ${saidWide(mm)}.`;
}

/** So many bars; a hatched circle where it is not known. */
export function fingersMark(count: Fingers): SVGElement {
  const bars = Array.from({ length: count ?? 0 }, (_, i) => svg("rect", { x: 10 - 3.5 * (count ?? 0) + 7 * i, y: i % 2 === 1 ? 2 : 3, width: 5, height: i % 2 === 1 ? 16 : 14, rx: 2.5 }));
  const unknown = [svg("circle", { cx: 9, cy: 10, r: 7.5 }), svg("path", { d: "M3.5 8.5l5-5M3 14.5 13.5 4M6.5 16.5l9-9M10.5 17.2l5-5" })];
  return svg("svg", { viewBox: "0 0 20 20", class: count === null ? "fingers is-unknown" : "fingers", "aria-hidden": "true" }, ...(count === null ? unknown : bars));
}
