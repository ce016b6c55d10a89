// From which side the body is seen, and what of scan and model is shown.
import type { Store } from "../store/store";
import type { Overlay, ViewName, ViewSlice } from "./state";

export function viewActions(store: Store<ViewSlice>) {
  return {
    from: (name: ViewName): void => store.set((state) => ({ view: { name, asked: state.view.asked + 1 } })),
    overlay: (overlay: Overlay): void => store.set({ overlay }),
    graphics: (graphics: ViewSlice["graphics"]): void => store.set({ graphics }),
  };
}

export type ViewActions = ReturnType<typeof viewActions>;
