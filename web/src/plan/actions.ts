// The plan of the patient on the page: read with each scan, written when a line, a pattern or a tumour changes.
import type { Client } from "../api/client";
import type { PlanItem, PlanLesion, Scan, StoredPlan } from "../api/types";
import { type DrawingSlice, type PlanStep, stepOf, withStep } from "../drawing/state";
import { drawing as drawingText } from "../drawing/text";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import type { Outbox } from "../store/outbox";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import { type Contested, contestedOn, stepOn, stepTogether, timesLarger, withStepOn } from "./items";
import { type Both, createPlanKeeper, type Elsewhere } from "./keeper";

type State = PageSlice & ScanSlice & FitSlice & DrawingSlice;

/** What the plan says about one scan. */
export interface PlannedOnScan extends PlanStep {
  readonly contested: Contested | null;
  readonly saving: "saved" | "unsaved";
}

type Shown = Pick<State, "drawing" | "drawn">;

/** What the outbox keeps of a plan that could not be saved: what it said of the scan, and what was made of that. */
interface Waiting {
  readonly link: string;
  readonly base: readonly PlanItem[];
  readonly step: PlanStep;
  readonly scale?: number | undefined; // the scan's size in which they are
}

/** In another size of the scan. */
function inSize(waiting: Waiting, scan: string, scale: number): Waiting {
  const factor = scale / (waiting.scale ?? scale);
  if (factor === 1) return waiting;
  const base = timesLarger(waiting.base, () => factor);
  const step = stepOn(timesLarger(withStepOn(waiting.base, scan, waiting.step), () => factor), scan);
  return { ...waiting, base, step: { ...waiting.step, lines: step.lines, lesions: step.lesions }, scale };
}

/** What is shown of a scan with what somebody else has planned on it meanwhile, as one step; null where that changes nothing. */
export function withElsewhere(shown: Shown, scan: string, mine: Pick<StoredPlan, "items">, now: readonly PlanItem[], both: Both | null = null): Shown | null {
  const before = stepOf(shown);
  const { step } = stepTogether(mine.items, before, now, scan);
  const { lines, drawing, note, depthMm, lesions } = step;
  const here = (items: readonly PlanItem[]): PlanItem[] => items.filter((item) => item.scan === scan);
  const contested = both && contestedOn(here(both.base), here(both.mine), here(both.theirs), scan);
  if (!contested && lines === before.lines && drawing === before.drawing && note === before.note && depthMm === before.depthMm && lesions === before.lesions) return null;
  return { drawing, drawn: { ...shown.drawn, lines: { ...withStep(shown), present: lines }, note, depthMm, lesions, contested: contested ?? shown.drawn.contested } };
}

