// The card of the check with a question that has to be answered first.  No answer is the default: its title has the focus, so that a
// stray Enter says nothing.  Loaded with the first question.
import "./checks.css";
import "./doubts.css";
import type { UnitChoice } from "../api/types";
import type { DrawingActions } from "../drawing/actions";
import type { FitSlice } from "../fit/state";
import type { ScanActions } from "../scan/actions";
import { units as unitNames } from "../scan/text";
import type { StancesActions } from "../stances/actions";
import { nameOfSecond, secondOf } from "../stances/samePatient";
import type { PageSlice } from "../store/page";
import { only } from "../store/store";
import { ANY_FILE, button, fileButton, problem } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { formatCm, mmFrom, toUnit } from "../ui/units";
import { sizeIn } from "../viewer/frame";
import { type Doubt, type Doubtful, openDoubt } from "./doubts";
import * as text from "./doubtsText";

const UNITS = ["mm", "cm", "dm", "m", "in", "ft"] as const satisfies readonly UnitChoice[];

type Shown = Doubtful & Pick<PageSlice & FitSlice, "problems" | "stance">;

/** What the answers do. */
export interface DoubtActions {
  readonly scan: Pick<ScanActions, "answer">;
  readonly stances: Pick<StancesActions, "samePatient" | "leaveUnanswered" | "dismiss">;
  readonly drawing: Pick<DrawingActions, "takeAnother" | "leaveAnother">;
  readonly size: { readonly isRight: () => void; readonly is: (units: UnitChoice) => void; readonly anotherFile: (file: File) => void; readonly measure: () => void };
}

interface Asked {
  readonly title: string;
  readonly says: readonly string[];
  readonly answers: readonly HTMLElement[];
}

export function createDoubtCard(actions: DoubtActions): Panel<Shown> {
  const title = el("h2", { id: "doubt-title", tabindex: -1 });
  const says = el("div", { id: "doubt-says" });
  const wrong = problem(() => actions.stances.dismiss());
  const answers = el("div", { class: "check-answers" });
  const element = el("section", { class: "check-card doubt-card", "aria-labelledby": "doubt-title", "aria-describedby": "doubt-says", hidden: true }, title, says, wrong.element, el("span", { class: "spring" }), answers);
  let open: Doubt | null = null;

  addEventListener("keydown", ({ key }) => {
    if (key !== "Escape" || document.querySelector("dialog[open]")) return;
    if (open === "file") actions.scan.answer(null);
    if (open === "drawing") actions.drawing.leaveAnother();
  });

  const asks: Readonly<Record<Doubt, (state: Shown) => Asked>> = {
    file({ asked }) {
      const words = text.file[asked!.field as keyof typeof text.file];
      const isSided = asked!.field === "frame";
      const choices = asked!.choices.map(({ value, text: says, picture }) => {
        const sides = isSided ? [el("span", { class: "sides small", "aria-hidden": "true" }, el("span", {}, text.file.frame.right), el("span", {}, text.file.frame.left))] : [];
        return el("button", { type: "button", class: "button outlined", "data-value": value, onclick: () => actions.scan.answer(value) }, ...(picture ? [el("img", { src: picture, alt: "" }), ...sides] : []), el("span", {}, says));
      });
      return { title: words.title, says: [`${asked!.problem}.`, words.how], answers: [el("div", { class: "frame-choices" }, ...choices), button(words.cancel, () => actions.scan.answer(null), "outlined wide stays")] };
    },
    patient(state) {
      const words = text.patient;
      const [asked] = state.stances.asked;
      const code = state.scan?.info.patient_code ?? "";
      const another = button(words.another(nameOfSecond(state, secondOf(state, asked!))), () => void actions.stances.samePatient(false), "outlined wide");
      const unsure = button(words.unsure, () => actions.stances.leaveUnanswered(), "outlined wide");
      another.title = words.anotherHint;
      unsure.title = words.unsureHint;
      return { title: words.title, says: [words.says(asked!.says, code)], answers: [button(words.same(code), () => void actions.stances.samePatient(true), "outlined wide"), another, unsure] };
    },
    drawing({ drawn: { another } }) {
      const words = text.drawing;
      return { title: words.title, says: [words.says(another!.theirs, another!.ours)], answers: [button(words.leave, () => actions.drawing.leaveAnother(), "outlined wide"), button(words.take(another!.ours), () => actions.drawing.takeAnother(), "outlined wide")] };
    },
    size({ scan }) {
      const words = text.size;
      const { info, file, frame } = scan!;
      const tall = 1000 * sizeIn(frame, info.frame, info.size_m!)[1];
      const others = file === null ? [] : UNITS.filter((unit) => unit !== info.unit).map((unit) => button(words.as(unitNames[unit], formatCm(mmFrom(toUnit(tall, info.unit), unit) / 1000)), () => actions.size.is(unit), "outlined"));
      return { title: words.title, says: [info.size_doubt ?? "", ...(file === null ? [words.otherFile] : [])], answers: [button(words.right, () => actions.size.isRight(), "primary"), button(words.measure, () => actions.size.measure(), "outlined wide"), ...others, fileButton(words.anotherFile, ANY_FILE, "outlined wide", actions.size.anotherFile)] };
    },
  };

  return {
    element,
    select: only("asked", "scan", "confirmed", "drawn", "stances", "problems", "stance", "fit"),
    update(state: Shown): void {
      const wasShown = open !== null;
      open = openDoubt(state);
      show(element, open !== null);
      element.dataset.doubt = open ?? "";
      if (open === null) {
        if (wasShown) document.getElementById("next")?.focus();
        return;
      }
      const asked = asks[open](state);
      const key = [open, asked.title, asked.says, asked.answers.map(({ textContent }) => textContent)];
      setText(title, asked.title);
      fill(says, key, () => asked.says.map((sentence) => el("p", {}, sentence)));
      wrong.set(open === "patient" ? state.problems.stances : undefined);
      const isNew = answers.dataset.key !== JSON.stringify(key);
      fill(answers, key, () => [...asked.answers]);
      if (isNew) title.focus({ preventScroll: true });
    },
  };
}
