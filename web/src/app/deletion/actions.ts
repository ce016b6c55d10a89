// Deleting the scan on the page with all that belongs to it.  The service forgets at once and for good; so it is informed
// ten seconds later, or when the page is left, and until then the person can take it back.
import type { Client } from "../../api/client";
import type { FitActions } from "../../fit/actions";
import type { ScanActions } from "../../scan/actions";
import type { StancesActions } from "../../stances/actions";
import { scannedOther } from "../../stances/state";
import type { Outbox } from "../../store/outbox";
import { messageOf, withProblem } from "../../store/problems";
import type { Store } from "../../store/store";
import type { Deletion, Session } from "../session";
import * as text from "../text";

const UNDO_MS = 10_000;

interface Others {
  readonly scan: Pick<ScanActions, "leave" | "open">;
  readonly fit: Pick<FitActions, "open">;
  readonly stances: Pick<StancesActions, "swap" | "remove" | "forget" | "restore">;
  readonly patients: { read(): Promise<void> };
}

export function deletionActions(store: Store<Session>, client: Client, others: Others, outbox: Outbox) {
  let timer: ReturnType<typeof setTimeout> | undefined;

  /** Tells the service now what it would learn later. */
  async function send(): Promise<void> {
    clearTimeout(timer);
    const { deletion } = store.get();
    if (!deletion) return;
    store.set({ deletion: null });
    outbox.forget((scan) => scan === deletion.scan.id);
    try {
      await client.deleteScan(deletion.scan);
      store.set({ announcement: text.deletion.announceDone });
      if (store.get().scan === null) void others.patients.read(); // the list stands there
    } catch (error) {
      store.set((state) => withProblem(state, "page", messageOf(error)));
    }
  }

  function keep(): Deletion | null {
    clearTimeout(timer);
    const { deletion } = store.get();
    store.set({ deletion: null });
    return deletion;
  }

  return {
    ask: (isAsked: boolean): void => store.set({ isAskingToDelete: isAsked }),
    send,

    async confirm(): Promise<void> {
      const { scan, fit, stances } = store.get();
      store.set({ isAskingToDelete: false });
      if (!scan) return;
      await send(); // one at a time
      if (scannedOther(store.get().stances)) {
        await others.stances.swap({ isLeft: true });
        others.stances.remove();
      } else void others.scan.leave();
      others.stances.forget(scan.info.id); // not to choose any more; taken back, it is opened, and so there again
      const waits = scannedOther(stances)?.scan;
      const beside = waits ? { scan: waits.info.id, isSecond: !stances.isSecond } : null;
      const deletion = { scan: scan.info, title: scan.title, fit: fit?.state === "done" ? fit.id : null, frame: scan.frameFrom === "person" ? scan.frame : null, beside };
      store.set({ deletion, announcement: text.deletion.soon(scan.title) });
      timer = setTimeout(() => void send(), UNDO_MS);
    },

    /** Where it was before: on the page with its fit, or beside the stance that stayed. */
    async undo(): Promise<void> {
      const deletion = keep();
      if (!deletion) return;
      const { scan, fit, frame, beside } = deletion;
      const now = store.get();
      if (now.scan === null) {
        if ((await others.scan.open(scan.id, frame)) && fit !== null) await others.fit.open(fit);
      } else if (now.scan.info.id === beside?.scan && !now.stances.other) {
        await others.stances.restore(scan.id, fit, frame, { isSecond: beside.isSecond, isComparing: false });
      }
    },

    /** Somebody opens it again by another way, for instance the browser's Back. */
    keepIf: (scan: string): void => {
      if (store.get().deletion?.scan.id === scan) keep();
    },
  };
}

export type DeletionActions = ReturnType<typeof deletionActions>;
