// The legend: every line on the body with its stroke, switched on and off; the own ones can be named, closed and erased.
import { drawingLabels, requestLabel } from "../fit/requestedDrawing";
import { type FitSlice, modelOf } from "../fit/state";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button, iconButton } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { DrawingActions } from "./actions";
import { lengthOf, ownColour, type OwnLine } from "./lines/lines";
import { mirrorPlane } from "./mirror/mirror";
import { type DrawingSlice, type Layer, layerKey, shownPatterns } from "./state";
import * as text from "./text";

const words = text.drawing;
const plainStart = (label: string): string => label.charAt(0).toUpperCase() + label.slice(1);
const cm = (mm: number): string => (mm / 10).toFixed(1);

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "models" | "fit" | "drawing" | "drawn">;

/** What the file calls a line; null where it says no more than its name does. */
const labelOf = (name: string, label: string | undefined): string | null => (label === undefined || label === "" || label === name ? null : label);

interface Line {
  readonly name: string;
  readonly label: string;
  readonly color: string | null;
}

/** What was planned as one thing: a pattern with its lines, or one line. */
interface Item {
  readonly label: string;
  readonly lines: readonly Line[];
}

interface Shape {
  readonly name: string;
  readonly label?: string;
  readonly color?: string;
  readonly item?: string;
  readonly kind?: string;
}

function itemsOf(shapes: readonly Shape[], asLine: (shape: Shape) => Line, labelOf: (kind: string) => string): Item[] {
  const items = new Map<string, { label: string; lines: Line[] }>();
  for (const shape of shapes) {
    const line = asLine(shape);
    const key = shape.kind === "line" || shape.kind === "note" ? `line ${shape.name}` : `${shape.kind ?? ""} ${shape.item ?? ""}`;
    const item = items.get(key);
    if (item) item.lines.push(line);
    else items.set(key, { label: labelOf(shape.kind ?? "pattern"), lines: [line] });
  }
  return [...items.values()];
}

/** What a pattern or tumour is called that was asked for by this drawing. */
export const plannedLabel = (kind: string, drawing: string, labels: ReadonlyMap<string, string>): string =>
  kind === "tumour" ? (labels.get(kind) ?? words.tumourItem) : requestLabel(drawing.split("+tumour:")[0]!, labels) || words.patternItem;

