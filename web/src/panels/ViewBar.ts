// Under the body: from which side it is seen, and what of scan and model is shown.
import type { Actions } from "../actions";
import { el, show } from "../dom";
import type { Overlay, Session, ViewName } from "../state/session";
import { text } from "../text";
import { segmented } from "./controls";
import type { Panel } from "./Panel";

export function createViewBar(actions: Actions): Panel {
  const names = Object.keys(text.view.names) as ViewName[];
  const views = segmented<ViewName>(
    text.view.label,
    names.map((value) => ({ value, label: text.view.names[value], hint: text.view.hints[value] })),
    actions.page.view,
  );
  const overlays = segmented<Overlay>(
    text.view.overlayLabel,
    (["scan", "both", "model"] as const).map((value) => ({ value, label: text.view.overlays[value] })),
    actions.page.overlay,
  );
  for (const each of views.element.querySelectorAll("button")) each.removeAttribute("aria-pressed");
  const element = el("div", { class: "view-bar", hidden: true }, views.element, overlays.element);
  return {
    element,
    update(state: Session): void {
      show(element, state.scan !== null && state.loading === null);
      show(overlays.element, state.fit !== null);
      overlays.set(state.overlay);
    },
  };
}
