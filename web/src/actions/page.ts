// The page's own matters: what is open, from where the body is seen, light or dark.
import type { Overlay, Session, Step, Theme, ViewName } from "../state/session";
import type { Store } from "../state/store";

const OVERLAYS: Overlay[] = ["scan", "both", "model"];
const THEMES: Theme[] = ["system", "light", "dark"];
const after = <Item>(items: Item[], item: Item): Item => items[(items.indexOf(item) + 1) % items.length] ?? item;

export function pageActions(store: Store<Session>, onLandmarks: () => void) {
  return {
    goTo(step: Step): void {
      store.set((state) => ({ step, active: step === "landmarks" ? state.active : null }));
      if (step === "landmarks") onLandmarks();
    },
    view: (name: ViewName): void => store.set((state) => ({ view: { name, asked: state.view.asked + 1 } })),
    overlay: (overlay: Overlay): void => store.set({ overlay }),
    nextOverlay: (): void => store.set((state) => (state.fit ? { overlay: after(OVERLAYS, state.overlay) } : {})),
    nextTheme: (): void => store.set((state) => ({ theme: after(THEMES, state.theme) })),
    help: (isHelpOpen: boolean): void => store.set({ isHelpOpen }),
    graphics: (graphics: Session["graphics"]): void => store.set({ graphics }),
  };
}
