// Step 1: parts of the scan that are cut away by hand, and brought back: all, the last one, or any of them.
import { button, iconButton } from "../../ui/controls";
import { el, fill, setText, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { ScanActions } from "../actions";
import { cropsOf } from "../crop";
import type { ScanSlice } from "../state";
import * as text from "../text";

const words = text.crop;

export function createCropRow(actions: ScanActions): Panel<Pick<ScanSlice, "scan" | "isCropping">> {
  let isCropping = false;
  let isMaking = false; // buttons that go are left by focus and pointer
  const lasso = button(words.lasso, () => actions.takeLasso(!isCropping), "quiet outlined", "lasso");
  lasso.id = "lasso";
  const undo = iconButton("undo", words.undo, () => actions.undoCrop());
  const redo = iconButton("redo", words.redo, () => actions.redoCrop());
  const all = button(words.all, () => actions.uncrop(), "quiet");
  const parts = el("div", { class: "buttons cut-parts" });
  function part(which: number): HTMLElement {
    const made = button(words.part(which + 1), () => bringBack(which), "quiet outlined");
    for (const kind of ["pointerenter", "focus"]) made.addEventListener(kind, () => actions.pointAtCut(which));
    for (const kind of ["pointerleave", "blur"]) made.addEventListener(kind, () => isMaking || actions.pointAtCut(null));
    return made;
  }
  function bringBack(which: number): void {
    actions.bringBack(which);
    const left = parts.children;
    (left.length > 0 ? (left[Math.min(which, left.length - 1)] as HTMLElement) : lasso).focus(); // whose button it was is gone
    actions.pointAtCut(null);
  }
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
      show(all, count > 1);
      show(parts, count > 0);
      isMaking = true;
      fill(parts, count, () => Array.from({ length: count }, (_, which) => part(which)));
      isMaking = false;
      setText(note, isCropping ? words.how : words.note(count));
    },
  };
}
