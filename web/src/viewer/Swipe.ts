// The line between scan and model, and the names of the two halves.  A range input: keys and touch come with it.
import { el, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import { isBeside, type ViewSlice } from "./state";
import * as text from "./text";

type Shown = Pick<ViewSlice, "overlay" | "swipe"> & { readonly hasBoth: boolean };

/** `hasBoth`: scan and model are there. */
export function createSwipe<More extends object>(moved: (share: number) => void, hasBoth: (state: More) => boolean): Panel<Shown, ViewSlice & More> {
  const slider = el("input", {
    type: "range",
    class: "swipe",
    min: 0,
    max: 1,
    step: 0.01,
    "aria-label": text.view.swipe,
    oninput: () => moved(Number(slider.value)),
  });
  const line = el("div", { class: "swipe-line" });
  const scan = el("span", { class: "pane-name" }, text.view.panes.scan);
  const model = el("span", { class: "pane-name is-model" }, text.view.panes.model);
  const element = el("div", { class: "halves", hidden: true }, line, scan, model, slider);
  return {
    element,
    select: (state) => ({ overlay: state.overlay, swipe: state.swipe, hasBoth: hasBoth(state) }),
    update({ overlay, swipe, hasBoth }: Shown): void {
      show(element, hasBoth && isBeside(overlay));
      const share = overlay === "swipe" ? swipe : 0.5;
      show(slider, overlay === "swipe");
      slider.value = String(swipe);
      element.style.setProperty("--split", `${100 * share}%`);
    },
  };
}
