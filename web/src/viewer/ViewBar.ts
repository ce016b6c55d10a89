// Under the body: from which side it is seen, what of scan and model is shown, and whether distances colour it.
import { segmented } from "../ui/controls";
import { el, icon, show } from "../ui/dom";
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
  /** the scan has more than the patient */
  readonly hasLoose: boolean;
  readonly showLoose: boolean;
  /** the scan has nothing but its shape */
  readonly hasRelief: boolean;
  readonly showRelief: boolean;
  /** two breasts can be compared */
  readonly hasMirror: boolean;
  readonly showMirror: boolean;
}

export interface ViewBarActions {
  readonly showDistances: (isOn: boolean) => void;
  readonly showLoose: (isOn: boolean) => void;
  readonly showRelief: (isOn: boolean) => void;
  readonly showMirror: (isOn: boolean) => void;
}

/** `select` says what of the page's state it shows. */
export function createViewBar<State extends object>(view: ViewActions, actions: ViewBarActions, select: (state: State) => ViewBarShown): Panel<ViewBarShown, State> {
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
  const distances = toggle("distances", text.view.distances, text.view.distancesHint, actions.showDistances);
  const loose = toggle("loose", icon("table"), text.view.looseHint, actions.showLoose, text.view.loose); // a picture: with all buttons the words would need a second row
  const relief = toggle("relief", icon("relief"), text.view.reliefHint, actions.showRelief, text.view.relief);
  const mirror = toggle("mirror", icon("mirror"), text.view.mirrorHint, actions.showMirror, text.view.mirror);
  const element = el("div", { class: "view-bar", hidden: true }, el("div", { class: "view-buttons" }, views.element, overlays.element, distances.element, mirror.element, relief.element, loose.element));
  return {
    element,
    select,
    update(shown: ViewBarShown): void {
      show(element, shown.isShown);
      show(overlays.element, shown.hasOverlays);
      overlays.set(shown.overlay);
      distances.set(shown.hasDistances, shown.showDistances);
      mirror.set(shown.hasMirror, shown.showMirror);
      relief.set(shown.hasRelief, shown.showRelief);
      loose.set(shown.hasLoose, shown.showLoose);
    },
  };
}

function toggle(id: string, label: string | SVGElement, hint: string, turn: (isOn: boolean) => void, name: string | null = null) {
  let isOn = false;
  const button = el("button", { type: "button", title: hint, "aria-label": name, id, onclick: () => turn(!isOn) }, label);
  const element = el("div", { class: "segmented" }, button);
  return {
    element,
    set(isThere: boolean, isNowOn: boolean): void {
      show(element, isThere);
      isOn = isNowOn;
      button.setAttribute("aria-pressed", String(isOn));
    },
  };
}
