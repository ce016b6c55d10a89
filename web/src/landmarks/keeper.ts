// Keeps the picks of each scan at the service: one change after the other, and none over what somebody else has placed
// meanwhile.  Then theirs are read, both are brought together, and the page is informed: what it does not show it would take
// away with its next change.
import type { Client } from "../api/client";
import { createQueues, writtenOver } from "../api/concurrentWrites";
import type { LandmarkFile, Scan } from "../api/types";
import { picksOf, placesOf } from "./picks";
import { type KeptPicks, NO_PICKS, timesLarger, type Together, together } from "./together";

/** Somebody else has changed picks that began as `base`: what is shown has to follow.  False where the scan is not shown. */
export type Elsewhere = (scan: Named, base: KeptPicks, theirs: KeptPicks, both: Together) => boolean;

/** As the service had them when they were read or written last. */
export interface Known extends KeptPicks {
  readonly seen: string | null; // their tag at the service; null where it gives none
  readonly scale?: number | undefined; // the scan's size in which they are, times that of its file; undefined: nobody knows, and the service takes its present one
}

type Named = Pick<Scan, "id" | "links">;

export const fileOf = ({ picks, certain }: KeptPicks): LandmarkFile => ({ schema: "breastrig/landmarks@1", unit: "mm", ...placesOf(picks), certain: [...certain] });

const sizeOf = ({ scale }: Pick<Scan, "scale">): number => scale?.factor ?? 1;

/** The same picks in another size of the scan. */
export const inSize = <Kept extends Known>(kept: Kept, scale: number | undefined): Kept =>
  scale === undefined || kept.scale === undefined ? kept : { ...timesLarger(kept, scale / kept.scale), scale };

export function createPicksKeeper(client: Pick<Client, "landmarks" | "saveLandmarks">, elsewhere: Elsewhere) {
  const known = new Map<string, Known>(); // by scan: as the page knows them
  const { queued, isBusy } = createQueues();

  /** Somebody may have given the scan another size than the page shows. */
  async function fetched(scan: Named, shown: number | undefined): Promise<Known> {
    const file = await client.landmarks(scan);
    return inSize({ picks: picksOf(file), certain: file.certain ?? [], seen: file.seen ?? null, scale: file.scale ?? 1 }, shown);
  }

  const sent = (mine: KeptPicks, base: Known | undefined): LandmarkFile => ({ ...fileOf(mine), ...(base?.scale === undefined ? {} : { scale: base.scale }) });

  async function write(scan: Named, mine: KeptPicks): Promise<void> {
    const base = known.get(scan.id) ?? { ...NO_PICKS, seen: "" }; // that could not be read: what is there is none of mine
    const now: { theirs: Known | null; both: Together } = { theirs: null, both: { ...mine, taken: [], overruled: [] } };
    const { seen = null } = await writtenOver(
      () => client.saveLandmarks(scan, sent(now.both, base), (now.theirs ?? base).seen),
      async () => {
        now.theirs = await fetched(scan, base.scale);
        now.both = together(base, mine, now.theirs);
      },
    );
    const { theirs, both } = now;
    // Where the scan is not shown nothing follows: its next change begins where this one did, and is brought together again.
    if (!theirs || elsewhere(scan, base, theirs, both)) known.set(scan.id, { picks: both.picks, certain: both.certain, seen, scale: base.scale ?? theirs?.scale });
  }

  return {
    /** In the size of the scan that the page shows. */
    read: (scan: Pick<Scan, "id" | "links" | "scale">): Promise<Known> =>
      queued(scan.id, async () => {
        const now = await fetched(scan, sizeOf(scan));
        known.set(scan.id, now);
        return now;
      }),
    /** What a change of the scan's picks begins with; of a scan that was not read here: as it was said to be. */
    base: (scan: string, said: Known = { ...NO_PICKS, seen: "" }): Known => {
      const found = known.get(scan) ?? said;
      known.set(scan, found);
      return found;
    },
    /** `mine` is asked when its turn has come: what it puts back must be what is shown by then. */
    save: (scan: Named, mine: () => KeptPicks): Promise<void> => queued(scan.id, () => write(scan, mine())),
    /** Before the page goes: what waits behind another change would never be sent. */
    saveLast: async (scan: Named, mine: () => KeptPicks): Promise<void> => {
      if (isBusy(scan.id)) await client.saveLandmarks(scan, sent(mine(), known.get(scan.id)), null);
      else await write(scan, mine());
    },
    /** Takes over what somebody else has placed since, where nothing of the own is unsaved. */
    look: (scan: Named, mine: () => KeptPicks | null): Promise<void> =>
      queued(scan.id, async () => {
        const base = known.get(scan.id);
        if (typeof base?.seen !== "string") return;
        const theirs = await fetched(scan, base.scale);
        const own = mine();
        if (theirs.seen === base.seen || !own) return;
        if (elsewhere(scan, base, theirs, together(base, own, theirs))) known.set(scan.id, theirs);
      }),
  };
}
