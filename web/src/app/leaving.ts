// Before the patient on the page gives way to another: what still waits is saved, and what the service would not take is
// asked about.  Nothing that was done is lost without a word.
import type { DrawingActions } from "../drawing/actions";
import type { LandmarkActions } from "../landmarks/actions";
import type { ScanActions } from "../scan/actions";
import type { Store } from "../store/store";
import type { Outbox, Unsaved } from "../store/outbox";
import type { Session } from "./session";

/** What the service does not have yet, of both stances. */
export function unsavedOf({ scan, saving, drawn, stances }: Pick<Session, "scan" | "saving" | "drawn" | "stances">): Exclude<Unsaved, "cuts">[] {
  if (scan === null) return [];
  const all = [{ saving, drawn }, ...(stances.other ? [stances.other] : [])];
  const isIn = (of: (one: (typeof all)[number]) => string): boolean => all.some((one) => of(one) !== "saved");
  return [...(isIn((one) => one.saving) ? ["landmarks" as const] : []), ...(isIn((one) => one.drawn.saving) ? ["lines" as const] : [])];
}

/** The service was asked to keep them and would not, so that a closed page would lose them. */
export const isRefused = ({ scan, saving, drawn, problems }: Pick<Session, "scan" | "saving" | "drawn" | "problems">): boolean =>
  scan !== null && ((saving !== "saved" && problems.landmarks !== undefined) || (drawn.saving !== "saved" && problems.drawing !== undefined));

type Saving = Pick<LandmarkActions, "flush" | "saveNow"> | Pick<DrawingActions, "flush" | "saveNow">;

export function leavingActions(store: Store<Session>, kept: Record<Exclude<Unsaved, "cuts">, Saving>, outbox: Outbox) {
  let answer: ((mayLeave: boolean) => void) | null = null;

  async function save(): Promise<void> {
    await Promise.all([kept.landmarks.flush(), kept.lines.flush()]);
    await Promise.all(unsavedOf(store.get()).map((each) => kept[each].saveNow()));
  }

  /** True when another patient may take the page. */
  async function mayLeave(): Promise<boolean> {
    answer?.(false); // a question that was open is answered by asking for something else
    await save();
    const unsaved = unsavedOf(store.get());
    if (unsaved.length === 0) return true;
    store.set({ leaving: unsaved });
    return new Promise((done) => (answer = done));
  }

  function reply(isLeaving: boolean): void {
    store.set({ leaving: null });
    answer?.(isLeaving);
    answer = null;
  }

  return {
    mayLeave,
    stay: (): void => reply(false),
    leaveAnyhow(): void {
      const { scan, stances } = store.get();
      outbox.forget((id) => id === scan?.info.id || id === stances.other?.scan?.info.id);
      reply(true);
    },
    async saveAgain(): Promise<void> {
      await save();
      const unsaved = unsavedOf(store.get());
      if (unsaved.length === 0) reply(true);
      else store.set({ leaving: unsaved });
    },
    /** The same ways to another scan, each asked about first; a scan that is already there is no other. */
    guarded: (scan: ScanActions): ScanActions => ({
      ...scan,
      upload: async (...file) => (await mayLeave()) && scan.upload(...file),
      takeExample: async (name) => (await mayLeave()) && scan.takeExample(name),
      open: async (id, own) => (await mayLeave()) && scan.open(id, own),
      leave: async () => (await mayLeave()) && scan.leave(),
    }),
  };
}

export type LeavingActions = ReturnType<typeof leavingActions>;
