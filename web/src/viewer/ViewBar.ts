// Under the body: from which side it is seen, what of scan and model is shown, and whether distances colour it.
import type { Actions } from "../app/actions";
import { el, show } from "../ui/dom";
import { type Overlay, OVERLAYS, type Session, type ViewName } from "../app/session";
import { text } from "../ui/text";
import { segmented } from "../ui/controls";
import type { Panel } from "../ui/Panel";

export function createViewBar(actions: Pick<Actions, "page">): Panel {
  const names = Object.keys(text.view.names) as ViewName[];
  const views = segmented<ViewName>(
    text.view.label,
    names.map((value) => ({ value, label: text.view.names[value], hint: text.view.hints[value] })),
    actions.page.view,
  );
  const overlays = segmented<Overlay>(
    text.view.overlayLabel,
    OVERLAYS.map((value) => ({ value, label: text.view.overlays[value], hint: text.view.overlayHints[value] })),
    actions.page.overlay,
  );
  for (const each of views.element.querySelectorAll("button")) each.removeAttribute("aria-pressed");
  let isOn = false;
  const distances = el("button", { type: "button", title: text.distances.hint, id: "distances", onclick: () => actions.page.showDistances(!isOn) }, text.distances.toggle);
  const toggle = el("div", { class: "segmented" }, distances);
  const element = el("div", { class: "view-bar", hidden: true }, el("div", { class: "view-buttons" }, views.element, overlays.element, toggle));
  return {
    element,
    update(state: Session): void {
      show(element, state.scan !== null && state.loading === null);
      show(overlays.element, state.fit !== null && state.scan?.mesh !== null);
      overlays.set(state.overlay);
      show(toggle, state.fit?.distances != null);
      isOn = state.showDistances;
      distances.setAttribute("aria-pressed", String(isOn));
    },
  };
}
