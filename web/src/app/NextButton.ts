// The one primary button: it says what to do next, and does it.
import { checks as checkText } from "../checks/text";
import { fit as fitText, result as resultText } from "../fit/text";
import { marks as marksText } from "../landmarks/marks/text";
import { isMark, markCalled } from "../landmarks/picks";
import { pickCount } from "../landmarks/state";
import { landmarks as landmarkText, proposals as proposalText } from "../landmarks/text";
import { inStance } from "../scan/text";
import { measuredFits } from "../stances/state";
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
    const label = entry ? landmarkText.spoken(entry) : isMark(next.landmark) ? marksText.spoken(markCalled(next.landmark)) : next.landmark;
    return next.isArmed ? text.next.armed(label) : text.next.start(label);
  }
  if (next.kind === "check") return `${checkText.begin(next.count, next.on ?? "")}\u2002${checkText.lasts(next.count)}`;
  if (next.kind === "confirm") return proposalText.confirmSeen(next.names.length);
  if (next.kind === "fit" && next.again) return fitText.again(next.landmarks);
  if (next.kind === "fit" && next.landmarks > 0) return fitText.with(next.landmarks);
  if (next.kind === "fit") return next.isProposed ? proposalText.fit : fitText.without;
  if (next.kind === "correct") return text.next.correct;
  if (next.kind === "ink") return text.next.ink(next.count, next.on);
  if (next.kind === "plan") return text.next.plan;
  if (next.kind === "print") return text.next.print;
  if (next.kind === "wait") return text.next.wait;
  if (next.kind === "draw") return next.isArmed ? text.next.drawing : text.next.draw;
  if (next.kind === "add") return text.next.add(inStance(next.stance));
  if (next.kind === "change over") return text.next.changeOver(next.to);
  return next.kind === "report" ? text.handover.print : "";
}

export function createNextButton(actions: Actions): Panel<NextShown> {
  let next: NextStep = { kind: "none" };
  const press = (): void => {
    const pressed = next; // what it does may change what comes next at once
    if (pressed.kind === "place") actions.landmarks.want(pressed.isArmed ? null : pressed.landmark);
    if (pressed.kind === "confirm") actions.landmarks.confirm(pressed.names);
    if (pressed.kind === "check") void (pressed.on === null ? Promise.resolve() : actions.stances.swap()).then(() => actions.checks.begin());
    if (pressed.kind === "fit") void actions.fit.start();
    if (pressed.kind === "correct") actions.page.goTo("points");
    if (pressed.kind === "plan") actions.page.goTo("plan");
    if (pressed.kind === "print") actions.page.goTo("handover");
    if (pressed.kind === "ink") {
      actions.page.goTo("plan");
      if (pressed.on !== null) void actions.stances.swap();
    }
    if (pressed.kind === "draw") actions.drawing.take(pressed.isArmed ? "none" : "pen");
    if (pressed.kind === "add") actions.stances.dialog(true);
    if (pressed.kind === "report") void import("./handover/Paper").then(({ printPages }) => printPages());
    if (pressed.kind === "change over") void actions.stances.swap();
  };
  const words = el("span", {});
  const go = el("button", { type: "button", class: "button primary", id: "next", onclick: press }, words);
  const report = el("a", { class: "button quiet wide", id: "report", download: "report.pdf" }, icon("download"), el("span", {}, resultText.report));
  const mayCheck = (): boolean => next.kind === "fit" && next.isProposed === true;
  const other = button("", () => (mayCheck() ? actions.landmarks.wantNext() : void actions.fit.start()), "quiet wide");
  const otherWords = other.querySelector("span")!;
  const element = el("div", { class: "next" }, go, report, other);
  return {
    element,
    select: only("asked", "meta", "step", "loading", "scan", "confirmed", "picks", "certain", "proposals", "skipped", "active", "fit", "isStarting", "stance", "preset", "refine", "drawing", "drawn", "ink", "stances", "checks"),
    update(state: NextShown): void {
      next = nextStep(state);
      show(element, next.kind !== "none");
      // The report of a fit that holds stays at hand while something else comes first.
      const isFirst = next.kind === "report";
      const isSecond = ["ink", "draw", "add", "change over", "check", "correct"].includes(next.kind) && state.step !== "body" && state.fit?.state === "done";
      show(go, next.kind !== "none");
      show(report, isFirst || isSecond);
      const fits = isFirst || isSecond ? measuredFits(state) : null;
      if (fits) report.href = fits[0].links.report + (fits[1] ? `?with=${encodeURIComponent(fits[1].id)}` : "");
      setText(words, wording(next, state));
      go.setAttribute("aria-disabled", String(next.kind === "wait"));
      const isArmed = (next.kind === "place" || next.kind === "draw") && next.isArmed;
      go.classList.toggle("is-armed", isArmed);
      go.setAttribute("aria-pressed", String(isArmed));
      const count = pickCount(state);
      show(other, mayCheck() || ((next.kind === "place" || next.kind === "confirm") && state.step === "points" && count > 0));
      setText(otherWords, mayCheck() ? proposalText.check : state.fit ? fitText.again(count) : fitText.with(count));
    },
  };
}
