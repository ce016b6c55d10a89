// What brings scans in: files, examples, the same file read otherwise; each is fitted at once unless something is asked first.
import type { Client } from "../api/client";
import type { FitActions } from "../fit/actions";
import type { ScanActions } from "../scan/actions";
import { isSizeAsked } from "../scan/state";
import type { StancesActions } from "../stances/actions";
import { home } from "../patients/text";
import { isGroupMissing } from "../store/person";
import { withProblem } from "../store/problems";
import type { Store } from "../store/store";
import type { Takers } from "./bringing/bringFiles";
import type { Session } from "./session";

interface Others extends Omit<Takers, "begin"> {
  readonly scan: Takers["scan"] & Pick<ScanActions, "takeExample" | "confirm" | "confirmModel" | "readAgain" | "takeSegments">;
  readonly stances: Takers["stances"] & Pick<StancesActions, "takeExampleBeside">;
  readonly fit: Pick<FitActions, "start">;
}

export function bringActions(store: Store<Session>, client: Pick<Client, "landmarkFile" | "saveLandmarks">, others: Others) {
  function begin(): void {
    const { scan, fit, fitsAtOnce } = store.get();
    if (scan && fit === null && fitsAtOnce && !isSizeAsked(store.get())) void others.fit.start();
  }

  /** Said where a new patient would belong to a group that only the person can name. */
  function isUnowned(): boolean {
    const isMissing = store.get().scan === null && isGroupMissing(store.get());
    if (isMissing) store.set((state) => withProblem(state, "scan", home.groupMissing));
    return isMissing;
  }

  return {
    files: async (all: readonly File[]): Promise<void> => {
      if (!isUnowned()) await (await import("./bringing/bringFiles")).createBringing(store, client, { ...others, begin })(all);
    },
    begin,

    /** The file of the scan on the page, read otherwise. */
    async again(how: Parameters<ScanActions["readAgain"]>[0]): Promise<void> {
      if (!(await others.scan.readAgain(how))) return;
      if (how.model !== undefined) await others.scan.confirmModel();
      begin();
    },

    takeSegments: async (chosen: Parameters<ScanActions["takeSegments"]>[0]): Promise<boolean> => {
      const isThere = await others.scan.takeSegments(chosen);
      if (isThere) begin();
      return isThere;
    },

    /** Scans of the example patient, of whom there is one. */
    async examples([first, ...further]: readonly string[]): Promise<void> {
      if (first === undefined || isUnowned() || !(await others.scan.takeExample(first))) return;
      begin();
      for (const name of further) await others.stances.takeExampleBeside(name, store.get().fitsAtOnce);
    },

    /** Somebody says that the size which looked wrong is right. */
    sizeIsRight: (): void => {
      others.scan.confirm();
      begin();
    },

    chooseFitsAtOnce: (fitsAtOnce: boolean): void => store.set({ fitsAtOnce }),
  };
}
