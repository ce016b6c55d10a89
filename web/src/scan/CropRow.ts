// Step 1: parts of the scan that are cut away by hand, and brought back: all, the last one, or any of them.
import { button, iconButton } from "../ui/controls";
import { el, fill, setText, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { ScanActions } from "./actions";
import { cropsOf } from "./crop";
import type { ScanSlice } from "./state";
import * as text from "./text";

const words = text.crop;

export function createCropRow(actions: ScanActions): Panel<Pick<ScanSlice, "scan" | "isCropping">> {
  let isCropping = false;
  const lasso = button(words.lasso, () => actions.takeLasso(!isCropping), "quiet outlined", "lasso");
  lasso.id = "lasso";
  const undo = iconButton("undo", words.undo, () => actions.undoCrop());
  const redo = iconButton("redo", words.redo, () => actions.redoCrop());
  const all = button(words.all, () => actions.uncrop(), "quiet");
  const parts = el("div", { class: "buttons cut-parts" });
  const note = el("p", { class: "muted small" });
  const element = el("div", { class: "panel" }, el("p", { class: "label" }, words.label), el("div", { class: "toolbar crop-row" }, lasso, undo, redo, all), parts, note);
  return {
    element,
    select: ({ scan, isCropping }) => ({ scan, isCropping }),
    update(state): void {
      isCropping = state.isCropping;
      lasso.setAttribute("aria-pressed", String(isCropping));
      const crops = state.scan?.crops;
      undo.disabled = !crops || crops.past.length === 0;
      redo.disabled = !crops || crops.future.length === 0;
      const count = cropsOf(state.scan).length;
      show(all, count > 0);
      show(parts, count > 1);
      fill(parts, count, () => Array.from({ length: count }, (_, which) => button(words.part(which + 1), () => actions.bringBack(which), "quiet outlined")));
      setText(note, isCropping ? words.how : words.note(count));
    },
  };
}
