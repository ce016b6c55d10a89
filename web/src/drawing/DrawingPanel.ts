// Step 4: the tools, and what lies on the body, line by line.
import type { Actions } from "../app/actions";
import { toText } from "./files";
import { lineNamed, type Tool, TOOLS } from "./lines";
import { el, saveFile, setText, show } from "../ui/dom";
import type { Session } from "../app/session";
import { text } from "../ui/text";
import { button, fileButton, iconButton, problem, segmented } from "../ui/controls";
import { createDrawingCarry } from "../stances/DrawingCarry";
import { createDrawingPattern } from "./DrawingPattern";
import { createDrawingLayers } from "./DrawingLayers";
import type { Panel } from "../ui/Panel";

const words = text.drawing;

export function createDrawingPanel(actions: Actions, dismiss: () => void, dismissFit: () => void): Panel {
  const { drawing } = actions;
  let state: Session | null = null;
  const tools = segmented<Tool>(
    words.tools,
    TOOLS.map((value) => ({ value, label: words.toolNames[value], hint: words.toolHints[value] })),
    drawing.take,
  );
  const hint = el("p", { class: "tool-hint muted small", id: "tool-hint" });
  const radius = el("input", { type: "number", min: 1, max: 80, step: 1, inputmode: "numeric", onchange: () => drawing.radius(radius.valueAsNumber) });
  const size = el("label", { class: "field inline short", hidden: true }, el("span", {}, words.radius), radius);
  const finish = button(words.finish, () => drawing.finish(), "quiet outlined");
  const undo = iconButton("undo", words.undo, () => drawing.undo());
  const redo = iconButton("redo", words.redo, () => drawing.redo());
  const saved = el("span", { class: "drawing-saved muted small" });
  const again = button(words.again, () => void drawing.saveNow(), "link");
  const file = fileButton(words.importFile, ".json", "icon-only", (chosen) => void drawing.importFile(chosen));
  file.querySelector("input")!.id = "drawing-file";
  file.querySelector("span")!.className = "visually-hidden";
  file.title = words.importHint;
  const save = button(words.exportFile, () => state && saveFile("drawing.json", toText(state.drawn.lines.present), "application/json"), "quiet");
  save.title = words.exportHint;
  const wrong = problem(dismiss);
  const corners = createCorners(actions);
  const layers = createDrawingLayers(actions);
  const pattern = createDrawingPattern(actions, dismissFit);
  const carry = createDrawingCarry(actions, () => actions.stances.dialog(true));
  const element = el(
    "div",
    { class: "panel drawing" },
    wrong.element,
    el("div", { class: "tool-row" }, tools.element),
    hint,
    size,
    finish,
    corners.element,
    el("div", { class: "toolbar" }, undo, redo, el("span", { class: "spring" }), saved, again, file, save),
    layers.element,
    pattern.element,
    carry.element,
  );
  return {
    element,
    update(session: Session): void {
      state = session;
      const { drawn } = session;
      tools.set(drawn.tool);
      setText(hint, words.hints[drawn.tool]);
      show(size, drawn.tool === "tumour");
      if (document.activeElement !== radius && radius.valueAsNumber !== drawn.radiusMm) radius.valueAsNumber = drawn.radiusMm;
      show(finish, drawn.tool === "pen" && (drawn.open !== null || drawn.start !== null));
      undo.disabled = drawn.lines.past.length === 0 && drawn.start === null;
      redo.disabled = drawn.lines.future.length === 0;
      save.disabled = drawn.lines.present.length === 0;
      setText(saved, drawn.lines.present.length === 0 && drawn.saving === "saved" ? "" : words[drawn.saving]);
      wrong.set(session.problems.drawing);
      show(again, drawn.saving === "unsaved" && session.problems.drawing !== undefined);
      corners.update(session);
      layers.update(session);
      pattern.update(session);
      carry.update(session);
    },
  };
}

/** The points of the chosen line without a pointer: one after the other, moved by arrow keys, deleted. */
function createCorners({ drawing }: Pick<Actions, "drawing">): Panel {
  let state: Session | null = null;
  const words = text.drawing;
  const where = el("span", { class: "small" });
  function step(by: number): void {
    const line = state && lineNamed(state.drawn, state.drawn.chosen);
    if (!state || !line) return;
    const count = line.corners.length;
    const now = state.drawn.corner;
    drawing.chooseCorner(now === null ? (by > 0 ? 0 : count - 1) : (now + by + count) % count);
    if (by !== 0) document.querySelector<HTMLElement>("canvas.view")?.scrollIntoView({ block: "nearest" });
  }
  const back = iconButton("back", words.previous, () => step(-1));
  const on = iconButton("on", words.next, () => step(1));
  const remove = button(words.remove, () => drawing.removeCorner(), "quiet outlined");
  const nudge = el("div", { class: "nudge", role: "group", "aria-label": words.nudge });
  for (const [key, label] of Object.entries(words.arrows)) {
    nudge.append(
      el("button", { type: "button", class: "button icon-only", "aria-label": label, title: label, onclick: () => document.querySelector("canvas.view")?.dispatchEvent(new KeyboardEvent("keydown", { key })) }, words.arrowSigns[key as keyof typeof words.arrowSigns]),
    );
  }
  const element = el("div", { class: "corners", hidden: true }, el("div", { class: "corner-row" }, back, where, on, el("span", { class: "spring" }), remove), nudge);
  return {
    element,
    update(session: Session): void {
      state = session;
      const { drawn } = session;
      const line = drawn.tool === "points" ? lineNamed(drawn, drawn.chosen) : null;
      show(element, line !== null);
      if (!line) return;
      setText(where, drawn.corner === null ? words.noCorner(line.corners.length) : words.corner(drawn.corner + 1, line.corners.length));
      remove.disabled = drawn.corner === null;
      show(nudge, drawn.corner !== null);
    },
  };
}
