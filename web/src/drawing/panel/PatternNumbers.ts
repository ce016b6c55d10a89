// The numbers of the chosen pattern or tumour as they are drawn, the patient's right and left in columns; dashed where the body
// did not let them be as asked.  They are changed here as by the handles on the body; the fit stays.
import type { PatternInfo, PatternParameter } from "../../api/types";
import { areApart, type DrawingRequest, mirroredValues, nameOn, readRequest, requestText, setApart, setTogether, startValue, stillNeeded, TUMOUR, type Values } from "../../fit/requestedDrawing";
import type { FitSlice } from "../../fit/state";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { button } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import { type NumberField, numberField, writtenNumber } from "../../ui/NumberField";
import type { DrawingActions } from "../actions";
import { keyOf } from "../patterns/handles";
import type { DrawingSlice, LiveHandle, LivePart } from "../state";
import { drawing as drawingText } from "../text";
import { columnsOf, drawnNumber, reasonsOf } from "./drawnNumbers";
import { planPanel as words, type Side } from "./text";

const patternText = drawingText.pattern;
const DEEPEST_MM = 150; // as the service takes it

export type NumbersShown = Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice, "meta" | "scan" | "drawing" | "fit" | "drawn">;

interface Cell {
  readonly parameter: PatternParameter;
  readonly side: Side | null;
  readonly field: NumberField;
}

