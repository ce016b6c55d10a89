// Keeps each patient's plan at the service: one change after the other, and none over what somebody else has written
// meanwhile.  Then their plan is read and both are brought together.
import { ApiError, type Client } from "../api/client";
import type { PlanItem, StoredPlan } from "../api/types";
import { merged } from "./items";

const CHANGED = 412; // the plan that the change began with is not there any more
const TRIES = 5; // somebody writes all the time: give up and say so

type Change = (items: readonly PlanItem[]) => PlanItem[];

export interface Kept {
  readonly items: readonly PlanItem[];
  /** Somebody else had changed the plan: it holds their changes as well. */
  readonly isMerged: boolean;
}

export function createPlanKeeper(client: Pick<Client, "plan" | "savePlan" | "planVersion">) {
  const known = new Map<string, StoredPlan>(); // by link: as last read or written
  const queues = new Map<string, Promise<unknown>>();

  function queued<Value>(link: string, work: () => Promise<Value>): Promise<Value> {
    const before = queues.get(link) ?? Promise.resolve();
    const next = before.then(work, work);
    queues.set(link, next.catch(() => undefined));
    return next;
  }

  async function read(link: string): Promise<StoredPlan> {
    const plan = await client.plan(link);
    known.set(link, plan);
    return plan;
  }

  async function write(link: string, change: Change): Promise<Kept> {
    let base = known.get(link) ?? (await read(link));
    let items = change(base.items);
    let isMerged = false;
    for (let tries = 1; ; tries += 1) {
      if (base.whole && JSON.stringify(items) === JSON.stringify(base.items)) return { items, isMerged };
      try {
        const stored = await client.savePlan(link, items, base.version);
        known.set(link, stored);
        return { items: stored.items, isMerged };
      } catch (error) {
        if (!(error instanceof ApiError) || error.status !== CHANGED || tries === TRIES) throw error;
        const theirs = await read(link);
        items = merged(base.items, items, theirs.items);
        base = theirs;
        isMerged = true;
      }
    }
  }

  return {
    read: (link: string): Promise<StoredPlan> => queued(link, () => read(link)),
    save: (link: string, change: Change): Promise<Kept> => queued(link, () => write(link, change)),
    /** Whether the service has another plan than was read or written here last. */
    isChangedElsewhere: (link: string): Promise<boolean> =>
      queued(link, async () => {
        const seen = known.get(link);
        return seen !== undefined && (await client.plan(link)).version !== seen.version;
      }),
    /** As last seen; null before it was read. */
    seen: (link: string): StoredPlan | null => known.get(link) ?? null,
    /** What waits to be written is written. */
    settled: async (): Promise<void> => {
      await Promise.all(queues.values());
    },
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

export type PlanKeeper = ReturnType<typeof createPlanKeeper>;
