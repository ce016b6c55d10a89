// The page's own matters: what is open, from where the body is seen, light or dark.
import { OVERLAYS, type Overlay, type Session, type Step, type Theme, type ViewName } from "./session";
import type { Store } from "../store/store";

const THEMES: Theme[] = ["system", "light", "dark"];
const after = <Item>(items: readonly Item[], item: Item): Item => items[(items.indexOf(item) + 1) % items.length] ?? item;

export function pageActions(store: Store<Session>, onLandmarks: () => void) {
  return {
    goTo(step: Step): void {
      store.set((state) => ({ step, active: step === "landmarks" ? state.active : null, drawn: step === "drawing" ? state.drawn : { ...state.drawn, tool: "none", start: null, open: null } }));
      if (step === "landmarks") onLandmarks();
    },
    view: (name: ViewName): void => store.set((state) => ({ view: { name, asked: state.view.asked + 1 } })),
    overlay: (overlay: Overlay): void => store.set({ overlay }),
    nextOverlay: (): void => store.set((state) => (state.fit ? { overlay: after(OVERLAYS, state.overlay) } : {})),
    swipe: (swipe: number): void => store.set({ swipe }),
    /** The coloured surface alone: over the scan the two would fight for each pixel. */
    showDistances: (showDistances: boolean): void =>
      store.set((state) => ({
        showDistances,
        look: showDistances ? null : state.look, // distances belong to the fit as it is
        overlay: showDistances && (state.overlay === "both" || state.overlay === "scan") ? "model" : state.overlay,
      })),
    nextTheme: (): void => store.set((state) => ({ theme: after(THEMES, state.theme) })),
    announce: (announcement: string): void => store.set({ announcement }),
    help: (isHelpOpen: boolean): void => store.set({ isHelpOpen }),
    graphics: (graphics: Session["graphics"]): void => store.set({ graphics }),
  };
}
