// The pattern that is planned, with its numbers, and a tumour by the clock.  They are drawn on the fitted body and changed
// there; the fit stays.  A field says what is drawn, as the handles on the body do.
import type { PatternInfo, PatternParameter, PlanLesion } from "../../api/types";
import { type DrawingRequest, mirroredValues, readRequest, requestText, startValue, stillNeeded, TUMOUR, type Values } from "../../fit/requestedDrawing";
import type { FitSlice } from "../../fit/state";
import { fit as fitText } from "../../fit/text";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, select } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { type NumberField, numberField, writtenNumber } from "../../ui/NumberField";
import type { Panel } from "../../ui/Panel";
import type { DrawingActions } from "../actions";
import { keyOf } from "./handles";
import type { DrawingSlice, LiveHandle, LivePart } from "../state";
import * as text from "../text";

const words = text.drawing.pattern;
const DEEPEST_MM = 150; // as the service takes it
const SAME = 1; // mm, degrees: what a field rounds, and a line on the scan beside one on the model

type Shown = Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice, "meta" | "scan" | "drawing" | "fit" | "drawn">;

/** What is kept of the plan in words and numbers, see plan/actions.ts. */
export interface PlanWords {
  note(text: string): void;
  depth(mm: number | null): void;
  lesions(lesions: readonly PlanLesion[]): void;
}

export function createDrawingPattern(drawing: Pick<DrawingActions, "choosePattern">, plan: PlanWords): Panel<Shown> {
  let state: Shown | null = null;
  const choose = (change: Partial<DrawingRequest>): void => {
    if (state) drawing.choosePattern(requestText({ ...readRequest(state.drawing), ...change }));
  };
  const base = select<string>(words.base, (value) => {
    choose({ base: value, values: {} });
    if (!parameters.element.hidden) element.scrollIntoView({ block: "start" }); // its numbers come in below it
  });
  const parameters = createFields("values", (values) => choose({ values }));
  let begun: Values | null = null; // a tumour of which not all is said: it is in no plan
  let begunOn: unknown = null; // the scan
  const begin = (values: Values | null): void => {
    begun = values;
    begunOn = state?.scan?.info.id;
    if (state) update(state);
  };
  const box = el("input", {
    type: "checkbox",
    onchange: () => {
      begin(box.checked ? {} : null);
      if (!box.checked && state && readRequest(state.drawing).tumour) choose({ tumour: null });
    },
  });
  const hasTumour = el("label", { class: "check" }, box, el("span", {}, words.tumour));
  const tumour = createFields(TUMOUR, (values) => {
    const isWhole = stillNeeded(tumourOf(state)!, values).length === 0;
    if (isWhole) begun = null;
    if (isWhole) choose({ tumour: values });
    else begin(readRequest(state!.drawing).tumour ? null : values); // what is entered stays as it is
  });
  const needed = el("p", { class: "muted small", role: "status", hidden: true });
  const depth = numberField({ name: "depth_mm", label: words.depth, unit: "mm", min: 0, max: DEEPEST_MM, hint: words.depthHint, mayBeEmpty: true, changed: (mm) => plan.depth(mm) });
  const sayings = el("textarea", { rows: 2, maxlength: 2000, placeholder: words.noteHint, "aria-label": words.note, onchange: () => plan.note(sayings.value) });
  const mirror = (part: LivePart): void => {
    const other = state && mirroredValues(readRequest(state.drawing)[part] ?? {});
    if (other) choose({ [part]: other });
  };
  const mirrorPattern = button(words.mirror, () => mirror("values"), "quiet outlined", "mirror");
  const mirrorTumour = button(words.mirror, () => mirror(TUMOUR), "quiet outlined", "mirror");
  const note = el("p", { class: "muted small" });
  const undrawn = el("p", { class: "look-here", role: "status", hidden: true });
  const fields = [base.element, undrawn, parameters.element, mirrorPattern, hasTumour, tumour.element, needed, depth.element, mirrorTumour, el("label", { class: "field wide" }, el("span", {}, words.note), sayings), note];
  const title = el("summary", {}, words.title);
  const element = el("details", { class: "pattern" }, title, el("div", { class: "panel" }, ...fields));

  return { element, select: only("meta", "scan", "drawing", "fit", "drawn"), update };

  function update(session: Shown): void {
    state = session;
    if (begunOn !== session.scan?.info.id) begun = null;
    const { meta } = session;
    if (!meta) return;
    const request = asDragged(session);
    base.set([{ value: "", label: fitText.noDrawing }, ...meta.drawings.map(({ name, label }) => ({ value: name, label }))], request.base);
    const { live } = session.drawn;
    const handles = live?.held === null && live.key === keyOf(session) ? live.handles : []; // of these numbers, on both sides
    parameters.set(meta.patterns.find(({ name }) => name === request.base && name !== TUMOUR) ?? null, request.values, handles);
    show(mirrorPattern, !parameters.element.hidden && mirroredValues(request.values) !== null);
    const clock = tumourOf(session);
    setText(title, clock === null ? words.titleWithoutTumour : words.title);
    show(hasTumour, clock !== null);
    box.checked = request.tumour !== null || begun !== null;
    tumour.set((request.tumour ?? begun) && clock, request.tumour ?? begun ?? {}, handles);
    show(needed, request.tumour === null && begun !== null && clock !== null);
    if (begun && clock) setText(needed, words.stillNeeded(stillNeeded(clock, begun).map(({ label }) => label)));
    show(depth.element, request.tumour !== null);
    depth.set(session.drawn.depthMm);
    if (document.activeElement !== sayings) sayings.value = session.drawn.note;
    show(mirrorTumour, mirroredValues(request.tumour ?? {}) !== null);
    const missing = session.drawn.onScan?.plan.missing.map(({ reason }) => reason) ?? [];
    setText(undrawn, missing.join(" "));
    show(undrawn, missing.length > 0);
    setText(note, session.fit?.state === "done" ? words.follows : words.needsFit);
  }
}

