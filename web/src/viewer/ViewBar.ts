// The bar on the stage: the tools, from which side the body is seen, and what of scan and model is shown.
import { el, show } from "../ui/dom";
import { createMenu, menuItem } from "../ui/menu";
import type { Panel } from "../ui/Panel";
import type { ViewActions } from "./actions";
import { type Look, LOOKS, type Overlay, OVERLAYS, type ViewName } from "./state";
import * as text from "./text";

export interface ViewBarShown {
  readonly isShown: boolean;
  readonly view: ViewName;
  readonly overlay: Overlay;
  /** there is a scan and a model to choose between */
  readonly hasOverlays: boolean;
  /** what is shown where there is no choice */
  readonly only: "scan" | "model";
  /** what can be switched now, and whether it is on */
  readonly looks: Readonly<Partial<Record<Look, boolean>>>;
}

export type LookActions = Readonly<Partial<Record<Look, (isOn: boolean) => void>>>;

/** `tools`: stand before the rest; `select` says what of the page's state it shows. */
export function createViewBar<State extends object>(view: ViewActions, actions: LookActions, select: (state: State) => ViewBarShown, tools: HTMLElement | null = null): Panel<ViewBarShown, State> {
  const names = Object.keys(text.view.names) as ViewName[];
  const from = createMenu("view-menu", "", text.view.label, "quiet opens", ...names.map((name) => menuItem(text.view.names[name], text.view.hints[name], () => view.from(name))));
  from.card.addEventListener("click", () => from.close());
  const overlays = OVERLAYS.map((overlay) => {
    const item = menuItem(text.view.overlays[overlay], text.view.overlayHints[overlay], () => view.overlay(overlay));
    item.dataset.value = overlay;
    return { overlay, item };
  });
  const looks = LOOKS.map((look) => {
    const item = menuItem(text.view.looks[look], text.view.lookHints[look], () => actions[look]?.(item.getAttribute("aria-pressed") !== "true"));
    item.id = look;
    return { look, item };
  });
  const line = el("hr");
  const seen = createMenu("look-menu", "", text.view.overlayLabel, "quiet opens", ...overlays.map(({ item }) => item), line, ...looks.map(({ item }) => item));
  const element = el("div", { class: "view-bar", role: "toolbar", "aria-label": text.view.bar, hidden: true }, tools, from.element, seen.element);
  return {
    element,
    select,
    update(shown: ViewBarShown): void {
      show(element, shown.isShown);
      from.set(text.view.names[shown.view]);
      seen.set(shown.hasOverlays ? text.view.overlays[shown.overlay] : text.view.alone[shown.only]);
      for (const { overlay, item } of overlays) {
        show(item, shown.hasOverlays);
        item.setAttribute("aria-pressed", String(overlay === shown.overlay));
      }
      for (const { look, item } of looks) {
        show(item, shown.looks[look] !== undefined && actions[look] !== undefined);
        item.setAttribute("aria-pressed", String(shown.looks[look] ?? false));
      }
      show(line, shown.hasOverlays && Object.keys(shown.looks).length > 0);
      show(seen.element, shown.hasOverlays || Object.keys(shown.looks).length > 0);
    },
  };
}
