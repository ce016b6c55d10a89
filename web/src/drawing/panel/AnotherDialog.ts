// Asked where a drawing file names another patient.
import { only } from "../../store/store";
import { button } from "../../ui/controls";
import { el, setText } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { DrawingActions } from "../actions";
import type { DrawingSlice } from "../state";
import * as text from "../text";

/** A file that names another patient: asked before anything of it is taken. */
export function createAnotherDialog(drawing: DrawingActions): Panel<Pick<DrawingSlice, "drawn">> {
  const words = text.drawing.another;
  const says = el("p", {});
  const take = button("", () => drawing.takeAnother(), "outlined");
  const leave = button(words.leave, () => drawing.leaveAnother(), "primary");
  const element = el("dialog", { class: "help ask", id: "another-dialog", "aria-labelledby": "another-title", oncancel: () => drawing.leaveAnother() }, el("h2", { id: "another-title" }, words.title), says, el("div", { class: "toolbar" }, leave, take));
  return {
    element,
    select: only("drawn"),
    update({ drawn: { another } }: Pick<DrawingSlice, "drawn">): void {
      if (another) {
        setText(says, words.says(another.theirs, another.ours));
        setText(take, words.take(another.ours));
      }
      if (another && !element.open) element.showModal();
      if (!another && element.open) element.close();
    },
  };
}
