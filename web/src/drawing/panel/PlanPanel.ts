// The plan: what is planned on this scan, one row each, and below it the numbers of the chosen one, right and left in columns, as
// drawn.  What cannot be drawn says so in words of the operation.
import type { PlanLesion, PlanOnScan } from "../../api/types";
import { readRequest, requestText, TUMOUR } from "../../fit/requestedDrawing";
import type { FitSlice } from "../../fit/state";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { button, fileButton, iconButton, problem } from "../../ui/controls";
import { el, fill, icon, setText, show } from "../../ui/dom";
import { createMenu, menuItem } from "../../ui/menu";
import type { Panel } from "../../ui/Panel";
import type { DrawingActions } from "../actions";
import { lesionView } from "../lesions/LesionView";
import { mirrorPlane } from "../mirror/mirror";
import { type DrawingSlice, layerKey } from "../state";
import * as text from "../text";
import { chosenRow, itemKey, type PlanRow, planRows, type Shown as Planned } from "./items";
import { createLesionForm } from "./LesionForm";
import { createLineDetails } from "./LineDetails";
import "./panel.css";
import { createPatternNumbers } from "./PatternNumbers";
import type { PlanWords } from "./planWords";
import { planPanel as words } from "./text";
import { createToolNeeds } from "./ToolNeeds";

export type PlanPanelShown = Planned & Pick<PageSlice & ScanSlice & FitSlice & DrawingSlice, "problems" | "scan" | "slices" | "hasPen" | "fingersDraw">;
type Missing = PlanOnScan["missing"][number];

const NEW_LESION = "lesion"; // the item of which nothing is said yet
const MARKS: Readonly<Record<PlanRow["kind"], string>> = { line: "mark-line", pattern: "mark-line", carried: "mark-line is-carried", tumour: "mark-lesion", lesion: "mark-lesion", note: "mark-note" };

