// A scan gets its true size: all that is kept of it is then read again, as where another scan is opened.
import type { Client } from "../../api/client";
import type { Scan } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { messageOf, withProblem } from "../../store/problems";
import type { Store } from "../../store/store";
import type { LandmarksSlice } from "../state";
import { type End, initialRuler, isRuler, rulerKey, type RulerSlice, sentEnd, type Side } from "./ruler";
import { size as text } from "./text";

type State = PageSlice & ScanSlice & LandmarksSlice & RulerSlice;

interface Others {
  /** What waits is saved in the size that it was made in. */
  flush(): Promise<unknown>;
  /** Reads the scan and what is kept of it again. */
  reopen(scan: Scan): Promise<boolean>;
  /** Fits the scan that has just come. */
  begin(): void;
}

export function sizeActions(store: Store<State>, client: Pick<Client, "putLength" | "deleteLength" | "scan">, others: Others) {
  async function change(ask: (scan: Scan) => Promise<Scan>, announcement: string): Promise<void> {
    const { scan } = store.get();
    if (!scan) return;
    store.set((state) => withProblem(state, "size", null));
    try {
      await others.flush();
      const info = await ask(scan.info);
      if (store.get().scan?.info.id !== info.id || !(await others.reopen(info))) return;
      store.set({ announcement });
      others.begin();
    } catch (error) {
      store.set((state) => withProblem(state, "size", messageOf(error)));
    }
  }

  const wanted = (side: Side): Partial<State> => ({ active: rulerKey(side), isCropping: false, announcement: side === "from" ? text.clickFrom : text.clickTo });

  return {
    /** Two clicks on the scan; again, to leave it. */
    measure: (): void => store.set(({ active }) => (active !== null && isRuler(active) ? { active: null } : { ...initialRuler, ...wanted("from") })),
    choose: (side: Side, end: End): void => store.set(({ ruler, active }) => ({ ruler: { ...ruler, [side]: end }, active: active === rulerKey(side) ? null : active, ...(end === null ? wanted(side) : {}) })),
    apply(mm: number): Promise<void> {
      const { from, to } = store.get().ruler;
      return from === null || to === null ? Promise.resolve() : change((scan) => client.putLength(scan, { from: sentEnd(from), to: sentEnd(to), length_mm: mm }), text.applied);
    },
    remove: (): Promise<void> => change((scan) => client.deleteLength(scan), text.removed),
    /** Another tab, or somebody else, may have given it another size: what is placed here would be in the wrong one. */
    async look(): Promise<void> {
      const { scan } = store.get();
      const now = scan && (await client.scan(scan.info.id).catch(() => null));
      const shown = store.get().scan?.info;
      if (!now || shown?.id !== now.id || shown.scale?.factor === now.scale?.factor || !(await others.reopen(now))) return;
      store.set((state) => ({ announcement: text.elsewhere, ...withProblem(state, "size", text.elsewhere) }));
    },
    dismiss: (): void => store.set((state) => withProblem(state, "size", null)),
  };
}

export type SizeActions = ReturnType<typeof sizeActions>;
