// The plan of the patient on the page: read with each scan, written when a line, a pattern or a tumour changes.
import type { Client } from "../api/client";
import type { PlanItem, Scan } from "../api/types";
import type { OwnLine } from "../drawing/lines/lines";
import { type DrawingSlice, type PlanStep, withStep } from "../drawing/state";
import { type FitSlice, initialFit } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import { depthOn, drawingOn, linesOn, noteOn, stepOn, withDepth, withDrawing, withLines, withNote, withStepOn } from "./items";
import { createPlanKeeper } from "./keeper";

type State = PageSlice & ScanSlice & FitSlice & DrawingSlice;

/** What the plan says about one scan. */
export interface PlannedOnScan {
  readonly lines: readonly OwnLine[];
  /** that its next fit brings along, see fit/requestedDrawing.ts */
  readonly drawing: string;
  /** Somebody has planned something; else the drawing is the reference that a first fit brings along. */
  readonly isWhole: boolean;
  readonly note: string;
  readonly depthMm: number | null;
}

export function planActions(store: Store<State>, client: Client) {
  const keeper = createPlanKeeper(client);
  let unsaid: string | null = null; // what saving has complained about last
  let ledTo: { link: string; version: number; text: string } | null = null; // the last step back beyond this page
  const link = (scan: Pick<Scan, "links">): string => scan.links.plan;

  /** Before anybody has planned anything a fit brings the reference drawing along. */
  const onScan = (items: readonly PlanItem[], isWhole: boolean, scan: string): PlannedOnScan => ({
    lines: linesOn(items, scan),
    drawing: isWhole ? drawingOn(items, scan) : referenceOf(store.get().meta?.drawings ?? []),
    isWhole,
    note: noteOn(items, scan),
    depthMm: depthOn(items, scan),
  });

  async function change(scan: Scan, what: (items: readonly PlanItem[]) => PlanItem[]): Promise<void> {
    try {
      await keeper.save(link(scan), what);
      store.set((state) => withoutMessage(state, "drawing", unsaid));
    } catch (error) {
      unsaid = messageOf(error);
      store.set((state) => withProblem(state, "drawing", unsaid));
    }
  }

  const saveDrawing = (scan: Scan, drawing: string): Promise<void> => change(scan, (items) => withDrawing(items, scan.id, drawing));

  /** A pattern or tumour that a person changes is written at once. */
  store.select(only("scan", "drawing"), ({ scan, drawing }, before) => {
    if (scan && scan.info.id === before.scan?.info.id && drawing !== before.drawing) void saveDrawing(scan.info, drawing);
  });

  /** And words and numbers beside it, also when a step back puts them as they were. */
  store.select(only("scan", "drawn"), ({ scan, drawn }, before) => {
    if (!scan || scan.info.id !== before.scan?.info.id) return;
    if (drawn.note !== before.drawn.note) void change(scan.info, (items) => withNote(items, scan.info.id, drawn.note));
    if (drawn.depthMm !== before.drawn.depthMm) void change(scan.info, (items) => withDepth(items, scan.info.id, drawn.depthMm));
  });

  /** The first fit decides that its drawing is the plan: from then on the plan speaks for all scans. */
  store.select(only("fit"), ({ fit }, before) => {
    const { scan, drawing } = store.get();
    if (!scan || fit?.state !== "running" || fit.id === before.fit?.id) return;
    if (keeper.seen(link(scan.info))?.whole === false) void saveDrawing(scan.info, drawing);
  });

  return {
    async read(scan: Scan): Promise<PlannedOnScan> {
      const plan = await keeper.read(link(scan));
      return onScan(plan.items, plan.whole, scan.id);
    },

    /** The scan's lines as they are kept now: with those that somebody else has drawn meanwhile. */
    async saveLines(scan: Scan, lines: readonly OwnLine[]): Promise<{ lines: readonly OwnLine[]; isMerged: boolean }> {
      const kept = await keeper.save(link(scan), (items) => withLines(items, scan.id, lines));
      return kept.isMerged ? { lines: linesOn(kept.items, scan.id), isMerged: true } : { lines, isMerged: false };
    },

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
        const { items } = await keeper.read(link(scan.info));
        store.set((state) => {
          if (state.scan?.info.id !== scan.info.id) return {};
          const { lines, drawing, note, depthMm } = stepOn(items, scan.info.id);
          return { drawing, drawn: { ...state.drawn, lines: { ...withStep(state), present: lines }, note, depthMm, open: null, chosen: null, corner: null, isChangedElsewhere: false } };
        });
      } catch (error) {
        store.set((state) => withProblem(state, "drawing", messageOf(error)));
      }
    },

    /** Whether more of the plan belongs to a scan, or to others of the patient, than its fit has brought along. */
    isMoreThan(scan: Scan, drawingOfFit: string | null, isOtherFitted: boolean): boolean {
      const items = keeper.seen(link(scan))?.items ?? [];
      const beyondLines = items.filter((item) => item.scan === scan.id && item.kind !== "line");
      const asked = withDrawing([], scan.id, drawingOfFit ?? "");
      const isAsked = drawingOn(items, scan.id) === (drawingOfFit ?? "") && beyondLines.length === asked.length;
      return !isAsked || (isOtherFitted && items.some((item) => item.scan !== scan.id));
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

    settled: keeper.settled,
  };
}

/** The reference drawing that a first fit brings along, where the model has it. */
export const referenceOf = (drawings: readonly { readonly name: string }[]): string =>
  drawings.length === 0 || drawings.some(({ name }) => name === initialFit.drawing) ? initialFit.drawing : drawings[0]!.name;

export type PlanActions = ReturnType<typeof planActions>;
