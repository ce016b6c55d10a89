// Single keys for what is done most often; they stay out of the way of typing and of the browser's own shortcuts.
import { drawingKey } from "../drawing/keys";
import { cropKey } from "../scan/cropKeys";
import type { Step } from "../store/page";
import type { Store } from "../store/store";
import type { Actions } from "./actions";
import type { Session } from "./session";

const STEPS: Record<string, Step> = { "1": "body", "2": "points", "3": "plan", "4": "handover" };

function isTyping(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("input:not([type=range]):not([type=checkbox]), select, textarea, dialog") !== null;
}

export function listenToKeys(store: Store<Session>, actions: Actions): void {
  const { body, drawing, fit, landmarks, page, player, view } = actions;
  const keys: Record<string, (event: KeyboardEvent) => void> = {
    n: () => landmarks.wantNext(),
    z: (event) => (event.shiftKey ? body.redo() : body.undo()),
    y: () => body.redo(),
    c: () => landmarks.confirmWanted(),
    f: () => view.from("front"),
    d: () => fit.showDistances(!store.get().showDistances),
    o: () => page.nextOverlay(),
    "?": () => page.help(true),
    escape: () => landmarks.want(null),
    " ": () => player.toggle(),
  };
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    const withControl = event.ctrlKey || event.metaKey;
    if (event.altKey || isTyping(event.target) || (withControl && key !== "z" && key !== "y")) return;
    // Space presses the button that has the focus; only elsewhere it replays.
    if (key === " " && event.target instanceof HTMLElement && event.target.closest("button, a, label, input, summary")) return;
    // The browser closes an open menu by Escape, unless somebody else takes the key.
    if (key === "escape" && document.querySelector(":popover-open")) return;
    const state = store.get();
    if (state.isHelpOpen || state.share.isOpen) return;
    const step = STEPS[key];
    if (cropKey(state, event, actions.scan) || drawingKey(state, event, drawing)) {
      event.preventDefault();
      return;
    }
    if (step && state.scan) page.goTo(step);
    else if (keys[key] && (state.scan || key === "?")) keys[key](event);
    else return;
    event.preventDefault();
  });
}
