// The line between scan and model, and the names of the two halves.  A range input: keys and touch come with it.
import type { Actions } from "../app/actions";
import { el, show } from "../ui/dom";
import { isBeside, type Session } from "../app/session";
import { text } from "../ui/text";
import type { Panel } from "../ui/Panel";

export function createSwipe(actions: Pick<Actions, "page">): Panel {
  const slider = el("input", {
    type: "range",
    class: "swipe",
    min: 0,
    max: 1,
    step: 0.01,
    "aria-label": text.view.swipe,
    oninput: () => actions.page.swipe(Number(slider.value)),
  });
  const line = el("div", { class: "swipe-line" });
  const scan = el("span", { class: "pane-name" }, text.view.panes.scan);
  const model = el("span", { class: "pane-name is-model" }, text.view.panes.model);
  const element = el("div", { class: "halves", hidden: true }, line, scan, model, slider);
  return {
    element,
    update(state: Session): void {
      const { overlay } = state;
      show(element, state.scan !== null && state.fit !== null && isBeside(overlay));
      const share = overlay === "swipe" ? state.swipe : 0.5;
      show(slider, overlay === "swipe");
      slider.value = String(state.swipe);
      element.style.setProperty("--split", `${100 * share}%`);
    },
  };
}