/** `part`: of the drawing, its pattern or its tumour. */
export function createPatternNumbers(part: LivePart, drawing: Pick<DrawingActions, "choosePattern">, depthMm: (mm: number | null) => void) {
  let state: NumbersShown | null = null;
  let cells: Cell[] = [];
  let choices = new Map<string, HTMLSelectElement>();
  let begun: Values | null = null; // a tumour of which not all is said: it is in no plan
  let begunOn: unknown = null; // the scan
  let shownOn: unknown = null; // likewise
  const table = el("div", { class: "numbers" });
  const needed = el("p", { class: "muted small", role: "status", hidden: true });
  const forced = el("p", { class: "muted small why-dashed", hidden: true });
  const depth = numberField({ name: "depth_mm", label: patternText.depth, unit: "mm", min: 0, max: DEEPEST_MM, hint: patternText.depthHint, mayBeEmpty: true, changed: depthMm });
  const mirror = button(patternText.mirror, () => {
    const other = state && mirroredValues(valuesOf(state));
    if (other) choose(other);
  }, "quiet outlined", "mirror");
  const change = (to: (values: Values, info: PatternInfo) => Values): void => {
    const info = state && infoOf(state);
    if (state && info) choose(to(valuesOf(state), info));
  };
  const apart = button(words.setApart, () => change((values, { parameters }) => setApart(values, parameters)), "quiet outlined");
  const together = (["R", "L"] as const).map((side) => button(words.bothAs(words.sides[side]), () => change((values, { parameters }) => setTogether(values, parameters, side)), "quiet outlined"));
  const note = el("p", { class: "muted small" });
  const element = el("div", { class: "panel" }, table, needed, part === TUMOUR ? depth.element : null, forced, el("div", { class: "buttons-row" }, mirror, apart, ...together), note);

  const infoOf = ({ meta, drawing: asked }: Pick<NumbersShown, "meta" | "drawing">): PatternInfo | null =>
    meta?.patterns.find(({ name }) => name === (part === TUMOUR ? TUMOUR : readRequest(asked).base)) ?? null;
  const valuesOf = (now: NumbersShown): Values => begun ?? asDragged(now)[part] ?? {};

  function choose(values: Values): void {
    if (!state) return;
    const info = infoOf(state);
    const request = readRequest(state.drawing);
    if (part === TUMOUR && info && stillNeeded(info, values).length > 0) {
      if (!request.tumour) begin(values); // else what is entered stays as it is
      return update(state);
    }
    begun = null;
    drawing.choosePattern(requestText({ ...request, [part]: values }));
  }

  function begin(values: Values): void {
    begun = values;
    begunOn = state?.scan?.info.id;
  }

  function made(info: PatternInfo, columns: readonly (Side | null)[]): HTMLElement[] {
    cells = [];
    choices = new Map();
    const pick = ({ name }: PatternParameter, value: string): void => change((values, { parameters }) => ({ ...(name === "side" && (value === "R" || value === "L") && areApart(values) ? setTogether(values, parameters, value) : values), [name]: value }));
    const type = ({ name }: PatternParameter, side: Side | null, value: number | null): void => change((values) => ({ ...values, [side && areApart(values) ? nameOn(name, side) : name]: value === null ? "" : String(value) }));
    const row = (parameter: PatternParameter): HTMLElement => {
      const { name, label, unit, min, max } = parameter;
      const hint = [parameter.about, min !== null && max !== null ? patternText.range(min, max, unit) : ""].filter((one) => one !== "").join("; ");
      if (parameter.choices) {
        const list = el("select", { "data-parameter": name, onchange: () => pick(parameter, list.value) }, ...["", ...parameter.choices].slice(parameter.default === null ? 0 : 1).map((choice) => el("option", { value: choice }, patternText.choices[choice] ?? choice)));
        choices.set(name, list);
        return el("label", { class: "numbers-row", title: hint }, el("span", {}, label), list);
      }
      const says = el("p", { class: "field-note small", role: "status", hidden: true });
      const fields = columns.map((side) => {
        const field = numberField({ name, label: words.numberOf(label, side && columns.length > 1 ? words.sides[side] : ""), unit, min, max, hint, mayBeEmpty: !parameter.needed, says, changed: (value) => type(parameter, side, value) });
        field.element.dataset.side = side ?? "";
        cells.push({ parameter, side, field });
        return field.element;
      });
      return el("div", { class: "numbers-row", title: hint }, el("span", { "aria-hidden": "true" }, label, unit === "mm" ? null : el("span", { class: "unit" }, ` ${{ deg: "°", h: "h" }[unit as string] ?? ""}`)), ...fields, says);
    };
    const folded = part === TUMOUR ? [] : info.parameters.filter((each) => partOf(each) !== null);
    const first = info.parameters.filter((each) => !folded.includes(each));
    const heads = columns.flatMap((side) => (side ? [el("span", { class: `side-letter side-${words.sides[side]}`, title: words.breast[side] }, words.letters[side])] : []));
    const parts = [...new Set(folded.map((each) => words.parts[partOf(each)!]))];
    return [
      ...(heads.length > 0 ? [el("div", { class: "numbers-row numbers-head" }, el("span", { class: "muted small" }, words.asDrawn), ...heads)] : []),
      ...first.map(row),
      ...(folded.length > 0 ? [el("details", { class: "more-numbers" }, el("summary", {}, words.more(parts)), ...folded.map(row))] : []),
    ];
  }

  function update(session: NumbersShown): void {
    state = session;
    if (begunOn !== session.scan?.info.id) begun = null;
    const info = infoOf(session);
    show(element, info !== null);
    if (!info) return;
    const values = valuesOf(session);
    const columns = columnsOf(values, info.parameters);
    const isOpen = table.querySelector("details")?.open ?? false;
    const focused = table.contains(document.activeElement) ? document.activeElement!.getAttribute("data-parameter") : null;
    const on = session.scan?.info.id;
    if (shownOn !== on) depth.drop();
    shownOn = on;
    if (!fill(table, [info.name, columns, on], () => made(info, columns), () => state && update(state))) return; // the numbers of another pattern, one of which is being typed
    const more = table.querySelector("details");
    if (more && isOpen) more.open = true;
    if (focused && !table.contains(document.activeElement)) table.querySelector<HTMLElement>(`[data-parameter="${focused}"]`)?.focus(); // a side was chosen
    const { live } = session.drawn;
    const handles: readonly LiveHandle[] = live?.held === null && live.key === keyOf(session) ? live.handles : []; // of these numbers, on both sides
    for (const [name, list] of choices) {
      const value = values[name] ?? startValue(info.parameters.find((each) => each.name === name)!);
      if (list.value !== value) list.value = value;
    }
    for (const { parameter, side, field } of cells) {
      const { value, drawn, isForced } = drawnNumber(parameter, values, part, side, handles);
      if (live?.held) field.drop(); // a hand says another number
      field.set(value, parameter.needed ? "" : drawn === null ? words.auto : writtenNumber(drawn, parameter.unit));
      field.element.classList.toggle("is-forced", isForced);
    }
    const reasons = reasonsOf(info.parameters, values, part, handles);
    setText(forced, words.dashed(reasons));
    show(forced, reasons.length > 0);
    show(needed, begun !== null);
    if (begun) setText(needed, patternText.stillNeeded(stillNeeded(info, begun).map(({ label }) => label)));
    show(depth.element, begun === null);
    depth.set(session.drawn.depthMm);
    show(mirror, begun === null && mirroredValues(values) !== null);
    show(apart, columns.length > 1 && !areApart(values));
    for (const each of together) show(each, columns.length > 1 && areApart(values));
    setText(note, session.fit?.state === "done" ? "" : patternText.needsFit);
  }

  return {
    element,
    update,
    /** The fields of a tumour of which nothing is said yet. */
    begin: (): void => begin({}),
    isBegun: (): boolean => begun !== null,
    dropBegun: (): void => void (begun = null),
  };
}

/** Which folded part a parameter belongs to; null where it stands with the first ones. */
function partOf({ name, unit, choices }: PatternParameter): keyof typeof words.parts | null {
  if (choices) return "side";
  if (unit === "deg") return "angles";
  return name === "nipple_outward_mm" ? "position" : name === "fold_below_mm" ? "fold" : null;
}

/** The drawing with the numbers that a hand drags just now. */
function asDragged({ drawing, drawn: { live } }: NumbersShown): DrawingRequest {
  const request = readRequest(drawing);
  const part = live?.handles.find(({ id }) => id === live.held)?.part;
  return part && live.values ? { ...request, [part]: live.values } : request;
}
