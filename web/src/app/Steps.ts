// The left side: the steps, of which one is open, and the one primary button that says what to do next.
import type { Actions } from "./actions";
import { el, icon, setText, show } from "../ui/dom";
import { nextStep, type NextStep } from "./nextStep";
import { pickCount, type Session, type Step } from "./session";
import { text } from "../ui/text";
import { formatCount, formatMm } from "../ui/units";
import { button } from "../ui/controls";
import type { Panel } from "../ui/Panel";

const ORDER: Step[] = ["scan", "landmarks", "fit", "drawing", "result"];

function summary(step: Step, state: Session): string {
  if (!state.scan) return "";
  if (step === "scan") return text.scan.summary(formatCount(state.scan.info.triangles));
  if (step === "landmarks") return text.landmarks.progress(pickCount(state), state.meta?.landmarks.length ?? 0);
  if (step === "drawing") return text.drawing.summary(state.drawn.lines.present.length);
  if (step === "fit") return state.fit?.result ? text.fit.summary(formatMm(state.fit.result.surface_distance_mm.mean)) : "";
  return "";
}

function isDone(step: Step, state: Session): boolean {
  if (step === "scan") return state.scan !== null;
  if (step === "landmarks") return pickCount(state) > 0 && pickCount(state) === state.meta?.landmarks.length;
  if (step === "drawing") return state.drawn.lines.present.length > 0;
  return state.fit?.state === "done";
}

export function createSteps(actions: Actions, bodies: Record<Step, Panel>): Panel {
  const sections = ORDER.map((step, i) => {
    const badge = el("span", { class: "badge", "aria-hidden": "true" });
    const note = el("span", { class: "summary" });
    const head = el(
      "button",
      { type: "button", class: "step-head", "aria-controls": `step-${step}`, onclick: () => actions.page.goTo(step) },
      badge,
      el("span", { class: "step-name" }, text.steps[step]),
      " ",
      note,
    );
    const before = el("p", { class: "muted before" }, text[step].before);
    const body = el("div", { class: "step-body", id: `step-${step}` }, before, bodies[step].element);
    const element = el("section", { class: "step" }, el("h2", {}, head), body);
    return { step, number: i + 1, element, head, badge, note, before, body };
  });
  const next = createNextButton(actions);
  const list = el("div", { class: "steps-scroll" }, ...sections.map((section) => section.element));
  const element = el("nav", { class: "steps", "aria-label": text.stepsLabel }, list, next.element);
  return {
    element,
    update(state: Session): void {
      for (const { step, number, element: section, head, badge, note, before, body } of sections) {
        const isOpen = state.scan !== null && state.step === step;
        const done = isDone(step, state);
        section.classList.toggle("is-open", isOpen);
        head.setAttribute("aria-expanded", String(isOpen));
        head.disabled = state.scan === null;
        setText(note, summary(step, state));
        badge.classList.toggle("is-done", done);
        if (badge.dataset.done !== String(done)) {
          badge.dataset.done = String(done);
          badge.replaceChildren(done ? icon("check") : String(number));
        }
        const hasContent = state.scan !== null && (step !== "result" || state.fit !== null);
        show(before, !hasContent);
        show(body, isOpen || state.scan === null);
        show(bodies[step].element, hasContent);
        bodies[step].update(state);
      }
      next.update(state);
    },
  };
}

function wording(next: NextStep, state: Session): string {
  if (next.kind === "place") {
    const entry = state.meta?.landmarks.find((each) => each.name === next.landmark);
    const label = entry ? text.landmarks.spoken(entry) : next.landmark;
    return next.isArmed ? text.next.armed(label) : text.next.start(label);
  }
  if (next.kind === "confirm scan") return text.scan.confirm;
  if (next.kind === "confirm") return text.proposals.confirmLikely(next.names.length);
  if (next.kind === "fit" && next.again) return text.fit.again(next.landmarks);
  if (next.kind === "fit") return next.landmarks > 0 ? text.fit.with(next.landmarks) : text.fit.without;
  if (next.kind === "carry") return text.stances.carry.go(next.to);
  return next.kind === "save" ? text.result.save : "";
}

function createNextButton(actions: Actions): Panel {
  let next: NextStep = { kind: "none" };
  const press = (): void => {
    if (next.kind === "confirm scan") actions.scan.confirm();
    if (next.kind === "place") actions.landmarks.want(next.isArmed ? null : next.landmark);
    if (next.kind === "confirm") actions.landmarks.confirm(next.names);
    if (next.kind === "carry") void actions.stances.carry();
    if (next.kind === "fit") void actions.fit.start();
  };
  const words = el("span", {});
  const go = el("button", { type: "button", class: "button primary", id: "next", onclick: press }, words);
  const save = el("a", { class: "button primary", id: "save", download: "fitted.glb" }, icon("download"), el("span", {}, text.result.save));
  const other = button("", () => void actions.fit.start(), "quiet wide");
  const otherWords = other.querySelector("span")!;
  const element = el("div", { class: "next" }, go, save, other);
  return {
    element,
    update(state: Session): void {
      next = nextStep(state);
      show(element, next.kind !== "none");
      show(go, next.kind !== "none" && next.kind !== "save");
      show(save, next.kind === "save");
      setText(words, wording(next, state));
      go.classList.toggle("is-armed", next.kind === "place" && next.isArmed);
      go.setAttribute("aria-pressed", String(next.kind === "place" && next.isArmed));
      if (next.kind === "save" && state.fit) save.href = state.fit.links.fitted_glb;
      const count = pickCount(state);
      show(other, (next.kind === "place" || next.kind === "confirm") && state.step === "landmarks" && count > 0);
      setText(otherWords, state.fit ? text.fit.again(count) : text.fit.with(count));
    },
  };
}
