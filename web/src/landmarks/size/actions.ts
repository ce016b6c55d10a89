// A scan gets its true size: all that is kept of it is then read again, as where another scan is opened.
import type { Client } from "../../api/client";
import type { Scan } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { messageOf, withProblem } from "../../store/problems";
import { type History, record, redo, undo } from "../../store/history";
import type { Store } from "../../store/store";
import type { LandmarksSlice } from "../state";
import { type End, endsOf, initialRuler, isRuler, rulerKey, type RulerSlice, type Scale, sentEnd, type Side, sizesOf, type SizesSlice } from "./ruler";
import { size as text } from "./text";

type State = PageSlice & ScanSlice & LandmarksSlice & RulerSlice & SizesSlice;

interface Others {
  /** What waits is saved in the size that it was made in. */
  flush(): Promise<unknown>;
  /** Ends the fit that runs: it is of the size that goes. */
  cancel(): Promise<unknown>;
  /** Reads the scan and what is kept of it again. */
  reopen(scan: Scan): Promise<boolean>;
  /** Fits the scan that has just come. */
  begin(): void;
}

export function sizeActions(store: Store<State>, client: Pick<Client, "putLength" | "deleteLength" | "scan">, others: Others) {
  let isChanging = false;

  /** `step`: the sizes that it had, with the one that comes. */
  async function change(ask: (scan: Scan) => Promise<Scan>, step: (sizes: History<Scale>, now: Scale) => History<Scale>, said: Partial<State>): Promise<void> {
    const { scan } = store.get();
    if (!scan || isChanging) return;
    const before = sizesOf(store.get());
    isChanging = true;
    store.set((state) => withProblem(state, "size", null));
    try {
      await others.flush();
      const info = await ask(scan.info);
      if (store.get().scan?.info.id !== info.id || !(await others.reopen(info))) return;
      store.set({ ...said, sizes: { scan: info.id, history: step(before, info.scale ?? null) } });
      others.begin();
    } catch (error) {
      store.set((state) => withProblem(state, "size", messageOf(error)));
    } finally {
      isChanging = false;
    }
  }

  const byHand = (announcement: string) => [record<Scale>, { announcement }] as const;

  /** One of the sizes that it had. */
  async function goTo(step: (sizes: History<Scale>) => History<Scale>, says: (to: Scale) => string): Promise<void> {
    const { present: to } = step(sizesOf(store.get()));
    const ask = (scan: Scan): Promise<Scan> => {
      if (to === null) return client.deleteLength(scan);
      const [from, end] = endsOf(to, scan.scale ?? null, store.get().picks.present);
      return client.putLength(scan, { from: from!, to: end!, length_mm: to.mm });
    };
    await others.cancel();
    await change(ask, (sizes) => step(sizes), { announcement: "", undone: { says: says(to) } });
  }

  const wanted = (side: Side): Partial<State> => ({ active: rulerKey(side), isCropping: false, announcement: side === "from" ? text.clickFrom : text.clickTo });

  return {
    /** Two clicks on the scan; again, to leave it. */
    measure: (): void => store.set(({ active }) => (active !== null && isRuler(active) ? { active: null } : { ...initialRuler, ...wanted("from") })),
    choose: (side: Side, end: End): void => store.set(({ ruler, active }) => ({ ruler: { ...ruler, [side]: end }, active: active === rulerKey(side) ? null : active, ...(end === null ? wanted(side) : {}) })),
    apply(mm: number): Promise<void> {
      const { from, to } = store.get().ruler;
      return from === null || to === null ? Promise.resolve() : change((scan) => client.putLength(scan, { from: sentEnd(from), to: sentEnd(to), length_mm: mm }), ...byHand(text.applied));
    },
    remove: (): Promise<void> => change((scan) => client.deleteLength(scan), ...byHand(text.removed)),
    undo: (): Promise<void> => goTo(undo, text.undone),
    redo: (): Promise<void> => goTo(redo, text.redone),
    /** Another tab, or somebody else, may have given it another size: what is placed here would be in the wrong one. */
    async look(): Promise<void> {
      const { scan } = store.get();
      const now = scan && (await client.scan(scan.info.id).catch(() => null));
      const shown = store.get().scan?.info;
      if (!now || shown?.id !== now.id || shown.scale?.factor === now.scale?.factor || !(await others.reopen(now))) return;
      store.set((state) => ({ sizes: null, announcement: text.elsewhere, ...withProblem(state, "size", text.elsewhere) }));
    },
    dismiss: (): void => store.set((state) => withProblem(state, "size", null)),
  };
}

export type SizeActions = ReturnType<typeof sizeActions>;
