// What a visitor reads of the plan: each line with how sure its place is and how deep a tumour lies, notes, and what of the
// plan this scan cannot show.  A line without these words looks surer than it is.
import type { DrawingFile, PlanOnScan } from "../../api/types";
import { ownColour } from "../../drawing/lines/lines";
import { drawing as drawingText } from "../../drawing/text";
import { result as resultText } from "../../fit/text";
import { el } from "../../ui/dom";
import { marginOf } from "../../fit/verdict";
import { withMargins } from "../../ui/margins";
import { formatMmWhole } from "../../ui/units";
import { shared as words } from "../text";

export interface ListedLine {
  readonly name: string;
  readonly colour: string | null;
  readonly about: string; // empty where nothing is known of it
}

/** With the line error (90 %) that the page says of each. */
export function listedLines(drawing: DrawingFile | null, plan: PlanOnScan): readonly ListedLine[] {
  const planned = new Map(plan.shapes.map((shape) => [shape.name, shape]));
  return (drawing?.shapes ?? []).map(({ name, color }) => {
    const { line_error_mm: mm = null, depth_mm = null, carried = false } = planned.get(name) ?? {};
    const about = [
      ...(carried ? [words.carried] : []),
      ...(mm === null ? [] : [marginOf(mm)]),
      ...(depth_mm === null ? [] : [words.deep(formatMmWhole(depth_mm))]),
    ];
    return { name, colour: ownColour(color), about: about.join(", ") };
  });
}

function row({ name, colour, about }: ListedLine): HTMLElement {
  const stroke = el("span", { class: "stroke", "aria-hidden": "true" });
  if (colour !== null) stroke.style.background = colour;
  return el("li", { "data-line": name }, stroke, el("span", {}, drawingText.shapeName(name), about === "" ? null : el("span", { class: "muted small about" }, ...withMargins(about))));
}

const part = (title: string, sentences: readonly string[]): HTMLElement[] => (sentences.length === 0 ? [] : [el("h2", {}, title), ...sentences.map((each) => el("p", { class: "note" }, each))]);

export function planList(drawing: DrawingFile | null, plan: PlanOnScan): readonly HTMLElement[] {
  const lines = listedLines(drawing, plan);
  return [
    el("h2", {}, resultText.drawing),
    el("ul", { class: "shapes" }, ...(lines.length > 0 ? lines.map(row) : [el("li", {}, resultText.noDrawing)])),
    ...(lines.some(({ about }) => about !== "") ? [el("p", { class: "muted small" }, words.withinHint)] : []),
    ...part(words.notes, plan.notes.map(({ text, at }) => (at === null ? text : `${drawingText.shapeName(at)}: ${text}`))),
    ...part(words.missing, plan.missing.map(({ reason }) => reason)),
  ];
}
