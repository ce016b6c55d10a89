// The model's drawing: which one, with which numbers, and a tumour by the clock.  It is made on the fitted body
// and changed there; the fit stays.
import type { PatternInfo, PatternParameter } from "../../api/types";
import { checked, type DrawingRequest, mirroredValues, readRequest, requestText, startValue, startValues, TUMOUR, type Values } from "../../fit/requestedDrawing";
import type { FitSlice } from "../../fit/state";
import { fit as fitText } from "../../fit/text";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, select } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { DrawingActions } from "../actions";
import type { DrawingSlice } from "../state";
import * as text from "../text";

const words = text.drawing.pattern;
const DEEPEST_MM = 150; // as the service takes it

type Shown = Pick<PageSlice & FitSlice & DrawingSlice, "meta" | "drawing" | "fit" | "drawn">;

/** What is kept of the plan in words and numbers, see plan/actions.ts. */
export interface PlanWords {
  note(text: string): void;
  depth(mm: number | null): void;
}

export function createDrawingPattern(drawing: Pick<DrawingActions, "choosePattern">, plan: PlanWords): Panel<Shown> {
  let state: Shown | null = null;
  const choose = (change: Partial<DrawingRequest>): void => {
    if (state) drawing.choosePattern(requestText({ ...readRequest(state.drawing), ...change }));
  };
  const base = select<string>(words.base, (value) => choose({ base: value, values: {} }));
  const parameters = el("div", { class: "parameters" });
  const box = el("input", { type: "checkbox", onchange: () => choose({ tumour: box.checked ? startValues(tumourOf(state)!) : null }) });
  const hasTumour = el("label", { class: "check" }, box, el("span", {}, words.tumour));
  const tumour = el("div", { class: "parameters" });
  const depth = el("input", {
    type: "number",
    min: 0,
    max: DEEPEST_MM,
    step: 1,
    inputmode: "numeric",
    "data-parameter": "depth_mm",
    onchange: () => depth.reportValidity() && plan.depth(depth.value === "" ? null : depth.valueAsNumber),
  });
  const depthField = el("label", { class: "field", title: words.depthHint, hidden: true }, el("span", {}, words.depth, el("span", { class: "unit" }, " mm")), depth);
  const sayings = el("textarea", { rows: 2, maxlength: 2000, placeholder: words.noteHint, "aria-label": words.note, onchange: () => plan.note(sayings.value) });
  let mirrorings = 0; // the fields are written anew after each
  const mirror = (part: "values" | "tumour"): void => {
    const other = state && mirroredValues(readRequest(state.drawing)[part] ?? {});
    mirrorings += 1;
    if (other) choose({ [part]: other });
  };
  const mirrorPattern = button(words.mirror, () => mirror("values"), "quiet outlined", "mirror");
  const mirrorTumour = button(words.mirror, () => mirror("tumour"), "quiet outlined", "mirror");
  const note = el("p", { class: "muted small" });
  const undrawn = el("p", { class: "look-here", role: "status", hidden: true });
  const element = el("details", { class: "pattern" }, el("summary", {}, words.title), el("div", { class: "panel" }, base.element, parameters, mirrorPattern, hasTumour, tumour, depthField, mirrorTumour, el("label", { class: "field wide" }, el("span", {}, words.note), sayings), undrawn, note));

  function field(parameter: PatternParameter, value: string, changed: (value: string) => void): HTMLElement {
    const hint = [parameter.about, parameter.min !== null && parameter.max !== null ? words.range(parameter.min, parameter.max, parameter.unit) : ""].filter((each) => each !== "").join("; ");
    const label = el("span", {}, parameter.label, el("span", { class: "unit" }, parameter.unit === "" ? "" : ` ${words.units[parameter.unit]}`));
    if (parameter.choices) {
      const list = el("select", { "data-parameter": parameter.name, onchange: () => changed(list.value) }, ...parameter.choices.map((choice) => el("option", { value: choice, selected: choice === value }, words.choices[choice] ?? choice)));
      return el("label", { class: "field", title: hint }, label, list);
    }
    const input = el("input", {
      type: "number",
      step: "any",
      min: parameter.min,
      max: parameter.max,
      value,
      placeholder: words.byItself,
      "data-parameter": parameter.name,
      oninput: () => input.setCustomValidity(""),
      onchange: () => {
        const good = checked(parameter, input.value);
        if (good !== null) return changed(good);
        input.setCustomValidity(words.outside(parameter.label, parameter.min, parameter.max, parameter.unit));
        input.reportValidity();
      },
    });
    return el("label", { class: "field", title: hint }, label, input);
  }

  const fields = (pattern: PatternInfo, values: Values, changed: (name: string, value: string) => void): HTMLElement[] =>
    pattern.parameters.map((each) => field(each, values[each.name] ?? startValue(each), (value) => changed(each.name, value)));

  return {
    element,
    select: only("meta", "drawing", "fit", "drawn"),
    update(session: Shown): void {
      state = session;
      const { meta } = session;
      if (!meta) return;
      const request = asDragged(session);
      base.set([{ value: "", label: fitText.noDrawing }, ...meta.drawings.map(({ name, label }) => ({ value: name, label }))], request.base);
      const pattern = meta.patterns.find(({ name }) => name === request.base && name !== TUMOUR);
      fill(parameters, [request.base, Boolean(pattern), mirrorings], () => (pattern ? fields(pattern, request.values, (name, value) => state && choose({ values: { ...readRequest(state.drawing).values, [name]: value } })) : []));
      if (pattern) showValues(parameters, pattern, request.values);
      show(parameters, pattern !== undefined);
      show(mirrorPattern, pattern !== undefined && mirroredValues(request.values) !== null);
      const clock = tumourOf(session);
      show(hasTumour, clock !== null);
      box.checked = request.tumour !== null;
      fill(tumour, [request.tumour !== null, mirrorings], () =>
        clock && request.tumour ? fields(clock, request.tumour, (name, value) => state && choose({ tumour: { ...readRequest(state.drawing).tumour, [name]: value } })) : [],
      );
      if (clock && request.tumour) showValues(tumour, clock, request.tumour);
      show(tumour, request.tumour !== null);
      show(depthField, request.tumour !== null);
      if (document.activeElement !== depth) depth.value = session.drawn.depthMm === null ? "" : String(session.drawn.depthMm);
      if (document.activeElement !== sayings) sayings.value = session.drawn.note;
      show(mirrorTumour, mirroredValues(request.tumour ?? {}) !== null);
      const missing = session.drawn.onScan?.plan.missing.map(({ reason }) => reason) ?? [];
      setText(undrawn, missing.join(" "));
      show(undrawn, missing.length > 0);
      setText(note, session.fit?.state === "done" ? words.follows : words.needsFit);
    },
  };
}

/** The drawing with the numbers that a hand drags just now. */
function asDragged({ drawing, drawn: { live } }: Shown): DrawingRequest {
  const request = readRequest(drawing);
  const part = live?.handles.find(({ id }) => id === live.held)?.part;
  return part && live.values ? { ...request, [part]: live.values } : request;
}

/** The fields follow what is changed elsewhere: by a drag, by undoing, in another tab. */
function showValues(fields: HTMLElement, pattern: PatternInfo, values: Values): void {
  for (const parameter of pattern.parameters) {
    const input = fields.querySelector<HTMLInputElement | HTMLSelectElement>(`[data-parameter="${parameter.name}"]`);
    const value = values[parameter.name] ?? startValue(parameter);
    if (input && input !== document.activeElement && input.value !== value) input.value = value;
  }
}

const tumourOf = (state: Pick<PageSlice, "meta"> | null): PatternInfo | null => state?.meta?.patterns.find(({ name }) => name === TUMOUR) ?? null;
