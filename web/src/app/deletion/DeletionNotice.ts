// After a scan was deleted, for ten seconds: the way to take it back.
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { DeletionActions } from "./actions";
import type { Session } from "../session";
import { deletion as words } from "../text";

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
