// The legend: every line on the body with its stroke, switched on and off; the own ones can be named, closed and erased.
import { drawingLabels, requestLabel } from "../fit/requestedDrawing";
import type { FitSlice } from "../fit/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, iconButton } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { DrawingActions } from "./actions";
import { lengthOf, ownColour, type OwnLine } from "./lines/lines";
import { mirrorPlane } from "./mirror/mirror";
import { ALL_BANDS, BANDS, type DrawingSlice, type Layer, layerKey, shownPatterns } from "./state";
import * as text from "./text";

const words = text.drawing;
const plainStart = (label: string): string => label.charAt(0).toUpperCase() + label.slice(1);
const cm = (mm: number): string => (mm / 10).toFixed(1);

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "model" | "fit" | "drawing" | "drawn">;

/** What the file calls a line; null where it says no more than its name does. */
const labelOf = (name: string, label: string | undefined): string | null => (label === undefined || label === "" || label === name ? null : label);

export function createDrawingLayers(drawing: DrawingActions): Panel<Shown> {
  const own = el("ul", { class: "layers", "data-layer": "own" });
  const none = el("p", { class: "muted small" }, words.none);
  const reference = group("reference");
  const carried = group("carried");
  const bands = el("input", { type: "checkbox", "aria-describedby": "bands-legend", onchange: () => drawing.show("band", ALL_BANDS, bands.checked) });
  const ofBands = el(
    "div",
    { class: "toggle", hidden: true },
    el("label", { class: "check" }, bands, el("span", { class: "stroke stroke-band", "aria-hidden": "true" }), el("span", {}, text.bands.label)),
    el("p", { id: "bands-legend" }, text.bands.legend),
  );
  const dashed = el("p", { class: "muted small", hidden: true }, words.dashed);
  const element = el("div", { class: "panel" }, el("p", { class: "label" }, words.lines), own, none, carried.element, reference.element, ofBands, dashed);

  function group(layer: Layer) {
    const title = el("p", { class: "label" });
    const list = el("ul", { class: "layers", "data-layer": layer });
    const note = el("p", { class: "muted small" });
    const element = el("div", { class: "panel", hidden: true }, title, list, note);
    return {
      element,
      set(label: string, shapes: readonly { name: string; label: string; color: string | null }[], hidden: ReadonlySet<string>, says: string): void {
        show(element, label !== "");
        setText(title, label);
        setText(note, says);
        show(note, says !== "");
        fill(list, shapes, () => shapes.map((shape) => el("li", { "data-line": shape.name }, toggle(layer, shape.name, shape.label, shape.color))));
        check(list, layer, hidden);
      },
    };
  }

  function toggle(layer: Layer, name: string, label: string | null, color: string | null): HTMLElement {
    const box = el("input", { type: "checkbox", "aria-label": words.show(label ?? name), onchange: () => drawing.show(layer, name, box.checked) });
    const stroke = el("span", { class: `stroke stroke-${layer}`, "aria-hidden": "true" });
    if (color !== null) stroke.style.background = color;
    return el("label", { class: "check" }, box, stroke, label === null ? null : el("span", {}, label));
  }

  function check(list: HTMLElement, layer: Layer, hidden: ReadonlySet<string>): void {
    for (const row of list.querySelectorAll<HTMLElement>("li")) {
      row.querySelector<HTMLInputElement>("input[type=checkbox]")!.checked = !hidden.has(layerKey(layer, row.dataset.line!));
    }
  }

  function ownRow(line: OwnLine, mayMirror: boolean): HTMLElement {
    const { name } = line;
    const field = el("input", {
      type: "text",
      class: "line-name",
      value: name,
      maxlength: 100,
      "aria-label": words.name(name),
      onchange: () => {
        const isTaken = !drawing.rename(name, field.value);
        field.setCustomValidity(isTaken && field.value.trim() !== "" ? words.nameTaken : "");
        if (isTaken && !field.reportValidity()) return;
        if (isTaken) field.value = name;
      },
      oninput: () => field.setCustomValidity(""),
      onfocus: () => drawing.choose(name),
    });
    const close = button(line.closed ? words.openShort : words.closeShort, () => drawing.close(name), "quiet small");
    close.setAttribute("aria-label", line.closed ? words.open(name) : words.close(name));
    const length = line.closed ? null : el("span", { class: "muted small" }, words.length(cm(lengthOf(line))));
    field.title = name;
    return el("li", { "data-line": name }, toggle("own", name, null, ownColour(line.color)), el("div", { class: "line-words" }, field, length), close, mayMirror ? iconButton("mirror", words.mirror(name), () => drawing.mirror(name)) : null, iconButton("close", words.erase(name), () => drawing.erase(name)));
  }

  return {
    element,
    select: only("meta", "model", "fit", "drawing", "drawn"),
    update(state: Shown): void {
      const { lines, hidden, chosen } = state.drawn;
      show(none, lines.present.length === 0);
      const mayMirror = state.fit?.result ? mirrorPlane(state.fit.result) !== null : false;
      fill(own, [mayMirror, lines.present.map((line) => [line.name, line.closed, Math.round(lengthOf(line)), line.color])], () => lines.present.map((line) => ownRow(line, mayMirror)));
      check(own, "own", hidden);
      for (const row of own.querySelectorAll<HTMLElement>("li")) row.classList.toggle("is-chosen", row.dataset.line === chosen);
      const { fit, model } = state;
      const drawings = model?.side.drawings ?? [];
      const known = drawings.find((each) => each.name === fit?.drawingName);
      const onModel = [...(known?.shapes ?? []), ...drawings.flatMap((each) => each.shapes)];
      const nameOf = (name: string, label?: string): string => plainStart(labelOf(name, label) ?? onModel.find((each) => each.name === name)?.label ?? words.shapeName(name));
      const patterns = shownPatterns(state);
      const shapes = patterns?.shapes ?? known?.shapes ?? [];
      const named = shapes.map(({ name, label, color }) => ({ name, label: nameOf(name, label), color: ownColour(color) }));
      const label = requestLabel(state.drawn.onScan ? state.drawing : (fit?.drawingName ?? ""), drawingLabels(state));
      reference.set(fit && label !== "" ? words.reference(label) : "", named, hidden, "");
      const from = state.drawn.onScan;
      const brought = from?.carried.shapes ?? [];
      carried.set(brought.length > 0 ? words.carried(from!.from) : "", brought.map(({ name, label, color, kind }) => ({ name, label: kind === "line" ? (labelOf(name, label) ?? name) : nameOf(name, label), color: ownColour(color) })), hidden, "");
      show(ofBands, [...(patterns?.shapes ?? []), ...brought].some((shape) => shape.error_mm?.some((mm) => mm !== null)));
      bands.checked = !hidden.has(BANDS);
      const hasBridge = [...(patterns?.shapes ?? []), ...brought, ...lines.present].some((shape) => shape.bridged?.includes(true));
      show(dashed, hasBridge);
    },
  };
}
