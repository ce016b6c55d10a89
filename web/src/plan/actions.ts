// The plan of the patient on the page: read with each scan, written when a line, a pattern or a tumour changes.
import type { Client } from "../api/client";
import type { PlanItem, PlanLesion, Scan, StoredPlan } from "../api/types";
import type { OwnLine } from "../drawing/lines/lines";
import { type DrawingSlice, type PlanStep, stepOf, withStep } from "../drawing/state";
import { drawing as drawingText } from "../drawing/text";
import type { FitSlice } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import { depthOn, drawingOn, lesionsOn, linesOn, noteOn, stepOn, stepTogether, withDepth, withDrawing, withLesions, withLines, withNote, withStepOn } from "./items";
import { createPlanKeeper, type Elsewhere } from "./keeper";

type State = PageSlice & ScanSlice & FitSlice & DrawingSlice;

/** What the plan says about one scan. */
export interface PlannedOnScan {
  readonly lines: readonly OwnLine[];
  /** pattern and tumour, see fit/requestedDrawing.ts */
  readonly drawing: string;
  readonly note: string;
  readonly depthMm: number | null;
  readonly lesions: readonly PlanLesion[];
}

type Shown = Pick<State, "drawing" | "drawn">;

/** What is shown of a scan with what somebody else has planned on it meanwhile, as one step; null where that changes nothing. */
export function withElsewhere(shown: Shown, scan: string, mine: Pick<StoredPlan, "items">, now: readonly PlanItem[]): Shown | null {
  const step = stepOf(shown);
  const { lines, drawing, note, depthMm, lesions } = stepTogether(mine.items, step, now, scan);
  if (lines === step.lines && drawing === step.drawing && note === step.note && depthMm === step.depthMm && lesions === step.lesions) return null;
  return { drawing, drawn: { ...shown.drawn, lines: { ...withStep(shown), present: lines }, note, depthMm, lesions } };
}

export function planActions(store: Store<State>, client: Client) {
  const followers: Elsewhere[] = [];
  const adopted = new WeakMap<readonly OwnLine[], readonly OwnLine[]>(); // the same lines with somebody else's

  const keeper = createPlanKeeper(client, (at, mine, now) => {
    const { scan, drawn } = store.get();
    const shown = scan && link(scan.info) === at ? withElsewhere(store.get(), scan.info.id, mine, now) : null;
    if (shown) {
      adopted.set(drawn.lines.present, shown.drawn.lines.present);
      store.set((state) => ({ ...shown, announcement: drawingText.merged, ...withProblem(state, "drawing", drawingText.merged) }));
    }
    for (const follow of followers) follow(at, mine, now);
  });
  let unsaid: string | null = null; // what saving has complained about last
  let ledTo: { link: string; version: number; text: string } | null = null; // the last step back beyond this page
  const link = (scan: Pick<Scan, "links">): string => scan.links.plan;

  const onScan = (items: readonly PlanItem[], scan: string): PlannedOnScan => ({
    lines: linesOn(items, scan),
    drawing: drawingOn(items, scan),
    note: noteOn(items, scan),
    depthMm: depthOn(items, scan),
    lesions: lesionsOn(items, scan),
  });

  /** As the page shows the scan by now: what somebody else has planned may have come since it was to be saved. */
  const shownOf = (scan: Scan, otherwise: Shown): Shown => (store.get().scan?.info.id === scan.id ? store.get() : otherwise);

  async function change(scan: Scan, what: (items: readonly PlanItem[]) => readonly PlanItem[]): Promise<void> {
    try {
      await keeper.save(link(scan), what);
      store.set((state) => withoutMessage(state, "drawing", unsaid));
    } catch (error) {
      unsaid = messageOf(error);
      store.set((state) => withProblem(state, "drawing", unsaid));
    }
  }

  function saveDrawing(scan: Scan): Promise<void> {
    const asked = store.get();
    return change(scan, (items) => withDrawing(items, scan.id, shownOf(scan, asked).drawing));
  }

  /** A pattern or tumour that a person changes is written at once. */
  store.select(only("scan", "drawing"), ({ scan, drawing }, before) => {
    if (scan && scan.info.id === before.scan?.info.id && drawing !== before.drawing) void saveDrawing(scan.info);
  });

  /** And words and numbers beside it, also when a step back puts them as they were. */
  store.select(only("scan", "drawn"), ({ scan, drawn }, before) => {
    if (!scan || scan.info.id !== before.scan?.info.id) return;
    const asked = store.get();
    const shown = (): Shown["drawn"] => shownOf(scan.info, asked).drawn;
    if (drawn.note !== before.drawn.note) void change(scan.info, (items) => withNote(items, scan.info.id, shown().note));
    if (drawn.depthMm !== before.drawn.depthMm) void change(scan.info, (items) => withDepth(items, scan.info.id, shown().depthMm));
    if (drawn.lesions !== before.drawn.lesions) void change(scan.info, (items) => withLesions(items, scan.info.id, shown().lesions));
  });

  return {
    async read(scan: Scan): Promise<PlannedOnScan> {
      const plan = await keeper.read(link(scan));
      return onScan(plan.items, scan.id);
    },

    /** The scan's lines that are kept now: as the page shows them by then, with those that somebody else has drawn meanwhile. */
    async saveLines(scan: Scan, lines: readonly OwnLine[]): Promise<readonly OwnLine[]> {
      let written = lines;
      await keeper.save(link(scan), (items) => {
        const { id } = store.get().scan?.info ?? {};
        written = id === scan.id ? store.get().drawn.lines.present : lines;
        adopted.delete(written);
        return withLines(items, scan.id, written);
      });
      return adopted.get(written) ?? written;
    },

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
