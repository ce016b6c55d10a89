// The second stance: bring it, change over, compare, carry drawings across, measure both.
import { ApiError, type Client } from "../api/client";
import type { Frame, Scan } from "../api/types";
import { areSlicesOpen, withSlices } from "../drawing/slices/state";
import type { DrawingSlice } from "../drawing/state";
import type { FitActions } from "../fit/actions";
import { certainNames } from "../landmarks/certain";
import type { FitSlice } from "../fit/state";
import type { LandmarkActions } from "../landmarks/actions";
import { placesOf } from "../landmarks/picks";
import type { LandmarksSlice } from "../landmarks/state";
import { type PlanActions, withElsewhere } from "../plan/actions";
import type { ScanActions } from "../scan/actions";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import type { ViewSlice } from "../viewer/state";
import { followPlan } from "./followPlan";
import { predictActions } from "./predict";
import { samePatient } from "./samePatientText";
import { loadFit, loadWorkspace } from "./load";
import { type AskedPair, initialStances, isComparing, isImage, isPredicted, isSamePair, isUnfinished, measuredFits, scannedOther, stanceNames, type StancesSlice, type StancesState, type Workspace, workspaceOf } from "./state";
import * as text from "./text";

const WATCH_MS = 1000; // a fit that goes on while its scan waits is looked after so often

type State = PageSlice & ViewSlice & Workspace & LandmarksSlice & FitSlice & Pick<DrawingSlice, "slices"> & StancesSlice;

/** What of the page's other actions a second stance needs. */
interface Others {
  readonly scan: Pick<ScanActions, "upload" | "takeExample" | "open">;
  readonly fit: Pick<FitActions, "stop" | "open" | "start">;
  readonly landmarks: Pick<LandmarkActions, "flush" | "read" | "followSaved">;
  readonly drawing: { flush(): Promise<void> };
  /** Fits the scan that has just come. */
  begin(): void;
  readonly plan: Pick<PlanActions, "read" | "isMoreThanLines" | "settled" | "followElsewhere" | "followSaved">;
}

