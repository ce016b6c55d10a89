// The left side: the steps, of which one is open, and below them the button that says what to do next.
import type { Result } from "../api/types";
import { drawing as drawingText } from "../drawing/text";
import { fit as fitText, numbers as resultNumbers, result as resultText } from "../fit/text";
import { outdated } from "../fit/outdated";
import { levelOf, linesOn, marginOf } from "../fit/verdict";
import { askedNames, openQuestions } from "../landmarks/questions/questions";
import { pickCount } from "../landmarks/state";
import { landmarks as landmarkText, questions } from "../landmarks/text";
import { scan as scanText } from "../scan/text";
import type { Step } from "../store/page";
import { only } from "../store/store";
import { el, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { formatCount, formatMm } from "../ui/units";
import type { Actions } from "./actions";
import type { Session } from "./session";
import * as text from "./text";

const BEFORE: Record<Step, string> = { scan: scanText.before, landmarks: landmarkText.before, fit: fitText.before, drawing: drawingText.before, result: resultText.before };
const ORDER: Step[] = ["scan", "landmarks", "fit", "drawing", "result"];

function summary(step: Step, state: StepsShown): string {
  if (!state.scan) return "";
  if (step === "scan") return scanText.summary(formatCount(state.scan.info.triangles));
  const count = step === "landmarks" ? askedNames(openQuestions(state)).size : 0;
  if (count > 0) return questions.toCheck(count);
  if (step === "landmarks") return landmarkText.progress(pickCount(state), state.meta?.landmarks.length ?? 0);
  if (step === "drawing") return drawingText.summary(state.drawn.lines.present.length);
  if (step === "fit" && isDoubtful(state)) return outdated(state) === null ? resultNumbers.short[levelOf(state.fit?.result)] : resultNumbers.old;
  if (step === "fit") return state.fit?.result ? fitSummary(state, state.fit.result) : "";
  return "";
}

/** How far off a line may be, as the result's headline says it; where that is not known, the mean distance to the skin. */
function fitSummary(state: StepsShown, { surface_distance_mm: { mean } }: Result): string {
  const lines = linesOn(state);
  return lines === null ? fitText.summary(formatMm(mean)) : marginOf(lines.mm);
}

function isDone(step: Step, state: StepsShown): boolean {
  if (step === "scan") return state.scan !== null;
  if (step === "landmarks") return pickCount(state) > 0 && pickCount(state) === state.meta?.landmarks.length;
  if (step === "drawing") return state.drawn.lines.present.length > 0;
  return state.fit?.state === "done";
}

/** No tick stands above a fit that is to be checked, nor above one that is not what is asked for any more. */
const isDoubtful = (state: StepsShown): boolean => state.fit?.state !== "running" && (levelOf(state.fit?.result) !== "good" || outdated(state) !== null);

type StepsShown = Pick<Session, "meta" | "step" | "scan" | "picks" | "certain" | "drawn" | "fit" | "stance" | "preset" | "refine">;

/** `bodies`: what each step has inside; `next`: the button below them all.  They follow the state by themselves. */
export function createSteps(actions: Actions, bodies: Record<Step, HTMLElement>, next: HTMLElement): Panel<StepsShown> {
  const sections = ORDER.map((step, i) => {
    const badge = el("span", { class: "badge", "aria-hidden": "true" });
    const note = el("span", { class: "summary" });
    const head = el(
      "button",
      { type: "button", class: "step-head", "aria-controls": `step-${step}`, onclick: () => actions.page.goTo(step) },
      badge,
      el("span", { class: "step-name" }, text.page.steps[step]),
      " ",
      note,
    );
    const before = el("p", { class: "muted before" }, BEFORE[step]);
    const body = el("div", { class: "step-body", id: `step-${step}` }, before, bodies[step]);
    const element = el("section", { class: "step" }, el("h2", {}, head), body);
    return { step, number: i + 1, element, head, badge, note, before, body };
  });
  const list = el("div", { class: "steps-scroll" }, ...sections.map((section) => section.element));
  list.addEventListener("toggle", ({ target }) => target instanceof HTMLDetailsElement && target.open && target.scrollIntoView({ block: "nearest" }), { capture: true }); // it does not bubble
  let opened = "";
  const element = el("nav", { class: "steps", "aria-label": text.page.stepsLabel }, list, next);
  return {
    element,
    select: only("meta", "step", "scan", "picks", "certain", "drawn", "fit", "stance", "preset", "refine"),
    update(state: StepsShown): void {
      for (const { step, number, element: section, head, badge, note, before, body } of sections) {
        const isOpen = state.scan !== null && state.step === step;
        const isNew = isOpen && opened !== `${state.scan.info.id} ${step}`;
        const done = isDone(step, state);
        section.classList.toggle("is-open", isOpen);
        head.setAttribute("aria-expanded", String(isOpen));
        head.disabled = state.scan === null;
        setText(note, summary(step, state));
        const isAsked = step === "landmarks" && state.scan !== null && openQuestions(state).length > 0;
        badge.classList.toggle("is-done", done);
        const isToCheck = (step === "fit" || step === "result") && isDoubtful(state);
        section.classList.toggle("is-asked", isAsked);
        section.classList.toggle("is-doubtful", isToCheck);
        const sign = isAsked || isToCheck ? "alert" : done ? "check" : "number";
        if (badge.dataset.sign !== sign) {
          badge.dataset.sign = sign;
          badge.replaceChildren(sign === "number" ? String(number) : icon(sign));
        }
        const hasContent = state.scan !== null && (step !== "result" || state.fit !== null);
        show(before, !hasContent);
        show(body, isOpen || state.scan === null);
        show(bodies[step], hasContent);
        if (!isNew) continue;
        opened = `${state.scan.info.id} ${step}`;
        list.scrollTop = 0; // the step's head and what it asks first, not where another one was left
      }
    },
  };
}
