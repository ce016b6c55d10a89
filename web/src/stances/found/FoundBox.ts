// Below the marks: what is found by colour on both scans, to be accepted or dismissed, one or all.
import type { ProposedMark } from "../../api/types";
import { only } from "../../store/store";
import { button, iconButton } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { Workspace, StancesSlice } from "../state";
import type { FoundActions } from "./actions";
import { foundOn, type FoundSlice, pairOf } from "./state";
import { found as words } from "./text";

type Shown = Pick<Workspace & StancesSlice & FoundSlice, "scan" | "fit" | "stances" | "found">;

export function createFoundBox(actions: FoundActions): Panel<Shown> {
  let names: readonly string[] = [];
  const says = el("p", { class: "muted small", role: "status" });
  const find = button(words.find, () => void actions.look(), "quiet outlined");
  find.id = "find-marks";
  const list = el("ul", { class: "layers" });
  const all = button("", () => actions.accept(names), "quiet outlined", "check");
  const none = button(words.dismissAll, () => actions.dismiss(names), "quiet outlined");
  const element = el("section", { class: "panel", "aria-label": words.title, hidden: true }, el("h3", {}, words.title), says, find, list, el("div", { class: "buttons" }, all, none));

  const row = ({ name, kind, off_mm }: ProposedMark): HTMLElement =>
    el("li", { "data-found": name }, el("span", {}, words.row(name, kind, off_mm)), iconButton("check", words.accept(name), () => actions.accept([name])), iconButton("close", words.dismiss(name), () => actions.dismiss([name])));

  return {
    element,
    select: only("scan", "fit", "stances", "found"),
    update(state: Shown): void {
      const pair = pairOf(state);
      const found = foundOn(state.found, pair?.scans);
      const marks = found?.state === "found" ? found.marks : [];
      names = marks.map(({ name }) => name);
      show(element, pair !== null);
      setText(says, pair?.haveColours === false ? words.noColours : found?.state === "looking" ? words.looking : found?.state === "failed" ? found.reason : found?.state === "found" ? found.says : words.hint);
      show(find, pair?.haveColours === true);
      find.disabled = found?.state === "looking";
      fill(list, marks, () => marks.map(row));
      for (const each of [list, all, none]) show(each, names.length > 0);
      setText(all.querySelector("span:last-child")!, words.acceptAll(names.length));
    },
  };
}
