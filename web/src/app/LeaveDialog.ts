// Asks before unsaved work gives way to another patient.
import { only } from "../store/store";
import { button } from "../ui/controls";
import { el, setText } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { LeavingActions } from "./leaving";
import type { Session } from "./session";
import * as text from "./text";

const words = text.leaving;

type Shown = Pick<Session, "leaving">;

export function createLeaveDialog(actions: LeavingActions): Panel<Shown> {
  const lost = el("p", {});
  const element = el(
    "dialog",
    { class: "help ask", id: "leave-dialog", "aria-labelledby": "leave-title" },
    el("h2", { id: "leave-title" }, words.title),
    lost,
    el(
      "div",
      { class: "answers" },
      button(words.again, () => void actions.saveAgain(), "primary"),
      button(words.stay, actions.stay, "quiet outlined"),
      button(words.anyhow, () => actions.leaveAnyhow(), "quiet outlined danger"),
    ),
  );
  element.addEventListener("cancel", (event) => {
    event.preventDefault();
    actions.stay();
  });
  return {
    element,
    select: only("leaving"),
    update({ leaving }: Shown): void {
      if (leaving) setText(lost, words.lost(leaving.map((each) => words.what[each])));
      if (leaving && !element.open) element.showModal();
      if (!leaving && element.open) element.close();
    },
  };
}
