// A question about picks where they are listed: the sentence and the answers.  Amber with a sign, never by colour alone.
import type { LandmarkDefinition } from "../../api/types";
import { button } from "../../ui/controls";
import { el, fill, icon, setText, show } from "../../ui/dom";
import type { LandmarkActions } from "../actions";
import { type Question, sentenceOf } from "./questions";
import * as text from "../text";

const words = text.questions;

/** `answered`: where the focus goes when the question has gone. */
export function createQuestionBox<Tag extends "li" | "div">(tag: Tag, actions: LandmarkActions, answered: () => void) {
  const sentence = el("p", {});
  const answers = el("div", { class: "buttons" });
  const element = el(tag, { class: "question", tabindex: -1, hidden: true }, el("div", { class: "question-words" }, icon("alert"), sentence), answers);

  const answer = (label: string, about: string, look: string, act: () => void): HTMLButtonElement => {
    const made = button(label, () => {
      act();
      answered();
    }, look);
    made.setAttribute("aria-label", `${label}: ${about}`);
    return made;
  };

  function answersTo({ names, exchange }: Question, about: string): HTMLElement[] {
    const keep = (label: string, look: string): HTMLElement => answer(label, about, look, () => actions.keep(names));
    if (exchange === null) {
      return [keep(words.keep, "quiet outlined"), answer(words.takeOut, about, "quiet outlined", () => actions.takeOut(names[0]!))];
    }
    const label = exchange === "two" ? words.exchangeTwo : words.exchange;
    return [answer(label, about, "quiet outlined", () => actions.exchange(names)), keep(words.keepAll, "link")];
  }

  return {
    element,
    update(question: Question | null, list: readonly LandmarkDefinition[]): void {
      show(element, question !== null);
      if (!question) return;
      const labels = question.names.map((name) => list.find((each) => each.name === name)).flatMap((entry) => (entry ? [text.landmarks.spoken(entry)] : []));
      setText(sentence, sentenceOf(question, list));
      fill(answers, [question.names, question.exchange], () => answersTo(question, question.exchange === "all" ? words.allSides : labels.join(", ")));
    },
  };
}
