// The keyboard and the mouse, on one card.
import type { Actions } from "./actions";
import { el } from "../ui/dom";
import type { Session } from "./session";
import { text } from "../ui/text";
import { iconButton } from "../ui/controls";
import type { Panel } from "../ui/Panel";

const table = (rows: readonly (readonly string[])[]): HTMLElement =>
  el("dl", { class: "keys" }, ...rows.map(([key = "", what = ""]) => el("div", {}, el("dt", {}, el("kbd", {}, key)), el("dd", {}, what))));

export function createHelpDialog(actions: Actions): Panel {
  const close = (): void => actions.page.help(false);
  const element = el(
    "dialog",
    { class: "help key-help", "aria-labelledby": "help-title", onclose: close },
    el("div", { class: "dialog-head" }, el("h2", { id: "help-title" }, text.help.title), iconButton("close", text.close, close)),
    el("div", { class: "key-lists" }, table(text.help.keys), table(text.help.mouse)),
    el("p", { class: "muted small" }, text.noticeLong),
  );
  // Escape goes through the state like any other way out; the browser's own closing would tell of it only later.
  element.addEventListener("cancel", (event) => (event.preventDefault(), close()));
  element.addEventListener("click", (event) => {
    if (event.target === element) close();
  });
  return {
    element,
    update(state: Session): void {
      if (state.isHelpOpen && !element.open) element.showModal();
      if (!state.isHelpOpen && element.open) element.close();
    },
  };
}
