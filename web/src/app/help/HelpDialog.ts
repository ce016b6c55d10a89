// The keyboard and the mouse, on one card.
import { only } from "../../store/store";
import { iconButton } from "../../ui/controls";
import { el } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import { close as closeText, noticeLong } from "../../ui/text";
import type { Actions } from "../actions";
import type { Session } from "../session";
import { help as text } from "./helpText";

const table = (rows: readonly (readonly string[])[]): HTMLElement =>
  el("dl", { class: "keys" }, ...rows.map(([key = "", what = ""]) => el("div", {}, el("dt", {}, el("kbd", {}, key)), el("dd", {}, what))));

type Shown = Pick<Session, "isHelpOpen">;

export function createHelpDialog(actions: Actions): Panel<Shown> {
  const close = (): void => actions.page.help(false);
  const element = el(
    "dialog",
    { class: "help key-help", "aria-labelledby": "help-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "help-title" }, text.title), iconButton("close", closeText, close)),
    el("div", { class: "key-lists" }, table(text.keys), table(text.mouse)),
    el("p", { class: "muted small" }, noticeLong),
  );
  // Escape goes through the state like any other way out; the browser's own closing is known only later.
  element.addEventListener("cancel", (event) => {
    event.preventDefault();
    close();
  });
  element.addEventListener("click", (event) => {
    if (event.target === element) close();
  });
  return {
    element,
    select: only("isHelpOpen"),
    update(state: Shown): void {
      if (state.isHelpOpen && !element.open) element.showModal();
      if (!state.isHelpOpen && element.open) element.close();
    },
  };
}
