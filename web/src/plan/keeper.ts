// Keeps each patient's plan at the service: one change after the other, and none over what somebody else has written
// meanwhile.  Then their plan is read, both are brought together, and whoever shows the plan is informed: what a page does not
// show it would delete with its next change.
import type { Client } from "../api/client";
import { createQueues, writtenOver } from "../api/concurrentWrites";
import type { PlanItem, StoredPlan } from "../api/types";
import { merged, timesLarger } from "./items";

type Change = (items: readonly PlanItem[]) => readonly PlanItem[];

type Items = readonly PlanItem[];

/** What two have changed at once. */
export interface Both {
  readonly base: Items;
  readonly mine: Items;
  readonly theirs: Items;
}

/** Somebody else has changed the plan: what is shown as `mine`, or of a plan that nobody had begun, has to follow to what it is `now`. */
export type Elsewhere = (link: string, mine: Pick<StoredPlan, "items" | "whole">, now: Items, both: Both | null) => void;

type Service = Pick<Client, "plan" | "savePlan" | "planVersion">;

/** The service as a page sees it that shows scans in these `sizes`, times those of their files: somebody may have given them others. */
const inSizes = (client: Service, sizes: ReadonlyMap<string, number>): Service => {
  const shown = (plan: StoredPlan): StoredPlan => {
    const now = new Map(plan.scans.map(({ id, scale }) => [id, scale ?? 1]));
    return { ...plan, items: timesLarger(plan.items, (scan) => (now.has(scan) ? (sizes.get(scan) ?? now.get(scan)!) / now.get(scan)! : 1)) };
  };
  return {
    plan: async (link) => shown(await client.plan(link)),
    planVersion: async (link, version) => shown(await client.planVersion(link, version)),
    savePlan: async (link, items, seen) => shown(await client.savePlan(link, items, seen, sizes)),
  };
};

export function createPlanKeeper(service: Service, elsewhere: Elsewhere = () => undefined, sizes: ReadonlyMap<string, number> = new Map()) {
  const client = inSizes(service, sizes);
  const known = new Map<string, StoredPlan>(); // by link: as last read or written
  const { queued, settled } = createQueues();

  async function read(link: string): Promise<StoredPlan> {
    const plan = await client.plan(link);
    const before = known.get(link);
    known.set(link, plan);
    if (before && before.seen !== plan.seen) elsewhere(link, before, plan.items, null);
    return plan;
  }

  async function write(link: string, change: Change): Promise<void> {
    let base = known.get(link) ?? (await read(link));
    const mine = { items: [...change(base.items)], whole: base.whole };
    let items = mine.items;
    const begun = base;
    let both: Both | null = null;
    const stored = await writtenOver(
      async () => {
        const isThere = base.whole && JSON.stringify(items) === JSON.stringify(base.items);
        return isThere ? base : client.savePlan(link, items, base.seen ?? null);
      },
      async () => {
        const theirs = await client.plan(link);
        both = { base: begun.items, mine: mine.items, theirs: theirs.items };
        items = merged(base.items, items, theirs.items);
        base = theirs;
      },
    );
    known.set(link, stored);
    if (base !== begun) elsewhere(link, mine, stored.items, both);
  }

  return {
    read: (link: string): Promise<StoredPlan> => queued(link, () => read(link)),
    /** `change` is asked when its turn has come: what it puts back must be what is shown by then. */
    save: (link: string, change: Change): Promise<void> => queued(link, () => write(link, change)),
    /** Whether the service has another plan than was read or written here last. */
    isChangedElsewhere: (link: string): Promise<boolean> =>
      queued(link, async () => {
        const seen = known.get(link);
        return seen !== undefined && (await client.plan(link)).seen !== seen.seen;
      }),
    /** As last seen; null before it was read. */
    seen: (link: string): StoredPlan | null => known.get(link) ?? null,
    /** What waits to be written is written. */
    settled,
    /** The newest version before `version` whose items `differ`; null when there is none any more. */
    async earlier(link: string, version: number, differs: (plan: StoredPlan) => boolean): Promise<StoredPlan | null> {
      for (let number = version - 1; number > 0; number -= 1) {
        const plan = await client.planVersion(link, number).catch(() => null);
        if (plan === null || differs(plan)) return plan;
      }
      return null;
    },
  };
}