export function planActions(store: Store<State>, client: Client, outbox: Outbox) {
  const followers: Elsewhere[] = [];
  const savers: ((scan: string) => void)[] = [];

  const sizes = new Map<string, number>(); // in which the page shows scans

  const keeper = createPlanKeeper(client, (at, mine, now, both) => {
    const { scan } = store.get();
    for (const id of outbox.scans("lines")) {
      const waiting = outbox.kept("lines", id) as Waiting | null;
      if (waiting?.link === at && id !== scan?.info.id) outbox.keep("lines", id, patientOf(at), { ...waiting, base: onlyOn(now, id), step: stepTogether(mine.items, waiting.step, now, id).step });
    }
    const shown = scan && link(scan.info) === at ? withElsewhere(store.get(), scan.info.id, mine, now, both) : null;
    if (shown) store.set((state) => ({ ...shown, announcement: drawingText.merged, ...withProblem(state, "drawing", drawingText.merged) }));
    for (const follow of followers) follow(at, mine, now, both);
  }, sizes);
  let unsaid: string | null = null; // what saving has complained about last
  let ledTo: { link: string; version: number; text: string } | null = null; // the last step back beyond this page
  const link = (scan: Pick<Scan, "links">): string => scan.links.plan;
  const patientOf = (plan: string): string => plan.split("/").at(-2) ?? "";
  const onlyOn = (items: readonly PlanItem[], scan: string): PlanItem[] => items.filter((item) => item.scan === scan);
  const isShown = (scan: string): boolean => store.get().scan?.info.id === scan;

  /** As the page shows the scan by now: what somebody else has planned may have come since it was to be saved. */
  const latest = (scan: string): PlanStep | null => (isShown(scan) ? stepOf(store.get()) : ((outbox.kept("lines", scan) as Waiting | null)?.step ?? null));

  /** Keeps what the service does not have, until it has it. */
  function remember(scan: Pick<Scan, "id" | "links">, step: PlanStep): void {
    const seen = keeper.seen(link(scan));
    if (!seen) return;
    const { decided: _, ...rest } = step;
    if (withStepOn(seen.items, scan.id, step) === seen.items) outbox.saved("lines", scan.id);
    else outbox.keep("lines", scan.id, patientOf(link(scan)), { link: link(scan), base: onlyOn(seen.items, scan.id), step: rest, scale: sizes.get(scan.id) } satisfies Waiting);
  }

  const say = (scan: string, part: (state: State) => Partial<State>): void => store.set((state) => (state.scan?.info.id === scan ? part(state) : {}));

  /** All that is planned on the scan, as it is shown by then.  What is shown about saving concerns the scan on the page; another one is saved all the same. */
  async function save(scan: Pick<Scan, "id" | "links">): Promise<void> {
    if (!latest(scan.id)) return; // it is saved
    say(scan.id, ({ drawn }) => ({ drawn: { ...drawn, saving: "saving" } }));
    try {
      await keeper.save(link(scan), (items) => {
        const step = latest(scan.id);
        return step ? withStepOn(items, scan.id, step) : items;
      });
      const step = latest(scan.id);
      if (step) remember(scan, step);
      if (outbox.kept("lines", scan.id)) return;
      say(scan.id, (state) => ({ drawn: { ...state.drawn, saving: "saved" }, ...withoutMessage(state, "drawing", unsaid) }));
      for (const saved of savers) saved(scan.id);
    } catch (error) {
      unsaid = messageOf(error);
      say(scan.id, (state) => ({ drawn: { ...state.drawn, saving: "unsaved" }, ...withProblem(state, "drawing", unsaid) }));
      outbox.failed("lines", scan.id, error);
    }
  }

  /** What a person changes is kept at once and written at once, but for lines: their pen says when it rests.  A scan that is opened with something unsaved is saved. */
  store.select(only("scan", "drawing", "drawn"), ({ scan, drawing, drawn }, before) => {
    if (!scan) return;
    const { info } = scan;
    if (info.id !== before.scan?.info.id) {
      if (outbox.kept("lines", info.id)) queueMicrotask(() => void save(info));
      return;
    }
    const isWritten = drawing !== before.drawing || drawn.note !== before.drawn.note || drawn.depthMm !== before.drawn.depthMm || drawn.lesions !== before.drawn.lesions;
    if (!isWritten && drawn.lines.present === before.drawn.lines.present) return;
    remember(info, stepOf({ drawing, drawn }));
    if (isWritten && outbox.kept("lines", info.id)) queueMicrotask(() => void save(info));
  });

  /** Of a scan that is not on the page, and whose plan may not have been read there. */
  async function saveWaiting(scan: string, { link: plan, base, step, scale }: Waiting): Promise<void> {
    if (scale !== undefined && !sizes.has(scan)) sizes.set(scan, scale);
    try {
      const { items } = keeper.seen(plan) ?? (await keeper.read(plan));
      outbox.keep("lines", scan, patientOf(plan), { link: plan, base: onlyOn(items, scan), step: stepTogether(base, step, items, scan).step, scale } satisfies Waiting);
    } catch (error) {
      outbox.failed("lines", scan, error);
      return;
    }
    await save({ id: scan, links: { plan } as Scan["links"] });
  }

  return {
    /** With what could not be saved of it before. */
    async read(scan: Scan): Promise<PlannedOnScan> {
      const scale = scan.scale?.factor ?? 1;
      sizes.set(scan.id, scale);
      const { items } = await keeper.read(link(scan));
      const kept = outbox.kept("lines", scan.id) as Waiting | null;
      const waiting = kept && inSize(kept, scan.id, scale);
      if (!waiting) return { ...stepOn(items, scan.id), contested: null, saving: "saved" };
      const { step, contested } = stepTogether(waiting.base, waiting.step, items, scan.id);
      remember(scan, step);
      return { ...step, contested, saving: outbox.kept("lines", scan.id) ? "unsaved" : "saved" };
    },

    save,

    /** Tries again to save what waits, of every scan. */
    async retry(): Promise<void> {
      const { scan } = store.get();
      for (const id of outbox.scans("lines")) {
        const waiting = outbox.kept("lines", id) as Waiting | null;
        if (scan?.info.id === id) await save(scan.info);
        else if (waiting) await saveWaiting(id, waiting);
      }
    },

    /** Called when what waited of a scan is saved. */
    followSaved: (saved: (scan: string) => void): void => void savers.push(saved),

    /** Called when somebody else was found to have changed a plan, for scans that are shown beside the page's own. */
    followElsewhere: (follow: Elsewhere): void => void followers.push(follow),

    /** What the plan said about the scan before, as far back as the service remembers; null when there is nothing earlier. */
    async earlier(scan: Scan, now: PlanStep): Promise<PlanStep | null> {
      await keeper.settled();
      const kept = keeper.seen(link(scan)) ?? (await keeper.read(link(scan)));
      const asText = (items: readonly PlanItem[]): string => JSON.stringify(stepOn(items, scan.id));
      const wanted = asText(withStepOn(kept.items, scan.id, now));
      // Going back is written as a version of its own: the next step back goes on from where the last one led.
      const from = ledTo?.link === link(scan) && ledTo.text === wanted ? ledTo.version : kept.version;
      const plan = await keeper.earlier(link(scan), from, ({ items, whole }) => whole && asText(items) !== wanted);
      if (!plan?.whole) return null;
      ledTo = { link: link(scan), version: plan.version, text: asText(plan.items) };
      return stepOn(plan.items, scan.id);
    },

    /** Asks whether somebody else has written the plan since it was read here. */
    async look(): Promise<void> {
      const { scan } = store.get();
      if (!scan) return;
      const isNewer = await keeper.isChangedElsewhere(link(scan.info)).catch(() => false); // the next write will say what is wrong
      store.set((state) => (state.scan?.info.id === scan.info.id && state.drawn.isChangedElsewhere !== isNewer ? { drawn: { ...state.drawn, isChangedElsewhere: isNewer } } : {}));
    },

    /** The plan as it is kept now, what was changed here with it.  What was there before is one step back. */
    async takeOver(): Promise<void> {
      const { scan } = store.get();
      if (!scan) return;
      try {
        await keeper.settled();
        await keeper.read(link(scan.info));
        const asked = (state: State): Partial<State> => ({ drawn: { ...state.drawn, open: null, chosen: null, corner: null, isChangedElsewhere: false }, ...withoutMessage(state, "drawing", drawingText.merged) });
        store.set((state) => (state.scan?.info.id === scan.info.id ? asked(state) : {}));
      } catch (error) {
        store.set((state) => withProblem(state, "drawing", messageOf(error)));
      }
    },

    /** Whether anything of the plan is to be laid on a scan besides the pen's lines, which are there already. */
    isMoreThanLines(scan: Scan, isOtherFitted: boolean): boolean {
      const items = keeper.seen(link(scan))?.items ?? [];
      return items.some((item) => (item.scan === scan.id ? item.kind !== "line" : isOtherFitted));
    },

    /** The pattern, tumour and depth of the other tab, as one step; or those of this page, as they are. */
    settle(isTheirs: boolean): void {
      const { contested } = store.get().drawn;
      if (!contested) return;
      const { drawing, depthMm } = contested;
      store.set((state) => ({ ...(isTheirs ? { drawing } : {}), drawn: { ...state.drawn, contested: null, ...(isTheirs ? { lines: withStep(state), depthMm } : {}) } }));
    },

    note(text: string): void {
      const { scan, drawn } = store.get();
      if (!scan || text.trim() === drawn.note) return;
      store.set((state) => ({ drawn: { ...state.drawn, lines: withStep(state), note: text.trim() } }));
    },

    depth(mm: number | null): void {
      const { scan } = store.get();
      if (!scan || mm === store.get().drawn.depthMm) return;
      store.set((state) => ({ drawn: { ...state.drawn, lines: withStep(state), depthMm: mm } }));
    },

    lesions(lesions: readonly PlanLesion[]): void {
      const { scan } = store.get();
      if (!scan) return;
      store.set((state) => ({ drawn: { ...state.drawn, lines: withStep(state), lesions: lesions.map((each) => ({ ...each, scan: scan.info.id })) } }));
    },

    settled: keeper.settled,
  };
}

export type PlanActions = ReturnType<typeof planActions>;