export function stancesActions(store: Store<State>, client: Client, others: Others) {
  let watch: ReturnType<typeof setTimeout> | undefined;

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

  /** The fit of a scan that waits, or is not on the page, comes to its end, although nobody listens to its events. */
  function lookAfter(): void {
    clearTimeout(watch);
    const { other, scans } = store.get().stances;
    const { scan, fit } = other ?? {};
    const onPage = [store.get().scan?.info.id, scan?.info.id];
    const isFurther = scans.some((each) => !onPage.includes(each.id) && (each.fit?.state === "queued" || each.fit?.state === "running"));
    if (isFurther && !(fit && isUnfinished(fit))) watch = setTimeout(() => void readHers().then(lookAfter), WATCH_MS);
    if (!scan || !fit || !isUnfinished(fit)) return;
    watch = setTimeout(() => {
      void client
        .fit(fit.id)
        .then(async ({ state }) => {
          if (state === "queued" || state === "running") return;
          const loaded = await loadFit(client, fit.id, fit.picks, fit.certain);
          change(scan.info.id, (workspace) => (workspace.fit?.id === fit.id ? { fit: loaded } : {}));
        })
        .catch((error: unknown) => {
          fail(error);
          if (error instanceof ApiError && error.status === 404) change(scan.info.id, (workspace) => (workspace.fit?.id === fit.id ? { fit: null } : {}));
        })
        .finally(lookAfter);
    }, WATCH_MS);
  }

  /** The plan was written elsewhere: the one that waits shows what is planned on it now. */
  others.plan.followElsewhere((link, mine, now, both) => {
    const scan = scannedOther(store.get().stances)?.scan;
    if (scan?.info.links.plan !== link) return;
    change(scan.info.id, (workspace) => withElsewhere(workspace, scan.info.id, mine, now, both) ?? {});
  });

  /** What could not be saved of the one that waits is saved by now. */
  others.plan.followSaved((scan) => change(scan, ({ drawn }) => ({ drawn: { ...drawn, saving: "saved" } })));
  others.landmarks.followSaved((scan) => change(scan, () => ({ saving: "saved" })));

  const { predict, leave } = predictActions(store, client, flush);

  followPlan(store, client, { plan: others.plan, flush: () => others.drawing.flush(), fail });

  const gone = new Set<string>(); // deleted, or soon: not to choose any more, unless it is taken back
  store.select(only("scan"), ({ scan }) => scan && gone.delete(scan.info.id));

  let whose = ""; // the open scan and its patient: another one has other scans beside it
  let isJoining = false; // a second scan has come, and is about to be one of the first one's patient
  store.select(only("scan"), lookForHers);

  function lookForHers(): void {
    if (isJoining) return;
    const { scan } = store.get();
    const now = scan ? `${scan.info.id} ${scan.info.patient}` : "";
    if (now === whose) return;
    whose = now;
    if (scan) void readHers();
  }

  /** All scans of the patient. */
  async function readHers(): Promise<void> {
    const scan = store.get().scan?.info;
    if (!scan) return;
    try {
      const { scans } = await client.patient(scan.patient);
      if (store.get().scan?.info.id === scan.id) put({ scans: scans.filter(({ id }) => !gone.has(id)) });
      const days = scans.length > 1 ? (await client.visits(scan.patient)).scans : null;
      if (store.get().scan?.info.id === scan.id) put({ visits: { ...store.get().stances.visits, days } });
    } catch (error) {
      fail(error);
    }
  }

  /** Both scans are of one patient: the plan is that of both, and what was planned on the first is not made anew on the second. */
  async function joinPatient(first: Workspace, isNew: boolean): Promise<void> {
    const scan = store.get().scan?.info;
    const patient = first.scan?.info;
    const isHers = scan?.patient === patient?.patient;
    if (!scan || !patient || (isHers && !isNew)) return;
    try {
      if (!isHers) await client.moveScan(scan.id, patient.patient);
      const info = { ...scan, patient: patient.patient, patient_code: patient.patient_code, links: { ...scan.links, patient: patient.links.patient, plan: patient.links.plan } };
      const planned = await others.plan.read(info);
      store.set((state) => (state.scan?.info.id === scan.id ? { scan: { ...state.scan, info }, drawing: planned.drawing } : {}));
    } catch (error) {
      fail(error);
    }
  }

  async function second(bring: () => Promise<boolean>, isNew = false, mayFit = true): Promise<void> {
    put({ isBringing: true }, withProblem(store.get(), "stances", null));
    await flush(); // what is kept is saved, and has what somebody else was found to have planned
    const kept = workspaceOf(store.get());
    isJoining = true;
    const isThere = await bring();
    if (!isThere) {
      isJoining = false;
      const { problems } = store.get();
      put({ isBringing: false }, { problems: { ...problems, ...(problems.scan ? { stances: problems.scan } : {}) } });
      return;
    }
    put({ ...initialStances, scans: store.get().stances.scans, other: kept, isSecond: true }, { announcement: text.stances.announceAdded });
    await joinPatient(kept, isNew);
    isJoining = false;
    lookForHers();
    lookAfter();
    if (mayFit) others.begin();
  }

  /** A scan that has just been added to the patient: fitted by itself, and beside the one in work if nothing else is. */
  async function addBeside(added: Scan, isFitted: boolean): Promise<void> {
    try {
      const { preset, refine, stances } = store.get();
      const { id } = added;
      const { picks, certain } = await others.landmarks.read(added);
      const fit = isFitted ? (await client.startFit({ scan: id, stance: "auto", preset, refine, ...placesOf(picks), certain: [...certain] })).id : null;
      await readHers();
      if (stances.other) {
        lookAfter();
        return;
      }
      put({ other: await loadWorkspace(client, others.landmarks, others.plan, id, fit, null), isSecond: false, isComparing: true });
      lookAfter();
    } catch (error) {
      fail(error);
    }
  }

  return {
    dialog(isAdding: boolean): void {
      put({ isAdding, named: null }, withProblem(store.get(), "stances", null));
      if (isAdding) void readHers();
    },

    /** A scan that is filed elsewhere: only whoever knows the patient's code may choose it. */
    async name(code: string): Promise<void> {
      const typed = code.trim();
      if (typed === "") return;
      put({ named: null }, withProblem(store.get(), "stances", null));
      try {
        const { patients } = await client.patients(null, typed, "code");
        const named = patients.find((patient) => patient.code.toLowerCase() === typed.toLowerCase() && patient.id !== store.get().scan?.info.patient);
        put({ named: named ?? null }, named ? {} : withProblem(store.get(), "stances", text.stances.dialog.nobody(typed)));
      } catch (error) {
        fail(error);
      }
    },

    addBeside,
    async takeExampleBeside(name: string, isFitted: boolean): Promise<void> {
      try {
        const info = await client.importExample(name, store.get().group);
        const { scan } = store.get();
        if (scan) await client.moveScan(info.id, scan.info.patient);
        await addBeside(info, isFitted);
      } catch (error) {
        fail(error);
      }
    },
    upload: (file: File): Promise<void> => second(() => others.scan.upload(file, undefined, undefined, null, store.get().scan?.info.patient), true),
    takeExample: (name: string): Promise<void> => second(() => others.scan.takeExample(name)),
    takeKnown: (id: string): Promise<void> => second(() => others.scan.open(id, null), false, false),

    /** The service has it no more. */
    forget(scan: string): void {
      gone.add(scan);
      put({ scans: store.get().stances.scans.filter(({ id }) => id !== scan) });
    },

    /** From the address: the one that waits, as it was. */
    async restore(scan: string, fit: string | null, own: Frame | null, { isSecond, isComparing }: { isSecond: boolean; isComparing: boolean }): Promise<void> {
      try {
        const other = await loadWorkspace(client, others.landmarks, others.plan, scan, fit, own);
        put({ other, isSecond, isComparing }, isComparing ? { overlay: "scan" } : {}); // as `compare` begins it
        lookAfter();
      } catch (error) {
        fail(error);
      }
    },

    /** The page works on the other one now; not while a fit is asked for, unless the one that is left is not wanted any more. */
    async swap({ isLeft = false } = {}): Promise<void> {
      const { stances, isStarting } = store.get();
      if (!stances.other || isPredicted(stances.other) || (isStarting && !isLeft)) return;
      await flush();
      others.fit.stop();
      const state = store.get();
      const { other } = state.stances;
      if (!other) return;
      const [, name] = stanceNames(state);
      store.set({
        ...other,
        drawn: { ...other.drawn, tool: state.drawn.tool }, // what is in the hand stays there
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

    /** The waiting one is tapped; where slices are open the tap puts their cross. */
    async work(): Promise<void> {
      if (!areSlicesOpen(store.get())) await this.swap();
    },

    /** A scan of the strip: one that is not seen is shown beside the one in work, one that waits is worked on, the one in work is put away beside another; `hasRoomForOne`: for no second pane. */
    async tap(id: string, hasRoomForOne = false): Promise<void> {
      const wasAlone = id === store.get().scan?.info.id && !isComparing(store.get());
      await this.tapScan(id, hasRoomForOne);
      // An image is looked at in slices; where it stands alone already, a tap closes them again.
      store.set((state) => {
        const of = [state, ...(isComparing(state) ? [state.stances.other!] : [])].find(({ scan }) => scan?.info.id === id);
        const isOurs = [state, state.stances.other].some((each) => each?.scan?.info.id === id && isImage(each));
        return isOurs ? withSlices(state, of !== undefined && !(wasAlone && areSlicesOpen(state))) : {};
      });
    },

    async tapScan(id: string, isAlone: boolean): Promise<void> {
      const { scan, stances, isStarting } = store.get();
      const { other } = stances;
      if (isStarting) return;
      const isIts = other !== null && (isPredicted(other) ? id === "predicted" : id === other.scan?.info.id);
      if (isIts && isAlone && !isPredicted(other)) {
        await this.swap();
        this.compare(false);
      } else if (isIts && stances.isComparing && !isPredicted(other)) await this.swap();
      else if (isIts) this.compare(!stances.isComparing);
      if (id === scan?.info.id && isComparing(store.get())) {
        if (!isPredicted(other!)) await this.swap();
        this.compare(false);
      }
      if (isIts || id === scan?.info.id) return;
      const row = stances.scans.find((each) => each.id === id);
      leave();
      await flush();
      await this.restore(id, row?.fit?.state === "done" ? row.fit.id : null, null, { isSecond: false, isComparing: !isAlone });
      if (isAlone && store.get().stances.other?.scan?.info.id === id) await this.swap();
    },

    /** The one that waits is not wanted any more; the scan itself stays with the service. */
    remove(): void {
      clearTimeout(watch);
      leave();
      store.set(({ stances }) => ({ stances: { ...initialStances, scans: stances.scans, answers: stances.answers } }));
    },

    /** Fits both scans, where that is not done: what is planned on one is then carried to the other. */
    async fitBoth(): Promise<void> {
      const { stances, preset, refine, fit } = store.get();
      const other = scannedOther(stances);
      if (!other?.scan || store.get().isStarting) return;
      try {
        if (other.fit === null || other.fit.state === "failed" || other.fit.state === "cancelled") {
          const { scan, picks, certain, stance } = other;
          const kept = certainNames(picks.present, certain);
          await others.plan.settled();
          const { id } = await client.startFit({ scan: scan.info.id, stance, preset, refine, ...placesOf(picks.present), certain: kept });
          const begun = await loadFit(client, id, picks.present, kept);
          change(scan.info.id, () => ({ fit: begun }));
          lookAfter();
        }
        if (fit?.state !== "done" && fit?.state !== "running") await others.fit.start();
      } catch (error) {
        fail(error);
      }
    },

    predict,

    compare: (isComparing: boolean): void =>
      store.set((state) => ({
        active: null,
        stances: { ...state.stances, isComparing },
        overlay: isComparing && !state.stances.isComparing ? "scan" : state.overlay,
      })),
    dismiss: (): void => store.set((state) => withProblem(state, "stances", null)),
    /** Whether the scans that are asked about are of one patient. */
    async samePatient(isSame: boolean): Promise<void> {
      const { answerSamePatient } = await import("./samePatient");
      await flush();
      await others.plan.settled();
      await answerSamePatient(store, client, { fail, swap: () => this.swap({ isLeft: true }), remove: () => this.remove(), forget: (scan) => this.forget(scan), read: others.plan.read }, isSame);
    },

    /** A person cannot say: both stay as they are filed, nothing is carried, and until the page is opened anew it is asked when that is wanted. */
    leaveUnanswered: (): void =>
      store.set(({ stances }) => {
        const [first] = stances.asked;
        const isIt = (each: AskedPair): boolean => first !== undefined && isSamePair(each, first);
        return { stances: { ...stances, asked: stances.asked.filter((each) => !isIt(each)), unanswered: [...stances.unanswered, ...stances.asked.filter(isIt)] }, announcement: samePatient.left };
      }),
    askAgain: (): void => store.set(({ stances }) => ({ stances: { ...stances, asked: [...stances.asked, ...stances.unanswered], unanswered: [] } })),

    link: (isLinked: boolean): void => put({ isLinked }),

    /** A row of the table is pointed at, or none. */
    pointAt(pointed: string | null): void {
      const { measures } = store.get().stances;
      if (measures.pointed !== pointed) put({ measures: { ...measures, pointed } });
    },

    async measures(isOpen: boolean): Promise<void> {
      const state = store.get();
      const fits = isOpen ? measuredFits(state) : null;
      if (!fits) {
        put({ measures: { ...state.stances.measures, isOpen: false, pointed: null } });
        return;
      }
      const [first, then] = fits;
      const of = `${first.id} ${then?.id ?? ""}`;
      const known = state.stances.measures.of === of ? state.stances.measures.file : null;
      put({ measures: { isOpen: true, isBusy: known === null, of, file: known, pointed: null } }, withProblem(state, "stances", null));
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
