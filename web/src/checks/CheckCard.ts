// The card of the tour: how far it is, one question, what an answer brings, the answers.  Loaded when the first tour begins.
import "./checks.css";
import type { LandmarkDefinition } from "../api/types";
import { fingersMark, fingersOf, wideOf } from "../fit/fingers";
import { marginOf } from "../fit/verdict";
import { landmarks as landmarkText } from "../landmarks/text";
import { sentenceOf } from "../landmarks/questions/questions";
import { questions as questionText } from "../landmarks/text";
import { sideOf } from "../landmarks/picks";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { keys } from "../ui/text";
import type { CheckActions } from "./actions";
import { type ChecksSlice, type Tour, type TourStep } from "./state";
import * as text from "./text";

const words = text.checks;

type Shown = Pick<PageSlice, "meta"> & ChecksSlice;

const width = (mm: number | null, says: string): HTMLElement =>
  el("div", {}, fingersMark(fingersOf(mm)), el("strong", {}, wideOf(mm)), el("span", { class: "muted small" }, fingersOf(mm) === null ? says : `${says} ${marginOf(mm!)}`));

export function createCheckCard(actions: CheckActions): Panel<Shown> {
  const bars = el("div", { class: "check-bars", "aria-hidden": "true" });
  const progress = el("p", { class: "muted small" });
  const leave = button(words.leave, () => actions.leave(), "quiet small");
  leave.append(el("kbd", { "aria-hidden": "true" }, keys.escape));
  const title = el("h2", { id: "check-title" });
  const question = el("p", {});
  const gain = el("div", { class: "check-gain" });
  const why = el("p", { class: "muted small" });
  const next = el("p", { class: "muted small" });
  const answers = el("div", { class: "check-answers" });
  const element = el("section", { class: "check-card", "aria-labelledby": "check-title", hidden: true }, el("div", { class: "check-head" }, bars, progress, el("span", { class: "spring" }), leave), title, question, gain, why, el("span", { class: "spring" }), next, answers);

  function answersTo(step: TourStep | undefined): HTMLElement[] {
    if (step?.kind === "question") {
      const { names, exchange } = step.question;
      const keep = button(exchange === null ? questionText.keep : questionText.keepAll, () => actions.keep(names), exchange === null ? "primary" : "outlined");
      if (exchange === null) return [keep, button(questionText.takeOut, () => actions.takeOut(names[0]!), "outlined")];
      return [button(exchange === "two" ? questionText.exchangeTwo : questionText.exchange, () => actions.exchange(names), "primary"), keep];
    }
    if (step?.kind === "stance") return (["standing", "supine", "prone"] as const).map((stance) => button(words.stances[stance], () => actions.stance(stance), "outlined"));
    if (step?.kind !== "point") return [];
    const yes = button(words.yes, () => actions.yes(), "primary");
    yes.append(el("kbd", { "aria-hidden": "true" }, keys.enter));
    yes.id = "check-yes";
    const canvas = (): HTMLElement | null => document.querySelector("canvas.view");
    const move = button(words.move, () => canvas()?.focus(), "outlined");
    move.title = words.how;
    move.setAttribute("aria-description", words.how);
    return [yes, move, button(words.unseen, () => actions.unseen(), "outlined")];
  }

  const nameOf = (step: TourStep | undefined, list: readonly LandmarkDefinition[]): string => {
    if (step?.kind === "question") return step.question.names.map((name) => list.find((each) => each.name === name)).flatMap((entry) => (entry ? [landmarkText.spoken(entry)] : [])).join(", ");
    return step?.kind === "point" ? step.check.label : "";
  };

  function asked(tour: Tour, list: readonly LandmarkDefinition[]): string {
    const step = tour.steps[tour.at];
    if (step?.kind === "question") return sentenceOf(step.question, list);
    if (step?.kind === "stance") return words.stance;
    if (step?.kind !== "point") return words.fitting(Object.values(tour.answers).filter((at) => at !== null).length);
    const definition = list.find(({ name }) => name === step.check.name)?.definition ?? "";
    return `${definition} ${tour.moved ? words.askMoved : words.ask}`.trim();
  }

  return {
    element,
    select: only("meta", "checks"),
    update({ meta, checks: { tour } }: Shown): void {
      const wasShown = !element.hidden;
      show(element, tour !== null);
      if (!tour) {
        if (wasShown) document.getElementById("next")?.focus();
        return;
      }
      const list = meta?.landmarks ?? [];
      const step = tour.steps[tour.at];
      const count = tour.steps.length;
      const at = Math.min(tour.at + 1, count);
      fill(bars, [tour.at, count], () => tour.steps.map((_, i) => el("span", { class: i <= tour.at ? "is-done" : "" })));
      setText(progress, words.progress(at, count));
      const name = nameOf(step, list);
      setText(title, words.title(step?.kind === "stance" ? words.stance : name));
      title.className = step?.kind === "point" ? `side-${sideOf(step.check.name)}` : "";
      setText(question, step?.kind === "stance" ? "" : asked(tour, list));
      show(gain, step?.kind === "point");
      const before = step?.kind === "point" ? step.before : null;
      fill(gain, [tour.at, before], () => (step?.kind === "point" ? [width(before, words.now), el("span", { "aria-hidden": "true" }, "→"), width(step.check.line_error_mm, words.then)] : []));
      setText(why, step?.kind === "point" ? (tour.moved ? words.whyMoved : words.why) : "");
      const following = nameOf(tour.steps[tour.at + 1], list);
      setText(next, following === "" ? "" : words.next(following));
      const key = JSON.stringify([tour.fit, tour.at]);
      const isNew = answers.dataset.step !== key;
      answers.dataset.step = key;
      fill(answers, [tour.fit, tour.at], () => answersTo(step));
      if (isNew) (answers.querySelector<HTMLElement>("button.primary") ?? answers.querySelector<HTMLElement>("button"))?.focus({ preventScroll: true });
    },
  };
}
