// Keeps the address and the state in step: reads it once when the page opens and whenever a person changes it,
// writes it when another scan or fit is shown.
import type { Frame } from "../api/types";
import type { Store } from "../store/store";
import type { Actions } from "./actions";
import { fromHash, toHash } from "./address";
import type { Session } from "./session";

function hashOf(state: Session): string {
  const { other, isSecond, isComparing } = state.stances;
  const frameOf = ({ scan }: Pick<Session, "scan">): Frame | null => (scan?.frameFrom === "person" ? scan.frame : null);
  return toHash({
    scan: state.scan?.info.id ?? null,
    fit: state.fit?.id ?? null,
    frame: frameOf(state),
    other: other?.scan ? { scan: other.scan.info.id, fit: other.fit?.id ?? null, frame: frameOf(other) } : null,
    isSecond,
    isComparing,
  });
}

export async function followAddress(store: Store<Session>, actions: Actions): Promise<void> {
  let isOpening = false;

  async function open(): Promise<void> {
    const { scan, fit, frame, other, ...stances } = fromHash(location.hash);
    const state = store.get();
    if (scan === null || (scan === state.scan?.info.id && fit === (state.fit?.id ?? null))) return;
    isOpening = true; // what is not there yet must not be wiped from the address
    try {
      const isThere = scan === state.scan?.info.id || (await actions.scan.open(scan, frame));
      if (isThere && fit !== null) await actions.fit.open(fit);
      if (isThere && other && other.scan !== store.get().stances.other?.scan?.info.id) {
        await actions.stances.restore(other.scan, other.fit, other.frame, stances);
      }
    } finally {
      isOpening = false;
    }
  }

  await open();
  addEventListener("hashchange", () => void open());
  // At every change: what was held back while a scan was being opened is written with the next one.
  store.subscribe((state) => {
    const wanted = hashOf(state);
    if (isOpening || wanted === location.hash) return;
    history.replaceState(null, "", wanted === "" ? location.pathname : wanted);
  });
}
