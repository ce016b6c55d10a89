// The one primary button: it says what to do next, and does it.
import { fit as fitText, result as resultText } from "../fit/text";
import { pickCount } from "../landmarks/state";
import { landmarks as landmarkText, proposals as proposalText, questions } from "../landmarks/text";
import { scan as scanText } from "../scan/text";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, icon, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { Actions } from "./actions";
import { type NextShown, type NextStep, nextStep } from "./nextStep";
import * as text from "./text";

function wording(next: NextStep, state: NextShown): string {
  if (next.kind === "place") {
    const entry = state.meta?.landmarks.find((each) => each.name === next.landmark);
    const label = entry ? landmarkText.spoken(entry) : next.landmark;
    return next.isArmed ? text.next.armed(label) : text.next.start(label);
  }
  if (next.kind === "check") return questions.check(next.count);
  if (next.kind === "confirm scan") return scanText.confirm;
  if (next.kind === "confirm") return proposalText.confirmLikely(next.names.length);
  if (next.kind === "fit" && next.again) return fitText.again(next.landmarks);
  if (next.kind === "fit") return next.landmarks > 0 ? fitText.with(next.landmarks) : fitText.without;
  return next.kind === "save" ? resultText.save : "";
}

export function createNextButton(actions: Actions): Panel<NextShown> {
  let next: NextStep = { kind: "none" };
  const press = (): void => {
    if (next.kind === "confirm scan") actions.scan.confirm();
    if (next.kind === "place") actions.landmarks.want(next.isArmed ? null : next.landmark);
    if (next.kind === "confirm") actions.landmarks.confirm(next.names);
    if (next.kind === "check") {
      actions.page.goTo("landmarks");
      document.querySelector<HTMLElement>("#step-landmarks .question:not([hidden])")?.focus(); // and into view; Enter answers nothing yet
    }
    if (next.kind === "fit") void actions.fit.start();
  };
  const words = el("span", {});
  const go = el("button", { type: "button", class: "button primary", id: "next", onclick: press }, words);
  const save = el("a", { class: "button primary", id: "save", download: "fitted.glb" }, icon("download"), el("span", {}, resultText.save));
  const other = button("", () => void actions.fit.start(), "quiet wide");
  const otherWords = other.querySelector("span")!;
  const element = el("div", { class: "next" }, go, save, other);
  return {
    element,
    select: only("meta", "step", "loading", "scan", "confirmed", "picks", "certain", "proposals", "skipped", "active", "fit", "isStarting", "stance", "drawn", "stances"),
    update(state: NextShown): void {
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
      setText(otherWords, state.fit ? fitText.again(count) : fitText.with(count));
    },
  };
}
