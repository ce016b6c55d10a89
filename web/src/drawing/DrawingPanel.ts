// The plan: what the tool in the hand needs, and what lies on the body, line by line.
import type { FitSlice } from "../fit/state";
import { fileName, type ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, fileButton, iconButton, problem } from "../ui/controls";
import { el, saveFile, setText, show } from "../ui/dom";
import { later } from "../ui/later";
import { numberField } from "../ui/NumberField";
import type { Panel } from "../ui/Panel";
import { type DrawingActions, RADIUS_MM } from "./actions";
import { createDrawingLayers } from "./DrawingLayers";
import type { PlanWords } from "./patterns/DrawingPattern";
import { toText } from "./lines/files";
import { type DrawingSlice, lineNamed } from "./state";
import * as text from "./text";

const words = text.drawing;

type Shown = Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice, "meta" | "models" | "problems" | "scan" | "drawing" | "fit" | "isStarting" | "drawn" | "lesion" | "hasPen" | "fingersDraw">;

/** `more`: what other features have to say about the drawing, below the rest. */
export function createDrawingPanel(drawing: DrawingActions, plan: PlanWords, dismiss: () => void, more: HTMLElement): Panel<Shown> {
  let state: Shown | null = null;
  const full = button(text.canvas.open, () => drawing.fullCanvas(true), "quiet outlined", "expand");
  full.id = "full-canvas";
  full.title = text.canvas.openHint;
  const hint = el("p", { class: "tool-hint muted small", id: "tool-hint" });
  const withFingers = el("input", { type: "checkbox", onchange: () => drawing.drawWithFingers(withFingers.checked) });
  const fingers = el("label", { class: "check", hidden: true }, withFingers, el("span", {}, text.canvas.fingersHint));
  const radius = numberField({ name: "next_radius_mm", label: words.radius, unit: "mm", min: RADIUS_MM.least, max: RADIUS_MM.most, hint: "", mayBeEmpty: false, changed: (mm) => mm !== null && drawing.radius(mm) });
  const finish = button(words.finish, () => drawing.finish(), "quiet outlined");
  const measured = el("p", { class: "tape-length", hidden: true });
  const endTape = button(text.tape.end, () => drawing.endTape(), "quiet outlined");
  const again = button(words.again, () => void drawing.saveNow(), "link");
  const file = fileButton(words.importFile, ".json", "icon-only", (chosen) => void drawing.importFile(chosen));
  file.querySelector("input")!.id = "drawing-file";
  file.querySelector("span")!.className = "visually-hidden";
  file.title = words.importHint;
  const save = button(words.exportFile, () => state?.scan && saveFile(fileName(state.scan, "drawing.json", state.fit?.result?.stance), toText(state.drawn.lines.present, { patient: state.scan.info.patient_code, scans: [state.scan.info.sha256] }), "application/json"), "quiet");
  save.title = words.exportHint;
  const wrong = problem(dismiss);
  const another = createAnother(drawing);
  const corners = createCorners(drawing);
  const layers = createDrawingLayers(drawing);
  const pattern = later(
    only("meta", "scan", "drawing", "fit", "drawn"),
    ({ scan }: Pick<Shown, "meta" | "scan" | "drawing" | "fit" | "drawn">) => scan !== null,
    async () => (await import("./patterns/DrawingPattern")).createDrawingPattern(drawing, plan),
  );
  const lesions = later(
    only("scan", "drawn", "lesion"),
    ({ scan }: Pick<Shown, "scan" | "drawn" | "lesion">) => scan !== null,
    async () => (await import("./lesions/LesionsPanel")).createLesions(drawing.lookAt, (lesions) => plan.lesions(lesions)),
  );
  const element = el(
    "div",
    { class: "panel drawing" },
    wrong.element,
    another.element,
    hint,
    full,
    fingers,
    radius.element,
    finish,
    measured,
    endTape,
    corners.element,
    el("div", { class: "toolbar" }, again, el("span", { class: "spring" }), file, save),
    pattern.element,
    lesions.element,
    layers.element,
    more,
  );
  return {
    element,
    select: only("meta", "models", "problems", "scan", "drawing", "fit", "isStarting", "drawn", "lesion", "hasPen", "fingersDraw"),
    update(session: Shown): void {
      state = session;
      const { drawn } = session;
      setText(hint, words.hints[drawn.tool]);
      show(fingers, session.hasPen);
      withFingers.checked = session.fingersDraw;
      show(radius.element, drawn.tool === "tumour");
      radius.set(drawn.radiusMm);
      show(finish, drawn.tool === "pen" && (drawn.open !== null || drawn.start !== null));
      const { tape } = drawn;
      show(measured, tape !== null);
      setText(measured, tape ? text.tape.says(tape) : "");
      show(endTape, tape !== null && !tape.isEnded);
      save.disabled = drawn.lines.present.length === 0;
      wrong.set(session.problems.drawing);
      show(again, drawn.saving === "unsaved" && session.problems.drawing !== undefined);
      another.update(session);
      corners.update(session);
      layers.update(session);
      pattern.update(session);
      lesions.update(session);
    },
  };
}

/** A file that names another patient: asked before anything of it is taken. */
function createAnother(drawing: DrawingActions): Panel<Pick<DrawingSlice, "drawn">> {
  const words = text.drawing.another;
  const says = el("p", {});
  const take = button("", () => drawing.takeAnother(), "outlined");
  const leave = button(words.leave, () => drawing.leaveAnother(), "primary");
  const element = el("dialog", { class: "help ask", id: "another-dialog", "aria-labelledby": "another-title", oncancel: () => drawing.leaveAnother() }, el("h2", { id: "another-title" }, words.title), says, el("div", { class: "toolbar" }, leave, take));
  return {
    element,
    select: only("drawn"),
    update({ drawn: { another } }: Pick<DrawingSlice, "drawn">): void {
      if (another) {
        setText(says, words.says(another.theirs, another.ours));
        setText(take, words.take(another.ours));
      }
      if (another && !element.open) element.showModal();
      if (!another && element.open) element.close();
    },
  };
}

/** The points of the chosen line without a pointer: one after the other, moved by arrow keys, deleted. */
function createCorners(drawing: DrawingActions): Panel<Pick<DrawingSlice, "drawn">> {
  let state: Pick<DrawingSlice, "drawn"> | null = null;
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
    select: only("drawn"),
    update(session: DrawingSlice): void {
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
