// What the tool in the hand needs: how it is used, its radius, the end of a line or of the tape.
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import { numberField } from "../../ui/NumberField";
import { type DrawingActions, RADIUS_MM } from "../actions";
import type { DrawingSlice } from "../state";
import * as text from "../text";

const words = text.drawing;

export function createToolNeeds(drawing: DrawingActions) {
  const full = button(text.canvas.open, () => drawing.fullCanvas(true), "quiet outlined", "expand");
  full.id = "full-canvas";
  full.title = text.canvas.openHint;
  const hint = el("p", { class: "muted small", id: "tool-hint" });
  const withFingers = el("input", { type: "checkbox", onchange: () => drawing.drawWithFingers(withFingers.checked) });
  const fingers = el("label", { class: "check", hidden: true }, withFingers, el("span", {}, text.canvas.fingersHint));
  const radius = numberField({ name: "next_radius_mm", label: words.radius, unit: "mm", min: RADIUS_MM.least, max: RADIUS_MM.most, hint: "", mayBeEmpty: false, changed: (mm) => mm !== null && drawing.radius(mm) });
  const finish = button(words.finish, () => drawing.finish(), "quiet outlined");
  const measured = el("p", { class: "tape-length", hidden: true });
  const endTape = button(text.tape.end, () => drawing.endTape(), "quiet outlined");
  const element = el("div", { class: "panel tool-needs" }, hint, fingers, radius.element, finish, measured, endTape, full);
  return {
    element,
    update({ drawn, hasPen, fingersDraw }: Pick<DrawingSlice, "drawn" | "hasPen" | "fingersDraw">): void {
      const { tool, tape } = drawn;
      show(element, tool !== "none" || hasPen);
      show(hint, tool !== "none");
      setText(hint, words.hints[tool]);
      show(full, tool === "none" || tool === "pen");
      show(fingers, hasPen);
      withFingers.checked = fingersDraw;
      show(radius.element, tool === "tumour");
      radius.set(drawn.radiusMm);
      show(finish, tool === "pen" && (drawn.open !== null || drawn.start !== null));
      show(measured, tape !== null);
      setText(measured, tape ? text.tape.says(tape) : "");
      show(endTape, tape !== null && !tape.isEnded);
    },
  };
}
