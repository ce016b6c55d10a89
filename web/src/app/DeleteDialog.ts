// Asks before a scan is deleted and says what goes with it; afterwards, for ten seconds, the way to take it back.
import { pickCount } from "../landmarks/state";
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { DeletionActions } from "./deletion";
import type { Session } from "./session";
import * as text from "./text";

const words = text.deletion;

type Shown = Pick<Session, "isAskingToDelete" | "scan" | "picks" | "drawn" | "fit" | "stances">;

export function createDeleteDialog(actions: DeletionActions): Panel<Shown> {
  const goes = el("p", {});
  const other = el("p", {}, words.other);
  const keep = (): void => actions.ask(false);
  const element = el(
    "dialog",
    { class: "help ask", id: "delete-dialog", "aria-labelledby": "delete-title" },
    el("h2", { id: "delete-title" }, words.title),
    goes,
    other,
    el("p", { class: "muted" }, words.noWay),
    el("div", { class: "answers" }, button(words.keep, keep, "quiet outlined"), button(words.confirm, () => void actions.confirm(), "primary danger")),
  );
  element.addEventListener("cancel", (event) => {
    event.preventDefault();
    keep();
  });
  return {
    element,
    select: only("isAskingToDelete", "scan", "picks", "drawn", "fit", "stances"),
    update(state: Shown): void {
      const isOpen = state.isAskingToDelete && state.scan !== null;
      if (isOpen) setText(goes, words.goes(pickCount(state), state.drawn.lines.present.length, state.fit !== null));
      show(other, state.stances.other !== null);
      if (isOpen && !element.open) element.showModal();
      if (!isOpen && element.open) element.close();
    },
  };
}

export function createDeletionNotice(actions: DeletionActions): Panel<Pick<Session, "deletion">> {
  const what = el("p", {});
  const element = el("div", { class: "notice-bar", hidden: true }, what, button(words.undo, () => void actions.undo(), "outlined"));
  return {
    element,
    select: only("deletion"),
    update({ deletion }): void {
      show(element, deletion !== null);
      if (deletion) setText(what, words.soon(deletion.title));
    },
  };
}
