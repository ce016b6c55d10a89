// The marks below the landmarks: those on this scan, those of the other one that are missing here, and one more.
import type { PageSlice } from "../../store/page";
import { button, iconButton } from "../../ui/controls";
import { el, fill, icon, setText, show } from "../../ui/dom";
import type { LandmarkActions } from "../actions";
import { markCalled } from "../picks";
import type { LandmarksSlice } from "../state";
import { type AskedOfMarks, askedOfMarks, listedMarks, type MarksSlice } from "./marks";
import { marks as text } from "./text";

type Shown = Pick<PageSlice & LandmarksSlice & MarksSlice, "picks" | "active" | "beside"> & AskedOfMarks;

export function createMarkList(actions: LandmarkActions) {
  const rows = el("ol", { class: "mark-list" });
  const made = new Map<string, ReturnType<typeof makeRow>>();
  const add = button(text.add, () => actions.addMark(), "quiet outlined");
  const element = el("section", { class: "marks", "aria-label": text.title }, el("h3", {}, text.title), el("p", { class: "muted small" }, text.hint), rows, add);
  return {
    element,
    update(state: Shown): void {
      const names = listedMarks(state.picks.present, state.beside);
      fill(rows, names, () => {
        made.clear();
        for (const name of names) made.set(name, makeRow(name, actions));
        return [...made.values()].flatMap((row) => [row.element, row.question]);
      });
      const asked = askedOfMarks(state, state.picks.present);
      for (const [name, row] of made) row.update(state, asked.get(name) ?? null);
    },
  };
}

function makeRow(name: string, actions: LandmarkActions) {
  const called = markCalled(name);
  const status = el("span", { class: "visually-hidden" });
  const place = el("button", { type: "button", class: "landmark-name mark-place", onclick: () => actions.want(name) }, el("span", { class: "mark is-mark" }, el("span", {}, text.sign)), el("span", { class: "visually-hidden" }, called), status);
  const field = el("input", { class: "mark-name", type: "text", value: called, maxlength: "64", "aria-label": text.nameOf(called) });
  field.addEventListener("change", () => {
    if (!actions.renameMark(name, field.value.trim())) field.value = called;
  });
  const remove = iconButton("close", text.remove(called), () => actions.remove(name));
  remove.classList.add("remove");
  const element = el("li", { class: "landmark", "data-mark": called }, place, field, icon("check"), remove);
  const sentence = el("p", {});
  const question = el("li", { class: "question", hidden: true }, el("div", { class: "question-words" }, icon("alert"), sentence), el("div", { class: "buttons" }, button(text.takeOut, () => actions.remove(name), "quiet outlined")));
  return {
    element,
    question,
    update({ picks, active, beside }: Shown, asked: string | null): void {
      show(question, asked !== null);
      setText(sentence, asked ?? "");
      element.classList.toggle("is-asked", asked !== null);
      const isPlaced = name in picks.present;
      element.classList.toggle("is-placed", isPlaced);
      element.classList.toggle("is-active", active === name);
      place.setAttribute("aria-pressed", String(active === name));
      place.title = isPlaced ? text.again : text.missing;
      setText(status, isPlaced ? text.placed(name in beside) : text.missing);
      field.readOnly = !isPlaced || name in beside; // a name that both scans have is what makes them one place
      show(remove, isPlaced);
    },
  };
}