export function createDrawingLayers(drawing: DrawingActions): Panel<Shown> {
  const own = el("ul", { class: "layers", "data-layer": "own" });
  const ofHere = el("p", { class: "label" }, words.lines);
  const none = el("p", { class: "muted small" }, words.none);
  const reference = group("reference");
  const carried = group("carried");
  const legend = el("p", { class: "muted small", hidden: true }, text.bands.legend);
  const dashed = el("p", { class: "muted small", hidden: true }, words.dashed);
  const element = el("div", { class: "panel" }, ofHere, none, reference.element, own, carried.element, legend, dashed);

  function group(layer: Layer) {
    const title = el("p", { class: "label", hidden: true });
    const list = el("ul", { class: "layers", "data-layer": layer });
    const element = el("div", { class: "panel", hidden: true }, title, list);
    return {
      element,
      set(label: string, items: readonly Item[], hidden: ReadonlySet<string>): void {
        show(element, items.length > 0);
        show(title, label !== "");
        setText(title, label);
        fill(list, items, () => items.map((item) => (item.lines.length === 1 ? lineRow(layer, item.lines[0]!) : itemRow(layer, item))));
        check(list, layer, hidden);
      },
    };
  }

  const lineRow = (layer: Layer, { name, label, color }: Line): HTMLElement => el("li", { "data-line": name }, toggle(layer, [name], label, color));

  /** One row for all lines of a pattern; they are inside. */
  function itemRow(layer: Layer, { label, lines }: Item): HTMLElement {
    const all = toggle(layer, lines.map(({ name }) => name), label, lines[0]!.color);
    const inside = el("details", {}, el("summary", { "aria-label": words.linesOf(lines.length, label) }, words.count(lines.length)), el("ul", {}, ...lines.map((line) => lineRow(layer, line))));
    return el("li", { class: "of-pattern", "data-item": label }, all, inside);
  }

  function toggle(layer: Layer, names: readonly string[], label: string | null, color: string | null): HTMLElement {
    const box = el("input", { type: "checkbox", "aria-label": words.show(label ?? names[0]!), onchange: () => drawing.show(layer, names, box.checked) });
    const stroke = el("span", { class: `stroke stroke-${layer}`, "aria-hidden": "true" });
    if (color !== null) stroke.style.background = color;
    return el("label", { class: "check" }, box, stroke, label === null ? null : el("span", {}, label));
  }

  function check(list: HTMLElement, layer: Layer, hidden: ReadonlySet<string>): void {
    for (const row of list.querySelectorAll<HTMLElement>("li[data-line]")) {
      row.querySelector<HTMLInputElement>("input[type=checkbox]")!.checked = !hidden.has(layerKey(layer, row.dataset.line!));
    }
    for (const row of list.querySelectorAll<HTMLElement>("li[data-item]")) {
      const [all, ...lines] = row.querySelectorAll<HTMLInputElement>("input[type=checkbox]");
      all!.checked = lines.some((line) => line.checked);
      all!.indeterminate = all!.checked && !lines.every((line) => line.checked);
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
    return el("li", { "data-line": name }, toggle("own", [name], null, ownColour(line.color)), el("div", { class: "line-words" }, field, length), close, mayMirror ? iconButton("mirror", words.mirror(name), () => drawing.mirror(name)) : null, iconButton("close", words.erase(name), () => drawing.erase(name)));
  }

  return {
    element,
    select: only("meta", "models", "fit", "drawing", "drawn"),
    update(state: Shown): void {
      const { lines, hidden, chosen } = state.drawn;
      const mayMirror = state.fit?.result ? mirrorPlane(state.fit.result) !== null : false;
      fill(own, [mayMirror, lines.present.map((line) => [line.name, line.closed, Math.round(lengthOf(line)), line.color])], () => lines.present.map((line) => ownRow(line, mayMirror)));
      check(own, "own", hidden);
      for (const row of own.querySelectorAll<HTMLElement>("li")) row.classList.toggle("is-chosen", row.dataset.line === chosen);
      const { fit } = state;
      const drawings = modelOf(state)?.side.drawings ?? [];
      const known = drawings.find((each) => each.name === fit?.drawingName);
      const onModel = [...(known?.shapes ?? []), ...drawings.flatMap((each) => each.shapes)];
      const nameOf = (name: string, label?: string): string => plainStart(labelOf(name, label) ?? onModel.find((each) => each.name === name)?.label ?? words.shapeName(name));
      const patterns = shownPatterns(state);
      const shapes = patterns?.shapes ?? known?.shapes ?? [];
      const labels = drawingLabels(state);
      const drawing = state.drawn.onScan ? state.drawing : (fit?.drawingName ?? "");
      const label = requestLabel(drawing, labels);
      const asRow = (shape: { name: string; label?: string; color?: string; kind?: string }): Line => ({ name: shape.name, label: shape.kind === "line" ? (labelOf(shape.name, shape.label) ?? shape.name) : nameOf(shape.name, shape.label), color: ownColour(shape.color) });
      reference.set("", fit && label !== "" ? itemsOf(shapes, asRow, (kind) => plannedLabel(kind, drawing, labels)) : [], hidden);
      const from = state.drawn.onScan;
      const brought = from?.carried.shapes ?? [];
      show(ofHere, lines.present.length > 0 || label !== "" || brought.length === 0);
      show(none, lines.present.length === 0 && label === "" && brought.length === 0);
      carried.set(brought.length > 0 ? words.carried(from!.from) : "", itemsOf(brought, asRow, (kind) => plannedLabel(kind, "", labels)), hidden);
      show(legend, (patterns?.shapes.length ?? 0) + brought.length > 0);
      const hasBridge = [...(patterns?.shapes ?? []), ...brought, ...lines.present].some((shape) => shape.bridged?.includes(true));
      show(dashed, hasBridge);
    },
  };
}
