// Writing what several pages may write: one change after the other from this page, and none over what another has
// written meanwhile.
import { ApiError } from "./client";

const CHANGED = 412; // what the change began with is not there any more
const TRIES = 5; // somebody writes all the time: give up and say so

/** Work on each key, one after the other. */
export function createQueues() {
  const last = new Map<string, Promise<unknown>>();
  return {
    /** Begins at once where nothing is on its way: the page may be about to close. */
    queued: <Value>(key: string, work: () => Promise<Value>): Promise<Value> => {
      const before = last.get(key);
      const next = before ? before.then(work, work) : work();
      const clear = (): void => {
        if (last.get(key) === done) last.delete(key);
      };
      const done: Promise<void> = next.then(clear, clear);
      last.set(key, done);
      return next;
    },
    isBusy: (key: string): boolean => last.has(key),
    /** All that was queued by now has ended, one way or the other. */
    settled: async (): Promise<void> => {
      await Promise.all(last.values());
    },
  };
}

/** What `write` gives; where another has written since, `bringTogether` goes before the next try. */
export async function writtenOver<Stored>(write: () => Promise<Stored>, bringTogether: () => Promise<void>): Promise<Stored> {
  for (let tries = 1; ; tries += 1) {
    try {
      return await write();
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== CHANGED || tries === TRIES) throw error;
      await bringTogether();
    }
  }
}
