// Lines found on the skin come to the page with the first coloured scan: this file and what it needs are loaded then.
import type { Client } from "../api/client";
import type { DrawingActions } from "../drawing/actions";
import type { DrawingSlice } from "../drawing/state";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { StancesActions } from "../stances/actions";
import type { StancesSlice } from "../stances/state";
import type { PageSlice } from "../store/page";
import { only, type Store } from "../store/store";
import { follow } from "../ui/Panel";
import { inkActions } from "./actions";
import { createInkPanel } from "./InkPanel";
import type { InkSlice } from "./state";

type State = PageSlice & ScanSlice & DrawingSlice & FitSlice & StancesSlice & InkSlice;

/** `places`: where the list stands, in the step that brings the scan and in the one that draws. */
export function openInk(
  store: Store<State>,
  client: Pick<Client, "ink" | "dropInk">,
  others: { readonly drawing: DrawingActions; readonly stances: StancesActions },
  places: { readonly scan: HTMLElement; readonly drawing: HTMLElement },
): void {
  const actions = inkActions(store, client, others.drawing);
  const panel = createInkPanel(actions, others.stances);
  follow(store, panel);
  store.select(only("step"), ({ step }) => (step === "plan" ? places.drawing : places.scan).append(panel.element));
  store.select(only("scan"), () => queueMicrotask(() => void actions.look())); // a listener may not set
}
