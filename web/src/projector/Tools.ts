// The tools of the second screen: how its picture comes to scale.  They stand on the black picture and can be hidden.
import { button, iconButton, problem, segmented } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { formatMm } from "../ui/units";
import type { Side } from "./camera";
import { LEAST_POINTS } from "./dlt";
import { projectionOf, type ProjectorState, sightingsOf } from "./state";
import * as text from "./text";

const words = text.projector;

export interface ToolActions {
  readonly mode: (mode: ProjectorState["mode"]) => void;
  readonly bar: (pixels: number) => void;
  readonly measured: () => void;
  readonly measureAgain: () => void;
  readonly side: (side: Side) => void;
  readonly want: (name: string) => void;
  readonly skip: () => void;
  readonly remove: (name: string) => void;
  readonly clear: () => void;
  readonly hide: () => void;
  readonly full: () => void;
  readonly outline: (isOn: boolean) => void;
  readonly colours: (isOn: boolean) => void;
  readonly again: () => void;
  readonly dismiss: () => void;
}

export function createTools(actions: ToolActions): Panel<ProjectorState> {
  const modes = segmented<ProjectorState["mode"]>(words.mode, (["scale", "projector"] as const).map((value) => ({ value, label: words.modes[value] })), actions.mode);
  const bar = el("div", { class: "card-bar" });
  const width = el("input", { type: "range", min: 120, max: 1200, step: 0.5, class: "slider", "aria-label": words.scale.width, oninput: () => actions.bar(width.valueAsNumber) });
  const nudge = (by: number): void => actions.bar(width.valueAsNumber + by);
  const measuring = el(
    "div",
    { class: "panel" },
    el("p", {}, words.scale.how),
    bar,
    el("div", { class: "buttons-row" }, iconButton("back", words.scale.narrower, () => nudge(-0.5)), width, iconButton("on", words.scale.wider, () => nudge(0.5))),
    button(words.scale.done, actions.measured, "primary"),
  );
  const sides = segmented<Side>(words.scale.side, (["front", "left", "right"] as const).map((value) => ({ value, label: words.scale.sides[value] })), actions.side);
  const is = el("p", { class: "muted small" });
  const atScale = el("div", { class: "panel" }, sides.element, el("p", { class: "muted small" }, words.scale.move), is, button(words.scale.anew, actions.measureAgain, "link"));
  const now = el("p", { class: "projector-now", role: "status" });
  const list = el("ul", { class: "projector-points" });
  const residual = el("p", { role: "status" });
  const refused = el("p", { class: "look-here", role: "status" });
  const byPoints = el("div", { class: "panel" }, el("p", { class: "muted small" }, words.points.how), now, button(words.points.skip, actions.skip, "quiet outlined"), list, residual, refused, button(words.points.clear, actions.clear, "link"));
  const check = (label: string, changed: (isOn: boolean) => void): { box: HTMLInputElement; element: HTMLElement } => {
    const box = el("input", { type: "checkbox", onchange: () => changed(box.checked) });
    return { box, element: el("label", { class: "check" }, box, el("span", {}, label)) };
  };
  const outline = check(words.outline, actions.outline);
  const colours = check(words.colours, actions.colours);
  const wrong = problem(actions.dismiss);
  const aside = iconButton("exchange", words.aside, () => element.classList.toggle("is-right"));
  const hide = button(words.hide, actions.hide, "outlined");
  hide.title = words.hideHint;
  const full = button(words.full, actions.full, "outlined", "expand");
  full.title = words.fullHint;
  const element = el(
    "section",
    { class: "projector-tools", "aria-label": words.title },
    el("div", { class: "projector-head" }, el("h1", {}, words.title), aside),
    el("p", { class: "projector-warning" }, words.experimental),
    wrong.element,
    modes.element,
    measuring,
    atScale,
    byPoints,
    outline.element,
    colours.element,
    el("div", { class: "buttons-row" }, full, hide, iconButton("undo", words.again, actions.again)),
  );
  return {
    element,
    select: (state) => state,
    update(state: ProjectorState): void {
      show(element, !state.areToolsHidden);
      modes.set(state.mode);
      const isScale = state.mode === "scale";
      show(measuring, isScale && state.pixelsPerMm === null);
      show(atScale, isScale && state.pixelsPerMm !== null);
      show(byPoints, !isScale);
      width.valueAsNumber = state.barPixels;
      bar.style.width = `${state.barPixels}px`;
      sides.set(state.side);
      setText(is, words.scale.is((state.pixelsPerMm ?? 0).toFixed(2)));
      outline.box.checked = state.hasOutline;
      colours.box.checked = state.hasColours;
      wrong.set(state.problem ?? undefined);
      if (!isScale) updatePoints(state);
    },
  };

  function updatePoints(state: ProjectorState): void {
    const set = sightingsOf(state);
    const found = projectionOf(state);
    const isFound = typeof found !== "string";
    const wanted = state.landmarks.find(({ name }) => name === state.wanted);
    setText(now, wanted ? words.points.next(wanted.label) : words.points.all);
    const off = new Map(isFound ? set.map(({ name }, i) => [name, [found.pixels[i]!, found.mm[i]!] as const]) : []);
    fill(list, [state.landmarks.map(({ name }) => [name, state.clicks[name] ?? null, off.get(name)?.[1].toFixed(2)]), state.wanted], () =>
      state.landmarks.map(({ name, label }) => {
        const its = off.get(name);
        const says = state.clicks[name] ? (its ? words.points.off(its[0].toFixed(1), formatMm(its[1])) : "✓") : words.points.unset;
        const row = el("button", { type: "button", class: "projector-point", "aria-current": name === state.wanted ? "true" : null, title: words.points.again(label), onclick: () => actions.want(name) }, el("span", {}, label), el("span", { class: "muted small" }, says));
        return el("li", {}, row, state.clicks[name] ? iconButton("close", words.points.remove(label), () => actions.remove(name)) : null);
      }),
    );
    const missing = LEAST_POINTS - set.length;
    const note = set.length === LEAST_POINTS ? ` ${words.points.exact}` : "";
    setText(residual, missing > 0 ? words.points.missing(missing) : isFound ? words.points.residual(set.length, found.rmsPixels.toFixed(1), formatMm(found.rmsMm)) + note : "");
    setText(refused, isFound ? "" : words.points.refusals[found]);
    show(refused, !isFound && found !== "tooFew");
  }
}
