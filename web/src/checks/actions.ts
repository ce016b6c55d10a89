// The tour: begun, answered point by point, left; its answers become landmarks in one step, and the fit that knows them is made at once.
import type { Client } from "../api/client";
import { ApiError } from "../api/client";
import type { Checks, Stance, Vector } from "../api/types";
import { saidWide } from "../fit/fingers";
import type { Follower } from "../fit/playback/follower";
import type { FitActions } from "../fit/actions";
import { linesOn } from "../fit/verdict";
import type { LandmarkActions } from "../landmarks/actions";
import { CALM_MS, keyOf } from "../stances/followPlan";
import { scannedOther, type StancesSlice, type Workspace } from "../stances/state";
import type { PageSlice } from "../store/page";
import { only, type Store } from "../store/store";
import { type ChecksSlice, type ChecksState, outcomeWords, stepNow, stepsOf, type Tour } from "./state";
import * as text from "./text";

const words = text.checks;

type State = PageSlice & Workspace & StancesSlice & ChecksSlice & Pick<FitStarting, "isStarting">;
interface FitStarting {
  readonly isStarting: boolean;
}

interface Others {
  readonly landmarks: Pick<LandmarkActions, "check" | "keep" | "takeOut" | "exchange">;
  readonly fit: Pick<FitActions, "chooseStance">;
  readonly follower: Follower;
  /** The service has all that is planned. */
  readonly saved: () => Promise<unknown>;
}

