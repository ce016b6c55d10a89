// Looks for marks on both scans, and takes those that a person accepts into the picks of each.
import type { Client } from "../../api/client";
import type { LandmarkActions } from "../../landmarks/actions";
import { markKey } from "../../landmarks/picks";
import type { LandmarksSlice } from "../../landmarks/state";
import { record } from "../../store/history";
import type { PageSlice } from "../../store/page";
import { messageOf } from "../../store/problems";
import type { Store } from "../../store/store";
import { scannedOther, type StancesSlice, type Workspace } from "../state";
import { type Found, foundOn, type FoundSlice, pairOf, placesOn } from "./state";
import * as text from "./text";

type State = PageSlice & LandmarksSlice & Workspace & StancesSlice & FoundSlice;

export function foundActions(store: Store<State>, client: Pick<Client, "proposeMarks">, landmarks: Pick<LandmarkActions, "adopt" | "saveWaiting">) {
  const without = (found: Found, names: readonly string[]): Found => (found.state === "found" ? { ...found, marks: found.marks.filter(({ name }) => !names.includes(name)) } : found);

  return {
    /** Shows both scans, and on them what is found. */
    async look(): Promise<void> {
      const pair = pairOf(store.get());
      if (!pair) return;
      const of = { scans: [pair.scans[0], pair.scans[1]] as const };
      store.set((state) => ({ found: { ...of, state: "looking" }, active: null, stances: { ...state.stances, isComparing: true } }));
      const now = await client.proposeMarks(pair.fits[0], pair.fits[1]).then(
        ({ says, marks }): Found => ({ ...of, state: "found", says, marks }),
        (error: unknown): Found => ({ ...of, state: "failed", reason: messageOf(error) }),
      );
      if (foundOn(store.get().found, of.scans)) store.set({ found: now });
    },

    accept(asked: readonly string[]): void {
      const { scan, found, stances, picks: own } = store.get();
      const other = scannedOther(stances);
      if (!scan || !other?.scan || !foundOn(found, [scan.info.id, other.scan.info.id])) return;
      const names = asked.filter((name) => !(markKey(name) in own.present || markKey(name) in other.picks.present)); // a person has named another one so meanwhile
      const [mine, its] = [scan.info.id, other.scan.info.id].map((id) => Object.fromEntries(placesOn(found, id).flatMap(([name, place]) => (names.includes(name) ? [[markKey(name), place]] : []))));
      const picks = record(other.picks, { ...other.picks.present, ...its });
      store.set((state) => ({ found: state.found && without(state.found, names), stances: { ...state.stances, other: { ...other, picks, saving: "unsaved" } } }));
      landmarks.adopt(mine!, text.found.announceAccepted(names));
      void landmarks.saveWaiting(other.scan.info, { picks: picks.present, certain: other.certain });
    },

    dismiss(names: readonly string[]): void {
      store.set(({ found }) => ({ found: found && without(found, names) }));
    },
  };
}

export type FoundActions = ReturnType<typeof foundActions>;