/** `first`: what stands above the list; `last`: what other features have to say about the plan, below the rest. */
export function createPlanPanel(drawing: DrawingActions, plan: PlanWords, dismiss: () => void, first: HTMLElement, last: HTMLElement): Panel<PlanPanelShown> {
  let state: PlanPanelShown | null = null;
  const wrong = problem(dismiss);
  const again = button(text.drawing.again, () => void drawing.saveNow(), "link");
  const needs = createToolNeeds(drawing);
  const add = createAdd();
  const list = el("ul", { class: "plan-items", "aria-label": words.title });
  const none = el("p", { class: "muted" }, words.none);
  const refused = el("div", { class: "panel", role: "status" });
  const legend = el("p", { class: "muted small", hidden: true }, text.drawing.dashed);

  const title = el("h3", {});
  const remove = iconButton("close", "", () => chosen && takeOut(chosen));
  const head = el("div", { class: "item-head" }, title, el("span", { class: "spring" }), remove);
  const numbers = { values: createPatternNumbers("values", drawing, (mm) => plan.depth(mm)), tumour: createPatternNumbers(TUMOUR, drawing, (mm) => plan.depth(mm)) };
  const line = createLineDetails(drawing);
  const lesion = el("div", {});
  const form = createLesionForm(() => text.lesions.numbered((state?.drawn.lesions.length ?? 0) + 1), (given) => {
    plan.lesions([...(state?.drawn.lesions ?? []), given]);
    drawing.chooseItem(itemKey.lesion(given.id));
  }, drawing.markLesion);
  const sayings = el("textarea", { rows: 3, maxlength: 2000, placeholder: words.noteHint, "aria-label": text.drawing.pattern.note, onchange: () => plan.note(sayings.value) });
  const elsewhere = el("p", { class: "muted small" });
  const onBody = el("div", {});
  const details = el("section", { class: "panel item-details" }, head, numbers.values.element, numbers.tumour.element, line.element, lesion, form.element, sayings, elsewhere, onBody);
  let chosen: PlanRow | null = null;
  const element = el("div", { class: "panel drawing" }, first, wrong.element, again, el("div", { class: "plan-head" }, el("h2", {}, words.title), el("span", { class: "spring" }), add.element), needs.element, list, none, refused, details, legend, last);

  return {
    element,
    select: only("meta", "models", "problems", "scan", "drawing", "fit", "drawn", "lesion", "slices", "item", "stances", "hasPen", "fingersDraw"),
    update,
  };

  function update(session: PlanPanelShown): void {
    state = session;
    const { drawn } = session;
    wrong.set(session.problems.drawing);
    show(again, drawn.saving === "unsaved" && session.problems.drawing !== undefined);
    needs.update(session);
    add.update(session);
    const rows = planRows(session);
    chosen = chosenRow(rows, session);
    fill(list, [rows.map(({ key, label, says, hint, isHidden, lines }) => [key, label, says, hint, isHidden, lines[0]?.colour]), chosen?.key], () => rows.map(rowOf));
    show(none, rows.length === 0);
    setText(none, session.stances.isCarrying ? words.carrying : words.none);
    const missing = drawn.onScan?.plan.missing ?? [];
    const marks = (drawn.onScan?.plan.marks ?? []).flatMap(({ asked }) => asked.map(({ says }) => says));
    fill(refused, [missing, marks], () => [
      ...[...new Set(missing.map(({ item }) => item))].map((item) => refusal(missing.filter((each) => each.item === item))),
      ...marks.map((says) => el("p", { class: "question-words" }, icon("alert"), says)),
    ]);
    show(refused, missing.length + marks.length > 0);
    show(legend, [...(drawn.onScan?.plan.shapes ?? []), ...drawn.lines.present].some((shape) => shape.bridged?.includes(true)));
    updateDetails(session);
  }

  function rowOf({ key, kind, label, says, hint, isHidden, lines }: PlanRow): HTMLElement {
    const mark = el("span", { class: `item-mark ${MARKS[kind]}`, "aria-hidden": "true" });
    const colour = lines[0]?.colour;
    if (colour && kind !== "tumour" && kind !== "lesion") mark.style.background = colour;
    const name = el("span", { class: "item-name" }, label);
    const row = el("button", { type: "button", class: "plan-item", title: hint === "" ? label : `${label}: ${hint}`, "aria-pressed": String(key === chosen?.key), "data-item": key, onclick: () => drawing.chooseItem(key === chosen?.key ? "" : key) }, mark, name, el("span", { class: "muted small" }, isHidden ? words.hidden : says));
    return el("li", { class: isHidden ? "is-hidden-item" : "" }, row);
  }

  /** In words of the operation, with what would go instead. */
  function refusal(sides: readonly Missing[]): HTMLElement {
    const [{ instead = [] }] = sides as [Missing];
    const reasons = sides.map(({ reason }) => (instead.length > 0 ? problemOf(reason) : reason));
    const take = (way: (typeof instead)[number]): void => drawing.choosePattern(requestText({ ...readRequest(state!.drawing), base: way.name, values: textsOf(way.parameters) }));
    return el("div", { class: "look-here refusal" }, ...reasons.map((reason) => el("p", {}, reason)), ...(instead.length > 0 ? [el("div", { class: "buttons-row" }, ...instead.map((way) => button(way.label, () => take(way), "outlined")))] : []));
  }

  function takeOut(row: PlanRow): void {
    if (!state) return;
    const request = readRequest(state.drawing);
    if (row.kind === "pattern") drawing.choosePattern(requestText({ ...request, base: "", values: {} }));
    if (row.kind === "tumour") drawing.choosePattern(requestText({ ...request, tumour: null }));
    if (row.kind === "lesion" && row.own) plan.lesions(state.drawn.lesions.filter((each) => each !== row.own));
    if (row.kind === "note") plan.note("");
    drawing.chooseItem(null);
  }

  function updateDetails(session: PlanPanelShown): void {
    const { drawn, item } = session;
    const isNew = (key: string): boolean => chosen === null && item === key && session.lesion === null && drawn.chosen === null;
    const kind = chosen?.kind ?? (isNew(itemKey.tumour) ? "tumour" : isNew(itemKey.note) ? "note" : isNew(NEW_LESION) ? "new lesion" : null);
    show(details, kind !== null);
    if (kind !== "tumour") numbers.tumour.dropBegun();
    const label = chosen?.label ?? { tumour: words.tumour, note: words.note, "new lesion": words.lesion }[kind as string] ?? "";
    setText(title, kind === "note" ? words.note : label);
    details.setAttribute("aria-label", label);
    show(remove, chosen !== null && (kind === "pattern" || kind === "tumour" || kind === "note" || (chosen.kind === "lesion" && chosen.own !== null)));
    remove.setAttribute("aria-label", words.remove(label));
    remove.title = words.remove(label);
    numbers.values.update(session);
    numbers.tumour.update(session);
    if (kind !== "pattern") show(numbers.values.element, false);
    if (kind !== "tumour") show(numbers.tumour.element, false);
    show(line.element, chosen?.kind === "line");
    if (chosen?.kind === "line") line.update(chosen.line, session.fit?.result ? mirrorPlane(session.fit.result) !== null : false, drawn);
    show(lesion, chosen?.kind === "lesion");
    if (chosen?.kind === "lesion") showLesion(chosen, session);
    show(form.element, kind === "new lesion");
    form.update(session.scan?.info.image != null);
    show(sayings, kind === "note");
    if (document.activeElement !== sayings) sayings.value = drawn.note;
    show(elsewhere, kind === "carried");
    setText(elsewhere, words.elsewhere(drawn.onScan?.from ?? ""));
    showLines(chosen, drawn.hidden);
  }

  function showLesion({ own, laid }: PlanRow & { readonly kind: "lesion" }, { drawn, slices }: PlanPanelShown): void {
    const focused = lesion.contains(document.activeElement) ? document.activeElement!.getAttribute("aria-label") : null;
    fill(lesion, [laid, own, drawn.chosen, slices.moves], () => {
      const change = (part: Partial<PlanLesion>): void => plan.lesions(state!.drawn.lesions.map((each) => (each.id === own?.id ? { ...each, ...part } : each)));
      return [lesionView(laid, drawn.chosen, own && { lesion: own, isMoved: slices.moves, move: () => drawing.moveLesion(!slices.moves), change })];
    });
    if (focused) lesion.querySelector<HTMLElement>(`[aria-label="${CSS.escape(focused)}"]`)?.focus(); // what takes it into the hand
  }

  /** On and off on the body: the whole item, and each of its lines. */
  function showLines(row: PlanRow | null, hidden: ReadonlySet<string>): void {
    const lines = row?.lines ?? [];
    fill(onBody, [row?.key, row?.label, lines], () => {
      if (!row || lines.length === 0) return [];
      const toggle = (names: readonly string[], label: string, said: string): HTMLElement => {
        const box = el("input", { type: "checkbox", "aria-label": words.show(label), "data-names": JSON.stringify(names), onchange: () => drawing.show(row.layer, names, box.checked) });
        return el("label", { class: "check" }, box, el("span", {}, said));
      };
      const all = toggle(lines.map(({ name }) => name), row.label, words.showShort);
      if (lines.length === 1) return [all];
      const each = lines.map(({ name, label }) => el("li", { "data-line": name }, toggle([name], label, label)));
      return [all, el("details", { class: "more-numbers" }, el("summary", {}, words.lines(lines.length)), el("ul", {}, ...each))];
    });
    for (const box of onBody.querySelectorAll<HTMLInputElement>("input[type=checkbox]")) {
      const names = JSON.parse(box.dataset.names!) as string[];
      const shown = names.filter((name) => !hidden.has(layerKey(row!.layer, name)));
      box.checked = shown.length > 0;
      box.indeterminate = shown.length > 0 && shown.length < names.length;
    }
  }

  /** What may be added: patterns, lines, tumours, words. */
  function createAdd() {
    const patterns = el("div", {});
    const item = (key: string): void => {
      drawing.chooseItem(key);
      menu.close();
      details.scrollIntoView({ block: "nearest" });
      details.querySelector<HTMLElement>("input:not([hidden]), select, textarea")?.focus();
    };
    const withTool = (tool: "pen" | "tumour"): void => {
      menu.close();
      drawing.take(tool);
    };
    const file = fileButton(words.importFile, ".json", "menu-item", (chosen) => {
      menu.close();
      void drawing.importFile(chosen);
    });
    file.querySelector("input")!.id = "drawing-file";
    file.title = words.importHint;
    const clock = menuItem(words.clock, words.clockHint, () => {
      if (state && readRequest(state.drawing).tumour === null) numbers.tumour.begin();
      item(itemKey.tumour);
    });
    const menu = createMenu(
      "add-menu", words.add, words.addHint, "link add-to-plan",
      patterns, el("hr"), menuItem(words.pen, words.penHint, () => withTool("pen")), menuItem(words.circle, words.circleHint, () => withTool("tumour")), clock,
      menuItem(words.lesion, words.lesionHint, () => item(NEW_LESION)), menuItem(words.note, words.noteHint, () => item(itemKey.note)), el("hr"), file,
    );
    return {
      element: menu.element,
      update({ meta, drawing: asked }: PlanPanelShown): void {
        const { base } = readRequest(asked);
        fill(patterns, [meta?.drawings, base], () =>
          (meta?.drawings ?? []).filter(({ name }) => name !== base).map(({ name, label }) =>
            menuItem(base === "" ? label : words.instead(label), "", () => {
              drawing.choosePattern(requestText({ ...readRequest(state!.drawing), base: name, values: {} }));
              drawing.chooseItem(itemKey.pattern);
              menu.close();
            }),
          ),
        );
        show(clock, meta?.patterns.some(({ name }) => name === TUMOUR) ?? false);
      },
    };
  }
}

/** The first sentence of a refusal; what to do stands on buttons. */
const problemOf = (reason: string): string => /^.*?\.(?= |$)/.exec(reason)?.[0] ?? reason;

const textsOf = (parameters: Readonly<Record<string, number | string>>): Record<string, string> => Object.fromEntries(Object.entries(parameters).map(([name, value]) => [name, String(value)]));
