// The page's own matters: which step is open, light or dark, help.
import { handsOff } from "../drawing/state";
import type { Step, Theme } from "../store/page";
import type { Store } from "../store/store";
import { OVERLAYS } from "../viewer/state";
import type { Session } from "./session";

const THEMES: Theme[] = ["system", "light", "dark"];
const after = <Item>(items: readonly Item[], item: Item): Item => items[(items.indexOf(item) + 1) % items.length] ?? item;

export function pageActions(store: Store<Session>, onLandmarks: () => void) {
  let gone = 0;
  return {
    /** How often somebody went to a step. */
    gone: (): number => gone,
    goTo(step: Step): void {
      gone += 1;
      store.set((state) => ({ step, active: step === "points" ? state.active : null, drawn: step === "plan" ? state.drawn : handsOff(state.drawn) }));
      if (step === "points") onLandmarks();
    },
    nextOverlay: (): void => store.set((state) => (state.fit ? { overlay: after(OVERLAYS, state.overlay) } : {})),
    nextTheme: (): void => store.set((state) => ({ theme: after(THEMES, state.theme) })),
    help: (isHelpOpen: boolean): void => store.set({ isHelpOpen }),
  };
}
