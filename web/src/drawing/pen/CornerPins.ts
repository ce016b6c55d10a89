// The corners of the chosen line as marks over the picture, the first click of a line that has no second one yet, and the
// places of the tape.
import type { PageSlice } from "../../store/page";
import { el } from "../../ui/dom";
import { Pins } from "../../viewer/Pins";
import type { Part } from "../../viewer/Viewer";
import { cornerAt } from "../lines/edits";
import { type DrawingSlice, lineNamed } from "../state";

export class CornerPins extends Pins<number> implements Part<Pick<PageSlice & DrawingSlice, "step" | "drawn">> {
  private drawn: unknown = null;

  update({ step, drawn }: Pick<PageSlice & DrawingSlice, "step" | "drawn">): void {
    const line = drawn.tool === "points" ? lineNamed(drawn, drawn.chosen) : drawn.tool === "pen" ? lineNamed(drawn, drawn.open) : null;
    const source = step === "plan" ? (drawn.tape ?? line ?? drawn.start) : null;
    if (source !== this.drawn) {
      this.drawn = source;
      const points = source === null ? [] : drawn.tape ? drawn.tape.places : line ? line.corners.map((_, i) => cornerAt(line, i)) : [drawn.start!];
      this.set(points.entries(), (i) => el("div", { class: "corner", "data-corner": i }));
    }
    this.toggle("is-active", (i) => i === drawn.corner);
  }
}
