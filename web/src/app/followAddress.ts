// Keeps the address and the state in step: reads it once when the page opens and whenever the browser goes back or forth
// or a person changes it, writes it when something else is shown.  Another patient, another step and the other stance are
// entries of the browser's history: Back undoes them one by one, and asks before it leaves unsaved work.
import type { Frame } from "../api/types";
import type { Step } from "../store/page";
import type { Store } from "../store/store";
import type { Actions } from "./actions";
import { fromHash, type PageAddress, toHash } from "./address";
import type { Session } from "./session";

function hashOf(state: Session): string {
  const { other, isSecond, isComparing } = state.stances;
  const frameOf = ({ scan }: Pick<Session, "scan">): Frame | null => (scan?.frameFrom === "person" ? scan.frame : null);
  return toHash({
    scan: state.scan?.info.id ?? null,
    fit: state.fit?.id ?? null,
    step: state.step,
    frame: frameOf(state),
    other: other?.scan ? { scan: other.scan.info.id, fit: other.fit?.id ?? null, frame: frameOf(other) } : null,
    isSecond,
    isComparing,
  });
}

/** What makes an entry of the history; all else changes the one that is there. */
const entryOf = ({ scan, step, other, isSecond }: PageAddress): string => (scan === null ? "" : [scan, step, other?.scan, isSecond].join());

const OURS = { byThePage: true }; // an entry that the page wrote: its fit may have been replaced since

export async function followAddress(store: Store<Session>, actions: Actions): Promise<void> {
  let isOpening = false;
  let entry = "";
  let timer: ReturnType<typeof setTimeout> | undefined;
  let queue = Promise.resolve();

  /** Goes to what the address names, from wherever the page is. */
  async function go(to: PageAddress, isOurs: boolean): Promise<void> {
    const { scan, fit, step, frame, other, ...stances } = to;
    const before = store.get();
    const gone = actions.page.gone();
    let left: readonly (Step | null)[] = [before.step]; // steps at which what is done here leaves the page
    const shown = before.scan?.info.id;
    if (scan === null) {
      if (shown !== undefined) await actions.scan.leave();
      return;
    }
    if (scan !== shown && scan === before.stances.other?.scan?.info.id) await actions.stances.swap();
    else if (scan !== shown) {
      left = ["body", step];
      const isThere = await actions.scan.open(scan, frame);
      if (isThere && fit !== null) await actions.fit.open(fit, step);
      if (isThere && other && other.scan !== store.get().stances.other?.scan?.info.id) {
        await actions.stances.restore(other.scan, other.fit, other.frame, stances);
      }
      if (!isThere) return;
    } else if (!isOurs && fit !== null && fit !== (before.fit?.id ?? null)) await actions.fit.open(fit, step);
    const now = store.get();
    const isRunning = now.fit?.state === "running" && !isOurs; // then the step that shows it
    const isElsewhere = gone !== actions.page.gone() || !left.includes(now.step); // somebody went on while the second scan was still coming
    if (step !== null && step !== now.step && !isRunning && !isElsewhere) actions.page.goTo(step);
  }

  async function open(isOurs: boolean): Promise<void> {
    isOpening = true; // what is not there yet must not be wiped from the address
    const to = fromHash(location.hash);
    entry = entryOf(to);
    try {
      await go(to, isOurs);
    } finally {
      isOpening = false;
    }
    if (store.get().scan !== null || to.scan === null) write(); // a scan that is gone stays named: the page says so
  }

  function write(): void {
    const state = store.get();
    const wanted = hashOf(state);
    const now = entryOf(fromHash(wanted));
    if (isOpening || (wanted === location.hash && now === entry)) return;
    const address = wanted === "" ? location.pathname : wanted;
    if (now === entry) history.replaceState(OURS, "", address);
    else history.pushState(OURS, "", address);
    entry = now;
  }

  await open(false);
  history.replaceState(OURS, "");
  addEventListener("popstate", (event) => {
    const isOurs = (event.state as Partial<typeof OURS> | null)?.byThePage === true;
    if (store.get().leaving) actions.leaving.stay(); // who goes elsewhere has not said yes
    queue = queue.then(() => open(isOurs)); // in the order in which they were asked for
  });
  // Soon after each change: what changes in one go, such as the second stance and its scan, is one entry.
  store.subscribe(() => {
    timer ??= setTimeout(() => {
      timer = undefined;
      write();
    }, 0);
  });
}
