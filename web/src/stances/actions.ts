// The second stance: bring it, change over, compare, carry drawings across, measure both.
import type { Client } from "../api/client";
import type { Frame } from "../api/types";
import { toDrawing } from "../drawing/files";
import type { Carried } from "../drawing/state";
import type { FitActions } from "../fit/actions";
import type { FitSlice } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import type { ScanActions } from "../scan/actions";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import type { ViewSlice } from "../viewer/state";
import { loadFit, loadWorkspace } from "./load";
import { initialStances, isUnfinished, knownScans, measuredFits, rememberScan, stanceNames, stanceOf, type StancesSlice, type StancesState, type Workspace, workspaceOf } from "./state";
import * as text from "./text";

const WATCH_MS = 1000; // a fit that goes on while its scan waits is looked after so often
const CALM_MS = 700; // after the last stroke the carried lines follow

type State = PageSlice & ViewSlice & Workspace & LandmarksSlice & FitSlice & StancesSlice;

/** What of the page's other actions a second stance needs. */
interface Others {
  readonly scan: Pick<ScanActions, "upload" | "takeExample" | "open">;
  readonly fit: Pick<FitActions, "stop" | "open">;
  readonly landmarks: { flush(): Promise<void> };
  readonly drawing: { flush(): Promise<void> };
}

