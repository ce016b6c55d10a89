// What a file does not say about the patient and a person knows: which side is left.  Nothing is uploaded before the answer.
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, fill, setText } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { ScanActions } from "../actions";
import type { ScanSlice } from "../state";
import * as text from "../text";

const words = text.question;

type Shown = Pick<ScanSlice, "asked">;

export function createQuestionDialog(actions: Pick<ScanActions, "answer">): Panel<Shown> {
  const problem = el("p", {});
  const choices = el("div", { class: "frame-choices" });
  const cancel = (): void => actions.answer(null);
  const element = el(
    "dialog",
    { class: "help ask frame-question", id: "question-dialog", tabindex: -1, "aria-labelledby": "question-title", oncancel: (event) => {
      event.preventDefault();
      cancel();
    } },
    el("h2", { id: "question-title" }, words.title),
    problem,
    el("p", { class: "muted small" }, words.how),
    choices,
    el("div", { class: "answers stays" }, button(words.cancel, cancel, "quiet outlined")),
  );
  return {
    element,
    select: only("asked"),
    update({ asked }: Shown): void {
      if (asked) {
        setText(problem, `${asked.problem}.`);
        fill(choices, asked.choices, () =>
          asked.choices.map((choice) => {
            const picture = choice.picture ? el("img", { src: choice.picture, alt: "" }) : null;
            const sides = picture && el("span", { class: "sides small", "aria-hidden": "true" }, el("span", {}, words.right), el("span", {}, words.left));
            return el("button", { type: "button", class: "button outlined", "data-value": choice.value, onclick: () => actions.answer(choice.value) }, picture, sides, el("span", {}, choice.text));
          }),
        );
      }
      if (asked && !element.open) {
        element.showModal();
        element.focus(); // not its first button: a stray Enter would be an answer
      }
      if (!asked && element.open) element.close();
    },
  };
}
