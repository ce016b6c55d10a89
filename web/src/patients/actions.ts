// The list of patients: read page by page, searched, renamed; a deletion is sent ten seconds late, or when the page is left.
import { ApiError, type Client } from "../api/client";
import type { Patient } from "../api/types";
import type { PageSlice } from "../store/page";
import type { ScanSlice } from "../scan/state";
import type { Outbox } from "../store/outbox";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { type Order, type PatientsSlice, type PatientsState, sureness } from "./state";
import * as text from "./text";

const UNDO_MS = 10_000;
const MOST = 12; // cards, two screens of them, whose points to check are counted: each is a question of its own
const PAUSE_MS = 250; // while somebody types

type State = PageSlice & PatientsSlice & Pick<ScanSlice, "scan">;

export function patientActions(store: Store<State>, client: Pick<Client, "patients" | "renamePatient" | "giveToGroup" | "deletePatient" | "checksOf">, outbox: Outbox) {
  const going = new Map<string, ReturnType<typeof setTimeout>>();
  let typing: ReturnType<typeof setTimeout> | undefined;
  let asked = 0; // the list asked for last wins

  const put = (part: Partial<PatientsState>, more: Partial<State> = {}): void => store.set((state) => ({ ...more, patients: { ...state.patients, ...part } }));
  const fail = (error: unknown): void => store.set((state) => withProblem(state, "page", messageOf(error)));
  const nameOf = (id: string): string => store.get().patients.rows.find((row) => row.id === id)?.code ?? "";

  async function read(address: string | null): Promise<void> {
    const mine = ++asked;
    put({ isBusy: true });
    try {
      const page = await client.patients(address, store.get().patients.search, store.get().patients.order);
      if (mine !== asked) return;
      put({ rows: address === null ? page.patients : [...store.get().patients.rows, ...page.patients], next: page.next, isBusy: false, isKnown: true });
      void count(mine);
    } catch (error) {
      if (mine !== asked) return;
      put({ isBusy: false });
      if (!(error instanceof ApiError && error.status === 0)) fail(error); // that the service does not answer stands there already
    }
  }

  /** How many points the fits that are to be checked have, one after the other, while this list is shown. */
  async function count(mine: number): Promise<void> {
    const fits = store.get().patients.rows.flatMap((row) => sureness(row).fit ?? []).slice(0, MOST);
    for (const fit of fits.filter((each) => !(each in store.get().patients.points))) {
      if (store.get().scan !== null) return;
      const found = await client.checksOf(fit).catch(() => null); // without an answer no number is said
      if (mine !== asked) return;
      if (found) put({ points: { ...store.get().patients.points, [fit]: found.worth_it ? found.checks.length : 0 } });
    }
  }

  async function changed(id: string, patient: Promise<Patient>): Promise<void> {
    try {
      const now = await patient;
      store.set(({ patients }) => ({ patients: { ...patients, rows: patients.rows.map((row) => (row.id === id ? now : row)) } }));
    } catch (error) {
      fail(error);
    }
  }

  async function send(id: string): Promise<void> {
    const code = nameOf(id);
    clearTimeout(going.get(id));
    if (!going.delete(id)) return;
    outbox.forget((_scan, patient) => patient === id);
    try {
      await client.deletePatient(id);
      store.set(({ patients }) => ({
        patients: { ...patients, rows: patients.rows.filter((row) => row.id !== id), going: patients.going.filter((each) => each !== id) },
        announcement: text.home.announceGone(code),
      }));
    } catch (error) {
      put({ going: store.get().patients.going.filter((each) => each !== id) });
      fail(error);
    }
  }

  if (typeof addEventListener === "function") addEventListener("pagehide", () => [...going.keys()].forEach((id) => void send(id)));

  return {
    /** As the service has it now. */
    read: (): Promise<void> => read(null),
    more: (): Promise<void> => read(store.get().patients.next),

    search(search: string): void {
      put({ search });
      clearTimeout(typing);
      typing = setTimeout(() => void read(null), PAUSE_MS);
    },

    async order(order: Order): Promise<void> {
      put({ order });
      await read(null);
    },

    rename: (id: string, code: string): Promise<void> => changed(id, client.renamePatient(id, code)),
    give: (id: string, group: string): Promise<void> => changed(id, client.giveToGroup(id, group === "" ? null : group)),
    /** The group that new patients belong to from now on. */
    chooseGroup: (group: string): void => store.set((state) => ({ group, ...withoutMessage(state, "scan", text.home.groupMissing) })),

    remove(id: string): void {
      put({ going: [...store.get().patients.going, id] }, { announcement: text.home.going(nameOf(id)) });
      going.set(id, setTimeout(() => void send(id), UNDO_MS));
    },

    undo(id: string): void {
      clearTimeout(going.get(id));
      going.delete(id);
      put({ going: store.get().patients.going.filter((each) => each !== id) });
    },

  };
}

export type PatientActions = ReturnType<typeof patientActions>;
