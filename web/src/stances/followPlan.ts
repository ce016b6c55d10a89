// The whole plan on both scans, as it is now: what was made on one is carried to the other, both ways, soon after each change.
import type { Client } from "../api/client";
import { laidOnScan, type OnScan } from "../drawing/state";
import type { PlanActions } from "../plan/actions";
import { only, type Store } from "../store/store";
import { type AskedPair, isPredicted, isSamePair, type PatientScan, stanceNames, type StancesSlice, type Workspace, workspaceOf } from "./state";

export const CALM_MS = 300; // after the last stroke

type State = Workspace & StancesSlice;

interface Others {
  readonly plan: Pick<PlanActions, "isMoreThanLines" | "settled">;
  /** Lines that were drawn just now are on their way to the plan. */
  flush(): Promise<void>;
  fail(error: unknown): void;
}

/** What decides how the plan lies on a scan. */
export const keyOf = (to: Workspace, from: Workspace | null, { scan, stances }: Pick<State, "scan" | "stances">): readonly unknown[] => [
  furtherOf({ scan, stances }).filter(isFitted).map(({ fit }) => fit!.id).join(),
  stances.answers,
  to.fit?.id,
  from?.fit?.state === "done" ? from.fit.id : null,
  to.drawn.lines.present,
  to.drawn.lesions,
  to.drawing,
  from?.drawn.lines.present,
  from?.drawn.lesions,
  from?.drawing,
];

/** What was planned on a scan that is not on the page is carried as well. */
const furtherOf = ({ scan, stances }: Pick<State, "scan" | "stances">): readonly PatientScan[] => stances.scans.filter(({ id }) => id !== scan?.info.id && id !== stances.other?.scan?.info.id);
const isFitted = ({ fit }: PatientScan): boolean => fit?.state === "done";

export function followPlan<Whole extends State>(store: Store<Whole>, client: Pick<Client, "planOnFit">, others: Others): void {
  const asked = new Map<string, readonly unknown[]>(); // fit -> what it was last asked for; a failure is not tried again unchanged
  let calm: ReturnType<typeof setTimeout> | undefined;
  let isBusy = false;

  const set = (change: (state: State) => Partial<State>): void => store.set((state) => change(state) as Partial<Whole>);
  const pairs = (state: State): [Workspace, Workspace | null, string][] => {
    const mine = workspaceOf(state);
    const { other } = state.stances;
    const [myName, itsName] = stanceNames(state);
    return other ? [[mine, other, itsName], [other, mine, myName]] : [[mine, null, itsName]];
  };

  function isOld(to: Workspace, from: Workspace | null): boolean {
    if (!to.scan || to.fit?.state !== "done") return false;
    const before = asked.get(to.fit.id);
    return before === undefined || keyOf(to, from, store.get()).some((each, i) => each !== before[i]);
  }

  async function lay(to: Workspace, from: Workspace | null, name: string): Promise<void> {
    const { scan, fit } = to;
    if (!scan || !fit) return;
    const key = keyOf(to, from, store.get());
    asked.set(fit.id, key);
    const isBeside = from?.fit?.state === "done" || furtherOf(store.get()).some(isFitted);
    const isNeeded = isPredicted(to) || others.plan.isMoreThanLines(scan.info, isBeside);
    const plan = isNeeded || isBeside ? await client.planOnFit(fit.links.plan) : null; // with nothing planned too: whether both are of one patient
    const questions = plan?.asked?.map(({ scan: other, says }) => ({ scan: scan.info.id, other, says })) ?? [];
    set((state) => {
      const { stances, ...part } = placed(state, scan.info.id, fit.id, isNeeded && plan ? laidOnScan(name, key, plan) : null);
      const before = stances ?? state.stances;
      const isLeft = (each: AskedPair): boolean => before.unanswered.some((left) => isSamePair(each, left));
      const others = (all: readonly AskedPair[]): AskedPair[] => all.filter((each) => each.scan !== scan.info.id);
      const asked = [...others(before.asked), ...questions.filter((each) => !isLeft(each))];
      return { ...part, stances: { ...before, asked, unanswered: [...others(before.unanswered), ...questions.filter(isLeft)] } };
    });
  }

  async function layAll(): Promise<void> {
    if (isBusy) return;
    isBusy = true;
    set((state) => ({ stances: { ...state.stances, isCarrying: true } }));
    try {
      await others.flush();
      await others.plan.settled();
      for (const [to, from, name] of pairs(store.get())) if (isOld(to, from)) await lay(to, from, furtherOf(store.get()).length > 0 ? "" : name);
    } catch (error) {
      others.fail(error);
    } finally {
      isBusy = false;
      set((state) => ({ stances: { ...state.stances, isCarrying: false } })); // and what changed meanwhile is seen
    }
  }

  store.select(only("scan", "stances", "drawn", "drawing", "fit"), () => {
    if (isBusy || !pairs(store.get()).some(([to, from]) => isOld(to, from))) return;
    clearTimeout(calm);
    calm = setTimeout(() => void layAll(), CALM_MS);
  });
}

/** The scan is on the page, or waits beside it, still with that fit. */
function placed(state: State, scan: string, fit: string, onScan: OnScan | null): Partial<State> {
  if (state.scan?.info.id === scan && state.fit?.id === fit) return { drawn: { ...state.drawn, onScan } };
  const { other } = state.stances;
  if (other?.scan?.info.id !== scan || other.fit?.id !== fit) return {};
  return { stances: { ...state.stances, other: { ...other, drawn: { ...other.drawn, onScan } } } };
}
