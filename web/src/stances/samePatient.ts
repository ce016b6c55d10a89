// What comes of the answer to whether two scans are of one patient: the service remembers it, or files the second by itself.
import type { Client } from "../api/client";
import type { FitSlice } from "../fit/state";
import type { PlanActions } from "../plan/actions";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import type { Store } from "../store/store";
import { type AskedPair, isSamePair, stanceNames, type StancesSlice, type Workspace } from "./state";
import { samePatient as words } from "./samePatientText";

type Shown = Pick<ScanSlice & FitSlice & StancesSlice, "scan" | "stance" | "fit" | "stances">;
type State = PageSlice & Workspace & StancesSlice;

interface Others {
  fail(error: unknown): void;
  swap(): Promise<void>;
  remove(): void;
  forget(scan: string): void;
  readonly read: PlanActions["read"];
}

/** Of a pair the scan that came second to the page: the one that may be another patient's. */
export function secondOf({ scan, stances }: Shown, { scan: first, other }: AskedPair): string {
  const [mine, its] = [scan?.info.id, stances.other?.scan?.info.id];
  const further = [first, other].find((each) => each !== mine && each !== its);
  return further ?? (first === (stances.isSecond ? mine : its) ? first : other);
}

/** As the page calls it. */
export function nameOfSecond(state: Shown, second: string): string {
  const [mine, its] = stanceNames(state);
  if (second === state.scan?.info.id) return mine;
  return second === state.stances.other?.scan?.info.id ? its : words.further;
}

export async function answerSamePatient<Whole extends State>(store: Store<Whole>, client: Pick<Client, "moveScan">, others: Others, isSame: boolean): Promise<void> {
  const state: State = store.get();
  const [asked] = state.stances.asked;
  const { scan } = state;
  if (!asked || !scan) return;
  const set = (change: (now: State) => Partial<State>): void => store.set((now) => change(now) as Partial<Whole>);
  const isIt = (each: AskedPair): boolean => (isSame ? isSamePair(asked, each) : [each.scan, each.other].includes(second));
  const second = secondOf(state, asked);
  const name = nameOfSecond(state, second);
  try {
    const filed = await client.moveScan(isSame ? asked.scan : second, isSame ? scan.info.patient : null, isSame ? [asked.other] : []);
    if (!isSame) {
      if (store.get().scan?.info.id === second) await others.swap();
      if (store.get().stances.other?.scan?.info.id === second) others.remove();
      others.forget(second);
      const left = store.get().scan?.info;
      if (left) await others.read(left); // without what was planned on the other one
    }
    set(({ stances }) => ({ stances: { ...stances, asked: stances.asked.filter((each) => !isIt(each)), answers: stances.answers + 1 }, ...(isSame ? {} : { announcement: words.announce(name, filed.code) }) }));
  } catch (error) {
    others.fail(error);
  }
}
