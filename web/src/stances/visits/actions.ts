// The visits of a patient: on which day each scan was taken, as a person says it, and what changed between the days.
import type { Client } from "../../api/client";
import type { Frame } from "../../api/types";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { messageOf, withProblem } from "../../store/problems";
import type { Store } from "../../store/store";
import type { StancesSlice, VisitsState } from "../state";

type State = PageSlice & ScanSlice & StancesSlice;

export function visitsActions(store: Store<State>, client: Client) {
  const put = (part: Partial<VisitsState>): void => store.set(({ stances }) => ({ stances: { ...stances, visits: { ...stances.visits, ...part } } }));
  const patient = (): string | undefined => store.get().scan?.info.patient;

  let said = Promise.resolve(); // one after the other: what was said last counts

  /** Asks the service; an answer for a patient who is not on the page any more is dropped. */
  async function forPatient(ask: (of: string) => Promise<Partial<VisitsState>>): Promise<void> {
    const of = patient();
    if (of === undefined) return;
    store.set((state) => withProblem(state, "stances", null));
    put({ isBusy: true });
    try {
      const found = await ask(of);
      if (patient() === of) put({ ...found, isBusy: false });
    } catch (error) {
      put({ isBusy: false });
      store.set((state) => withProblem(state, "stances", messageOf(error)));
    }
  }

  const read = async (of: string): Promise<Partial<VisitsState>> => {
    const { scans } = await client.visits(of);
    return { days: scans, file: await client.visitsFile(of) };
  };

  return {
    async open(): Promise<void> {
      put({ isOpen: true, file: null });
      await forPatient(read);
    },

    close: (): void => put({ isOpen: false }),

    /** The map of a change on the body of an earlier scan, and which way that faces; null after a sentence on why not. */
    async change(address: string, earlier: string): Promise<{ glb: ArrayBuffer; frame: Frame } | null> {
      try {
        const [glb, { frame }] = await Promise.all([client.bytes(address), client.scan(earlier)]);
        return { glb, frame };
      } catch (error) {
        store.set((state) => withProblem(state, "stances", messageOf(error)));
        return null;
      }
    },

    /** An empty day is one that is not known. */
    say: (scan: string, day: string, label: string): Promise<void> =>
      (said = said.then(() =>
        forPatient(async (of) => {
          await client.putVisit(scan, day === "" ? null : day, label);
          return read(of);
        }),
      )),
  };
}

export type VisitsActions = ReturnType<typeof visitsActions>;
