// What could not be saved is tried again by itself: soon, then less and less often, and at once when the browser is online
// again or somebody looks at the page.
import type { PageSlice } from "../store/page";
import type { Outbox } from "../store/outbox";
import type { Store } from "../store/store";
import { unsaved as words } from "./text";

const FIRST_MS = 1000;
const MOST_MS = 30_000;

interface Room {
  /** Tries to save all that waits. */
  retry(): Promise<void>;
}

export function keepTrying(store: Store<PageSlice>, outbox: Outbox, rooms: readonly Room[]) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let wait = FIRST_MS;
  let isTrying = false;

  async function now(): Promise<void> {
    clearTimeout(timer);
    timer = undefined;
    if (isTrying) return;
    isTrying = true;
    for (const room of rooms) await room.retry();
    isTrying = false;
    follow();
  }

  function follow(): void {
    const refused = outbox.refused();
    const before = store.get().unsaved;
    const isFull = outbox.isFull();
    if (!refused && before) store.set({ unsaved: null, announcement: words.saved });
    if (refused && (before?.why !== refused.why || before.what.join() !== refused.what.join() || before.isFull !== isFull)) store.set({ unsaved: { what: refused.what, why: refused.why, isFull } });
    if (!refused) wait = FIRST_MS;
    if (!refused?.mayPass || isTrying || timer !== undefined) return;
    timer = setTimeout(() => void now(), wait);
    wait = Math.min(2 * wait, MOST_MS);
  }

  outbox.follow(follow);
  return {
    now,
    /** The browser or a person says that it may work again. */
    soon(): void {
      if (!outbox.refused()) return;
      wait = FIRST_MS;
      void now();
    },
  };
}
