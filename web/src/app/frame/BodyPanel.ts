// The tab Body: how sure the fit is and what is asked; folded away, everything else that is known of scan and fit.
import { button } from "../../ui/controls";
import { el } from "../../ui/dom";
import * as text from "../text";

/** `first` stands before the way to set points by hand, `details` are folded below it; each follows the state by itself. */
export function createBodyPanel(setPoints: () => void, first: readonly HTMLElement[], details: readonly HTMLElement[]): HTMLElement {
  const points = button(text.page.setPoints, setPoints, "outlined wide", "points");
  points.id = "set-points";
  return el("div", { class: "panel" }, ...first, points, el("details", { class: "details", id: "details" }, el("summary", {}, text.page.details), el("div", { class: "panel" }, ...details)));
}
