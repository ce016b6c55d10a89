// Under the body: from which side it is seen, what of scan and model is shown, and whether distances colour it.
import { segmented } from "../ui/controls";
import { el, show } from "../ui/dom";
import type { Panel } from "../ui/Panel";
import type { ViewActions } from "./actions";
import { type Overlay, OVERLAYS, type ViewName } from "./state";
import * as text from "./text";

export interface ViewBarShown {
  readonly isShown: boolean;
  /** there is something to choose between */
  readonly hasOverlays: boolean;
  readonly overlay: Overlay;
  readonly hasDistances: boolean;
  readonly showDistances: boolean;
}

/** `select` says what of the page's state it shows. */
export function createViewBar<State extends object>(view: ViewActions, showDistances: (isOn: boolean) => void, select: (state: State) => ViewBarShown): Panel<ViewBarShown, State> {
  const names = Object.keys(text.view.names) as ViewName[];
  const views = segmented<ViewName>(
    text.view.label,
    names.map((value) => ({ value, label: text.view.names[value], hint: text.view.hints[value] })),
    view.from,
  );
  const overlays = segmented<Overlay>(
    text.view.overlayLabel,
    OVERLAYS.map((value) => ({ value, label: text.view.overlays[value], hint: text.view.overlayHints[value] })),
    view.overlay,
  );
  for (const each of views.element.querySelectorAll("button")) each.removeAttribute("aria-pressed");
  let isOn = false;
  const distances = el("button", { type: "button", title: text.view.distancesHint, id: "distances", onclick: () => showDistances(!isOn) }, text.view.distances);
  const toggle = el("div", { class: "segmented" }, distances);
  const element = el("div", { class: "view-bar", hidden: true }, el("div", { class: "view-buttons" }, views.element, overlays.element, toggle));
  return {
    element,
    select,
    update(shown: ViewBarShown): void {
      show(element, shown.isShown);
      show(overlays.element, shown.hasOverlays);
      overlays.set(shown.overlay);
      show(toggle, shown.hasDistances);
      isOn = shown.showDistances;
      distances.setAttribute("aria-pressed", String(isOn));
    },
  };
}
