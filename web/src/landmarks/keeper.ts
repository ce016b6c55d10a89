// Keeps the picks of each scan at the service: one change after the other, and none over what somebody else has placed
// meanwhile.  Then theirs are read, both are brought together, and the page is told: what it does not show it would take
// away with its next change.
import { ApiError, type Client } from "../api/client";
import type { LandmarkFile, Scan } from "../api/types";
import { picksOf } from "./picks";
import { type KeptPicks, NO_PICKS, type Together, together } from "./together";

const CHANGED = 412; // the picks that the change began with are not there any more
const TRIES = 5; // somebody writes all the time: give up and say so

/** Somebody else has changed picks that began as `base`: what is shown has to follow.  False where the scan is not shown. */
export type Elsewhere = (scan: Scan, base: KeptPicks, theirs: KeptPicks, both: Together) => boolean;

interface Known extends KeptPicks {
  readonly seen: string | null; // their tag at the service; null where it gives none
}

const fileOf = ({ picks, certain }: KeptPicks): LandmarkFile => ({ schema: "breastrig/landmarks@1", unit: "mm", landmarks: { ...picks }, certain: [...certain] });

export function createPicksKeeper(client: Pick<Client, "landmarks" | "saveLandmarks">, elsewhere: Elsewhere) {
  const known = new Map<string, Known>(); // by scan: as the page knows them
  const queues = new Map<string, Promise<unknown>>();

  function queued<Value>(scan: Scan, work: () => Promise<Value>): Promise<Value> {
    const before = queues.get(scan.id);
    const next = before ? before.then(work, work) : work(); // at once, where nothing is on its way: the page may be about to close
    const clear = (): void => {
      if (queues.get(scan.id) === done) queues.delete(scan.id);
    };
    const done: Promise<void> = next.then(clear, clear);
    queues.set(scan.id, done);
    return next;
  }

  async function fetched(scan: Scan): Promise<Known> {
    const file = await client.landmarks(scan);
    return { picks: picksOf(file), certain: file.certain ?? [], seen: file.seen ?? null };
  }

  async function write(scan: Scan, mine: KeptPicks): Promise<void> {
    const base = known.get(scan.id) ?? { ...NO_PICKS, seen: "" }; // that could not be read: what is there is none of mine
    let [theirs, both]: [Known | null, Together] = [null, { ...mine, taken: [], overruled: [] }];
    for (let tries = 1; ; tries += 1) {
      try {
        const { seen = null } = await client.saveLandmarks(scan, fileOf(both), (theirs ?? base).seen);
        // Where the scan is not shown nothing follows: its next change begins where this one did, and is brought together again.
        if (!theirs || elsewhere(scan, base, theirs, both)) known.set(scan.id, { picks: both.picks, certain: both.certain, seen });
        return;
      } catch (error) {
        if (!(error instanceof ApiError) || error.status !== CHANGED || tries === TRIES) throw error;
        theirs = await fetched(scan);
        both = together(base, mine, theirs);
      }
    }
  }

  return {
    read: (scan: Scan): Promise<KeptPicks> =>
      queued(scan, async () => {
        const now = await fetched(scan);
        known.set(scan.id, now);
        return now;
      }),
    /** `mine` is asked when its turn has come: what it puts back must be what is shown by then. */
    save: (scan: Scan, mine: () => KeptPicks): Promise<void> => queued(scan, () => write(scan, mine())),
    /** Before the page goes: what waits behind another change would never be sent. */
    saveLast: async (scan: Scan, mine: () => KeptPicks): Promise<void> => {
      if (queues.has(scan.id)) await client.saveLandmarks(scan, fileOf(mine()), null);
      else await write(scan, mine());
    },
    /** Takes over what somebody else has placed since, where nothing of the own is unsaved. */
    look: (scan: Scan, mine: () => KeptPicks | null): Promise<void> =>
      queued(scan, async () => {
        const base = known.get(scan.id);
        if (typeof base?.seen !== "string") return;
        const theirs = await fetched(scan);
        const own = mine();
        if (theirs.seen === base.seen || !own) return;
        if (elsewhere(scan, base, theirs, together(base, own, theirs))) known.set(scan.id, theirs);
      }),
  };
}

export type PicksKeeper = ReturnType<typeof createPicksKeeper>;
