// The full canvas: the body alone on the screen, with a few large tools that float beside it.  It fills the screen where the
// browser lets a page do so, else the window.
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { problem } from "../../ui/controls";
import { el, fill, icon, type IconName, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { notice } from "../../ui/text";
import { formatFixed } from "../../ui/units";
import type { ViewName } from "../../viewer/state";
import { view as viewText } from "../../viewer/text";
import type { DrawingActions } from "../actions";
import { INKS } from "./inks";
import { lengthOf } from "../lines/lines";
import { type DrawingSlice, lineNamed, type Tool } from "../state";
import * as text from "../text";

const words = text.canvas;
const TOOLS = ["none", "pen", "points", "erase", "tape"] as const satisfies readonly Tool[];
const PICTURES: Record<(typeof TOOLS)[number], IconName> = { none: "turn", pen: "pen", points: "points", erase: "eraser", tape: "tape" };
const VIEWS = ["front", "left", "right", "back"] as const satisfies readonly ViewName[];

type Shown = Pick<PageSlice & ScanSlice & DrawingSlice, "problems" | "drawn" | "isCanvasFull" | "hasPen" | "fingersDraw">;

/** A large button: a picture and one word. */
function tool(picture: IconName | null, label: string, hint: string, pressed: () => void): HTMLButtonElement {
  return el("button", { type: "button", class: "canvas-tool", title: hint, onclick: pressed }, picture ? icon(picture) : null, el("span", {}, label));
}

export function createCanvasBar(drawing: DrawingActions, lookFrom: (view: ViewName) => void, dismiss: () => void): Panel<Shown> {
  let state: Shown | null = null;
  const tools = TOOLS.map((name) => ({ name, button: tool(PICTURES[name], text.drawing.toolNames[name], text.drawing.toolHints[name], () => drawing.take(name)) }));
  const undo = tool("undo", words.undo, text.drawing.undo, () => drawing.undo());
  const redo = tool("redo", words.redo, text.drawing.redo, () => drawing.redo());
  const fingers = tool("finger", words.fingers, words.fingersHint, () => drawing.drawWithFingers(!state?.fingersDraw));
  const views = VIEWS.map((name) => tool(null, viewText.names[name], viewText.hints[name], () => lookFrom(name)));
  const done = tool("check", words.done, words.doneHint, () => drawing.fullCanvas(false));
  const inks = INKS.map(({ color, name }) => {
    const drop = el("span", { class: "ink", "aria-hidden": "true" });
    drop.style.background = color;
    return { color, button: el("button", { type: "button", class: "canvas-tool is-ink", title: name, "aria-label": name, onclick: () => drawing.ink(color) }, drop) };
  });
  const name = el("input", { type: "text", class: "canvas-name", maxlength: 100, onchange: () => rename() });
  const length = el("span", { class: "muted" });
  const recolour = el("button", { type: "button", class: "canvas-tool is-wide", onclick: () => chosen() && state && drawing.recolour(chosen()!.name, state.drawn.ink) }, words.recolourShort);
  const finish = el("button", { type: "button", class: "canvas-tool is-wide", onclick: () => (state?.drawn.tool === "tape" ? drawing.endTape() : drawing.finish()) }, el("span", {}));
  const says = el("span", { class: "canvas-says", role: "status" });
  const wrong = problem(dismiss);
  const element = el(
    "div",
    { class: "canvas-bars", hidden: true },
    el("div", { class: "canvas-bar is-left", role: "toolbar", "aria-label": words.tools, "aria-orientation": "vertical" }, ...tools.map(({ button }) => button), undo, redo, fingers),
    el("div", { class: "canvas-bar is-right", role: "toolbar", "aria-label": words.views, "aria-orientation": "vertical" }, done, ...views),
    el("div", { class: "canvas-bar is-below" }, el("div", { class: "canvas-inks", role: "group", "aria-label": words.inks }, ...inks.map(({ button }) => button)), name, length, recolour, finish, says),
    el("p", { class: "canvas-notice" }, notice),
    wrong.element,
  );
  const chosen = () => (state ? lineNamed(state.drawn, state.drawn.open ?? state.drawn.chosen) : null);

  function rename(): void {
    const line = chosen();
    if (!line) return;
    const isTaken = !drawing.rename(line.name, name.value);
    name.setCustomValidity(isTaken && name.value.trim() !== "" ? text.drawing.nameTaken : "");
    if (isTaken && name.reportValidity()) name.value = line.name;
  }
  name.addEventListener("input", () => name.setCustomValidity(""));
  // The browser's own way out of the full screen is one out of the canvas.
  document.addEventListener("fullscreenchange", () => {
    if (document.fullscreenElement === null && state?.isCanvasFull) drawing.fullCanvas(false);
  });

  return {
    element,
    select: only("problems", "drawn", "isCanvasFull", "hasPen", "fingersDraw"),
    update(now: Shown): void {
      const isOther = now.isCanvasFull !== (state?.isCanvasFull ?? false);
      state = now;
      show(element, now.isCanvasFull);
      document.body.classList.toggle("is-canvas", now.isCanvasFull);
      if (isOther) fillScreen(now.isCanvasFull);
      if (!now.isCanvasFull) return;
      const { drawn } = now;
      for (const each of tools) each.button.setAttribute("aria-pressed", String(each.name === drawn.tool));
      for (const each of inks) each.button.setAttribute("aria-pressed", String(each.color === drawn.ink));
      redo.disabled = drawn.lines.future.length === 0;
      show(fingers, now.hasPen);
      fingers.setAttribute("aria-pressed", String(now.fingersDraw));
      const line = chosen();
      show(name, line !== null);
      if (document.activeElement !== name) name.value = line?.name ?? "";
      name.setAttribute("aria-label", line ? text.drawing.name(line.name) : words.noLine);
      setText(length, line && !line.closed ? text.drawing.length(formatFixed(lengthOf(line) / 10, 1)) : "");
      show(recolour, line !== null && line.color.toLowerCase() !== drawn.ink);
      if (line) recolour.setAttribute("aria-label", words.recolour(line.name, INKS.find(({ color }) => color === drawn.ink)?.name ?? drawn.ink));
      const isMeasuring = drawn.tape !== null && !drawn.tape.isEnded;
      show(finish, isMeasuring || (drawn.tool === "pen" && (drawn.open !== null || drawn.start !== null)));
      fill(finish, isMeasuring, () => [isMeasuring ? text.tape.end : text.drawing.finish]);
      setText(says, drawn.tape ? text.tape.says(drawn.tape) : "");
      wrong.set(now.problems.drawing);
    },
  };
}

/** A browser that does not let the page have the screen leaves it the window. */
function fillScreen(isOn: boolean): void {
  const root = document.documentElement as Partial<Pick<HTMLElement, "requestFullscreen">>;
  if (isOn) void root.requestFullscreen?.call(root).catch(() => undefined);
  else if (document.fullscreenElement !== null) void document.exitFullscreen().catch(() => undefined);
}