export function checkActions<Whole extends State>(store: Store<Whole>, client: Pick<Client, "checks">, { landmarks, fit, follower, saved }: Others) {
  const set = (change: (state: State) => Partial<State>): void => store.set((state) => change(state) as Partial<Whole>);
  const put = (part: Partial<ChecksState>, announcement?: string): void => set(({ checks }) => ({ checks: { ...checks, ...part }, ...(announcement === undefined ? {} : { announcement }) }));
  const asked = new Map<string, readonly unknown[]>(); // fit -> the plan on it that was asked about last
  const asking = new Map<string, Promise<void>>(); // fit -> until the answer about that plan is here

  /** After each fit and each change of the plan, of both scans that are on the page. */
  store.select(only("scan", "fit", "drawn", "drawing", "stances"), () => {
    const state: State = store.get();
    const other = scannedOther(state.stances);
    for (const [each, beside] of [[state, other], [other, state]] as const) {
      if (each?.fit?.state !== "done") continue;
      const { fit } = each;
      const [key, before] = [keyOf(each, beside, state), asked.get(fit.id)];
      if (before && key.every((part, i) => part === before[i])) continue;
      asked.set(fit.id, key);
      asking.set(fit.id, ask(fit.id, fit.links.checks, key, before !== undefined));
    }
  });

  /** About a plan that has changed when the service has it. */
  async function ask(id: string, link: string, key: readonly unknown[], isChanged: boolean): Promise<void> {
    await Promise.resolve(); // a listener never sets
    let found: Checks | null | undefined;
    try {
      if (isChanged) {
        set(({ checks }) => ({ checks: { ...checks, awaited: new Set([...checks.awaited, id]) } }));
        await new Promise((rest) => setTimeout(rest, CALM_MS));
        if (asked.get(id) !== key) return;
        await saved();
      }
      if (asked.get(id) === key) found = await client.checks(link);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error; // without an answer nothing is offered; the next change asks again
      if (asked.get(id) === key) asked.delete(id);
      found = store.get().checks.of[id] ?? null;
    }
    if (found === undefined || (asked.has(id) && asked.get(id) !== key)) return; // the plan has changed again
    asking.delete(id);
    set(({ checks }) => ({ checks: { ...checks, of: { ...checks.of, [id]: found }, awaited: new Set([...checks.awaited].filter((each) => each !== id)) } }));
  }

  function over(outcome: ChecksState["outcome"], announcement: string): void {
    const wasComparing = store.get().checks.tour?.wasComparing ?? false;
    put({ tour: null, outcome }, announcement);
    if (wasComparing) set(({ stances }) => ({ stances: { ...stances, isComparing: true } }));
  }

  function say(tour: Tour): string {
    const step = tour.steps[tour.at];
    if (step?.kind !== "point") return step?.kind === "stance" ? words.stance : "";
    const { check } = step;
    return words.announce(tour.at + 1, tour.steps.length, check.label, words.ask, saidWide(step.before), saidWide(check.line_error_mm));
  }

  function begin(): void {
    const state = store.get();
    const waiting = asking.get(state.fit?.id ?? "");
    if (waiting) return void waiting.then(begin); // the plan has just changed: the points are those of the lines that are seen
    const steps = stepsOf(state);
    if (steps.length === 0 || !state.fit) return;
    const tour: Tour = { fit: state.fit.id, steps, at: 0, answers: {}, moved: null, before: linesOn(state)?.mm ?? null, leadsToFit: false, wasComparing: state.stances.isComparing };
    set(({ stances }) => ({ stances: { ...stances, isComparing: false } })); // one body, seen from near
    put({ tour, outcome: null }, say(tour));
    follower.begin();
  }

  const given = ({ answers }: Tour): Record<string, Vector> => Object.fromEntries(Object.entries(answers).flatMap(([name, at]) => (at ? [[name, at]] : [])));

  function answer(at: Vector | null): void {
    const { tour } = store.get().checks;
    const step = stepNow(store.get());
    if (!tour || step?.kind !== "point") return;
    goOn({ ...tour, answers: { ...tour.answers, [step.check.name]: at }, leadsToFit: tour.leadsToFit || at !== null });
  }

  function goOn(tour: Tour): void {
    const next: Tour = { ...tour, at: tour.at + 1, moved: null };
    if (next.at < next.steps.length) put({ tour: next }, say(next));
    else finish(next);
  }

  /** What was answered is kept, also by who leaves. */
  function finish(tour: Tour): void {
    const places = given(tour);
    const count = Object.keys(places).length;
    if (!tour.leadsToFit) {
      follower.giveUp();
      return over(null, words.nothing);
    }
    put({ tour: { ...tour, at: tour.steps.length, moved: null } });
    if (count > 0) landmarks.check(places, words.fitting(count));
  }

  /** The fit that knows the answers is there, and the plan lies on it; or there will be none, and the page says why. */
  function end(): void {
    const state: State = store.get();
    const { checks: { tour }, fit, drawn, isStarting } = state;
    if (!tour || tour.at < tour.steps.length || isStarting || fit?.state === "running") return;
    const isNew = fit?.state === "done" && fit.id !== tour.fit;
    if (isNew ? drawn.onScan !== null && !drawn.onScan.key.includes(fit.id) : state.problems.fit === undefined) return;
    const outcome = isNew ? { fit: fit.id, from: tour.before, to: linesOn(state)?.mm ?? null } : null;
    over(outcome, outcome ? outcomeWords(outcome) : "");
  }
  store.select(only("fit", "drawn", "isStarting", "checks", "problems"), ({ checks: { tour } }) => tour && queueMicrotask(end)); // a listener never sets

  return {
    begin,
    /** It is where the dot is. */
    yes(): void {
      const { tour } = store.get().checks;
      const step = stepNow(store.get());
      if (tour && step?.kind === "point") answer(tour.moved ?? step.check.place);
    },
    unseen: (): void => answer(null),
    move(at: Vector): void {
      const { tour } = store.get().checks;
      const step = stepNow(store.get());
      if (!tour || step?.kind !== "point") return;
      const from = tour.moved ?? step.check.place;
      put({ tour: { ...tour, moved: at } }, words.announceMoved(Math.hypot(...at.map((value, axis) => value - from[axis]!))));
      follower.move({ ...given(tour), [step.check.name]: at });
    },
    keep: (names: readonly string[]): void => on(() => landmarks.keep(names)),
    takeOut: (name: string): void => on(() => landmarks.takeOut(name)),
    exchange: (names: readonly string[]): void => on(() => landmarks.exchange(names)),
    stance: (stance: Stance): void => on(() => fit.chooseStance(stance)),
    leave(): void {
      const { tour } = store.get().checks;
      if (!tour) return;
      if (tour.at < tour.steps.length && Object.keys(given(tour)).length > 0) return finish(tour);
      follower.giveUp();
      over(null, "");
    },
  };

  /** A question is answered by itself: then what comes next. */
  function on(answerIt: () => void): void {
    answerIt();
    const { tour } = store.get().checks;
    if (tour) goOn({ ...tour, leadsToFit: true });
  }
}

export type CheckActions = ReturnType<typeof checkActions>;