export function stancesActions(store: Store<State>, client: Client, others: Others, memory: Storage | null) {
  let watch: ReturnType<typeof setTimeout> | undefined;
  let calm: ReturnType<typeof setTimeout> | undefined;

  const put = (part: Partial<StancesState>, more: Partial<State> = {}): void => store.set((state) => ({ ...more, stances: { ...state.stances, ...part } }));
  const fail = (error: unknown): void => store.set((state) => withProblem(state, "stances", messageOf(error)));
  const flush = (): Promise<unknown> => Promise.all([others.landmarks.flush(), others.drawing.flush()]);

  /** Changes the stance that waits, when it still is this one. */
  function change(scan: string, part: (workspace: Workspace) => Partial<Workspace>): void {
    store.set((state) => {
      const { other } = state.stances;
      return other?.scan?.info.id === scan ? { stances: { ...state.stances, other: { ...other, ...part(other) } } } : {};
    });
  }

  /** The waiting stance's fit comes to its end, although nobody listens to its events. */
  function lookAfter(): void {
    clearTimeout(watch);
    const { other } = store.get().stances;
    const { scan, fit } = other ?? {};
    if (!scan || !fit || !isUnfinished(fit)) return;
    watch = setTimeout(() => {
      void client
        .fit(fit.id)
        .then(async ({ state }) => {
          if (state === "queued" || state === "running") return;
          const loaded = await loadFit(client, fit.id, fit.picks, fit.certain);
          change(scan.info.id, (workspace) => (workspace.fit?.id === fit.id ? { fit: loaded } : {}));
        }, fail)
        .finally(lookAfter);
    }, WATCH_MS);
  }

  /** The drawing of one, on the scan of the other. */
  async function carried(from: Workspace, to: Workspace, name: string): Promise<Carried | null> {
    const source = from.drawn.lines.present;
    if (from.fit?.state !== "done" || to.fit?.state !== "done" || source.length === 0) return null;
    const drawing = await client.transfer({ from_fit: from.fit.id, to_fit: to.fit.id, drawing: toDrawing(source) });
    return { from: name, fromFit: from.fit.id, toFit: to.fit.id, source, drawing };
  }

  const isOld = (from: Workspace, to: Workspace): boolean =>
    to.drawn.carried === null
      ? from.drawn.lines.present.length > 0
      : to.drawn.carried.source !== from.drawn.lines.present || to.drawn.carried.fromFit !== from.fit?.id || to.drawn.carried.toFit !== to.fit?.id;

  async function carry(): Promise<void> {
    const state = store.get();
    const { other, isCarrying } = state.stances;
    if (!other || isCarrying || state.fit?.state !== "done" || other.fit?.state !== "done") return;
    const mine = workspaceOf(state);
    const [myName, itsName] = stanceNames(state);
    put({ isCarrying: true, wantsCarried: true }, withProblem(state, "stances", null));
    try {
      const [there, here] = await Promise.all([
        isOld(mine, other) ? carried(mine, other, myName) : other.drawn.carried,
        isOld(other, mine) ? carried(other, mine, itsName) : mine.drawn.carried,
      ]);
      const place = (scan: string | undefined, layer: Carried | null) => (now: Workspace): Workspace => (now.scan?.info.id === scan ? { ...now, drawn: { ...now.drawn, carried: layer } } : now);
      store.set((now) => {
        const put = (workspace: Workspace): Workspace => place(mine.scan?.info.id, here)(place(other.scan?.info.id, there)(workspace));
        const { drawn } = put(workspaceOf(now));
        const waiting = now.stances.other && put(now.stances.other);
        return { drawn: { ...now.drawn, carried: drawn.carried }, stances: { ...now.stances, other: waiting, isCarrying: false }, announcement: text.stances.announceCarried(itsName) };
      });
    } catch (error) {
      put({ isCarrying: false, wantsCarried: false });
      fail(error);
    }
  }

  /** Lines that were shown on the other scan once follow what is drawn. */
  store.select(only("stances", "drawn", "fit"), ({ stances }) => {
    const { other, wantsCarried, isCarrying } = stances;
    if (!other || !wantsCarried || isCarrying) return;
    const mine = workspaceOf(store.get());
    if (!isOld(mine, other) && !isOld(other, mine)) return;
    clearTimeout(calm);
    calm = setTimeout(() => void carry(), CALM_MS);
  });

  store.select(only("scan", "fit"), ({ scan }) => {
    if (!scan || !memory) return;
    rememberScan(memory, { id: scan.info.id, title: scan.title, stance: stanceOf(store.get()), at: new Date().toISOString() });
  });

  async function second(bring: () => Promise<boolean>): Promise<void> {
    const kept = workspaceOf(store.get());
    put({ isBringing: true }, withProblem(store.get(), "stances", null));
    await flush();
    const isThere = await bring();
    if (!isThere) {
      const { problems } = store.get();
      put({ isBringing: false }, { problems: { ...problems, ...(problems.scan ? { stances: problems.scan } : {}) } });
      return;
    }
    put({ ...initialStances, other: kept, isSecond: true }, { announcement: text.stances.announceAdded });
    lookAfter();
  }

  return {
    dialog: (isAdding: boolean): void => put({ isAdding, known: memory ? knownScans(memory) : [] }, withProblem(store.get(), "stances", null)),
    upload: (file: File): Promise<void> => second(() => others.scan.upload(file)),
    takeExample: (name: string): Promise<void> => second(() => others.scan.takeExample(name)),
    takeKnown: (id: string): Promise<void> => second(() => others.scan.open(id, null)),

    /** From the address: the one that waits, as it was. */
    async restore(scan: string, fit: string | null, own: Frame | null, { isSecond, isComparing, isCarried }: { isSecond: boolean; isComparing: boolean; isCarried: boolean }): Promise<void> {
      try {
        const other = await loadWorkspace(client, scan, fit, own);
        put({ other, isSecond, isComparing, wantsCarried: isCarried });
        lookAfter();
      } catch (error) {
        fail(error);
      }
    },

    /** The page works on the other one now. */
    async swap(): Promise<void> {
      const { stances, isStarting } = store.get();
      if (!stances.other || isStarting) return;
      await flush();
      others.fit.stop();
      const state = store.get();
      const { other } = state.stances;
      if (!other) return;
      const [, name] = stanceNames(state);
      store.set({
        ...other,
        stances: { ...state.stances, other: workspaceOf(state), isSecond: !state.stances.isSecond },
        active: null,
        isStarting: false,
        announcement: text.stances.announceSwapped(name),
      });
      if (other.fit && isUnfinished(other.fit)) {
        const { step } = state;
        await others.fit.open(other.fit.id);
        if (other.fit.state === "done") store.set({ step });
      }
      lookAfter();
    },

    /** The one that waits is not wanted any more; the scan itself stays with the service. */
    remove(): void {
      clearTimeout(watch);
      store.set((state) => ({ drawn: { ...state.drawn, carried: null }, stances: { ...initialStances, known: state.stances.known } }));
    },

    compare: (isComparing: boolean): void =>
      store.set((state) => ({
        active: null,
        stances: { ...state.stances, isComparing },
        overlay: isComparing && (state.overlay === "beside" || state.overlay === "swipe" || !state.stances.isComparing) ? "scan" : state.overlay,
      })),
    dismiss: (): void => store.set((state) => withProblem(state, "stances", null)),
    link: (isLinked: boolean): void => put({ isLinked }),
    carry,

    async measures(isOpen: boolean): Promise<void> {
      const state = store.get();
      const fits = isOpen ? measuredFits(state) : null;
      if (!fits) {
        put({ measures: { ...state.stances.measures, isOpen: false } });
        return;
      }
      const [first, then] = fits;
      const of = `${first.id} ${then?.id ?? ""}`;
      const known = state.stances.measures.of === of ? state.stances.measures.file : null;
      put({ measures: { isOpen: true, isBusy: known === null, of, file: known } }, withProblem(state, "stances", null));
      if (known) return;
      try {
        const file = await client.measures(first.links.measures, then?.id ?? null);
        if (store.get().stances.measures.of === of) put({ measures: { ...store.get().stances.measures, isBusy: false, file } });
      } catch (error) {
        put({ measures: { ...store.get().stances.measures, isBusy: false } });
        fail(error);
      }
    },
  };
}

export type StancesActions = ReturnType<typeof stancesActions>;