/** The fields of a pattern or tumour; they follow what is changed elsewhere: by a drag, by undoing, in another tab. */
function createFields(part: LivePart, changed: (values: Values) => void) {
  const element = el("div", { class: "parameters", hidden: true });
  let shown: Values = {};
  let numbers = new Map<PatternParameter, NumberField>();
  let choices = new Map<PatternParameter, HTMLSelectElement>();
  const change = (name: string, value: string): void => changed({ ...shown, [name]: value });

  function made(pattern: PatternInfo): HTMLElement[] {
    numbers = new Map();
    choices = new Map();
    return pattern.parameters.map((each) => {
      const { name, label, unit, min, max } = each;
      const hint = [each.about, min !== null && max !== null ? words.range(min, max, unit) : ""].filter((one) => one !== "").join("; ");
      if (each.choices) {
        const list = el("select", { "data-parameter": name, onchange: () => change(name, list.value) }, ...["", ...each.choices].slice(each.default === null ? 0 : 1).map((choice) => el("option", { value: choice }, words.choices[choice] ?? choice)));
        choices.set(each, list);
        return el("label", { class: "field", title: hint }, el("span", {}, label), list);
      }
      const field = numberField({ name, label, unit, min, max, hint, mayBeEmpty: !each.needed, changed: (value) => change(name, value === null ? "" : String(value)) });
      numbers.set(each, field);
      return field.element;
    });
  }

  return {
    element,
    set(pattern: PatternInfo | null, values: Values, handles: readonly LiveHandle[]): void {
      show(element, pattern !== null);
      fill(element, pattern?.name ?? "", () => (pattern ? made(pattern) : []));
      if (!pattern) return;
      shown = values;
      for (const [{ name }, list] of choices) {
        const value = values[name] ?? startValue(pattern.parameters.find((each) => each.name === name)!);
        if (list.value !== value) list.value = value;
      }
      for (const [parameter, field] of numbers) {
        const given = values[parameter.name] ?? startValue(parameter);
        const asked = given === "" ? null : Number(given);
        const drawn = drawnAt(handles.filter((each) => each.part === part), parameter.name);
        if (asked === null && parameter.needed) field.set(null, "");
        else if (asked === null) field.set(null, drawn.length > 0 ? words.byItselfAt(sidesSaid(drawn, parameter.unit)) : words.byItself);
        else if (drawn.every(({ value }) => apart(value, asked, parameter.unit) < SAME)) field.set(asked);
        else if (parameter.name === "nipple_above_fold_mm") field.set(Math.round(10 * Math.min(...drawn.map(({ value }) => value))) / 10, "", words.stopsAt(sidesSaid(drawn, parameter.unit)));
        else field.set(asked, "", words.drawnAt(sidesSaid(drawn, parameter.unit)));
      }
    },
  };
}

/** How far two numbers are apart; an axis is the same after half a turn, an hour after twelve. */
function apart(one: number, other: number, unit: string): number {
  const off = Math.abs(one - other);
  const round = { deg: 180, h: 12 }[unit];
  return round === undefined ? off : Math.min(off, Math.abs(round - off));
}

/** The numbers of a parameter as they are drawn on each side. */
const drawnAt = (handles: readonly LiveHandle[], parameter: string): { side: "L" | "R"; value: number }[] =>
  [...new Map(handles.flatMap(({ side, numbers, measured }) => numbers.filter((each) => each.parameter === parameter).map(({ value }) => [side, { side, value: measured?.[parameter] ?? value }] as const))).values()];

const sidesSaid = (drawn: readonly { side: "L" | "R"; value: number }[], unit: string): string => {
  const said = drawn.map(({ side, value }) => [words.sides[side], words.amount(writtenNumber(Math.round(10 * value) / 10, unit), unit)] as const);
  return said.every(([, amount]) => amount === said[0]![1]) ? said[0]![1] : said.map(([side, amount]) => `${amount} ${side}`).join(", ");
};

/** The drawing with the numbers that a hand drags just now. */
function asDragged({ drawing, drawn: { live } }: Shown): DrawingRequest {
  const request = readRequest(drawing);
  const part = live?.handles.find(({ id }) => id === live.held)?.part;
  return part && live.values ? { ...request, [part]: live.values } : request;
}

const tumourOf = (state: Pick<PageSlice, "meta"> | null): PatternInfo | null => state?.meta?.patterns.find(({ name }) => name === TUMOUR) ?? null;
