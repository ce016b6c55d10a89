// Running a fit: start, follow its events, cancel; the events are the same when the page is opened late or again.
import { ApiError, type Client } from "../api/client";
import { followFit, type Handlers } from "../api/events";
import type { FitLinks, Iterated, StanceChoice } from "../api/types";
import { certainNames } from "../landmarks/certain";
import { picksOf, placesOf } from "../landmarks/picks";
import { openQuestions, sentenceOf } from "../landmarks/questions/questions";
import type { LandmarksSlice } from "../landmarks/state";
import { questions } from "../landmarks/text";
import { straightened, straightenedByFit } from "../landmarks/straighten";
import type { ScanSlice } from "../scan/state";
import type { PageSlice, Step } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { formatMm } from "../ui/units";
import { readPly } from "../viewer/ply";
import type { ViewSlice } from "../viewer/state";
import { readDistances } from "./distances/distances";
import type { Follower } from "./playback/follower";
import type { Player } from "./playback/playback";
import { blankFit, type FitSlice, type FitState, withDistances } from "./state";
import * as text from "./text";
import { outdated } from "./outdated";
import { frameOfRig } from "./upright";
import { linesWords } from "./fingers";
import { verdictWords } from "./verdict";

type State = PageSlice & ViewSlice & ScanSlice & LandmarksSlice & FitSlice;

const PAUSE_MS = 150; // a run of key presses that nudge a landmark is one fit

export function fitActions(store: Store<State>, client: Client, player: Player, follower: Follower) {
  let stopFollowing: () => void = () => undefined;
  let run = 0; // the fit asked for last wins over slower, earlier ones
  let unseen: FitLinks | null = null; // of a fit that runs, while the page still shows the one before
  let timer: ReturnType<typeof setTimeout> | undefined;
  let askedAt = -Infinity;
  let stepAfter: { readonly from: Step; readonly to: Step } | null = null; // of a fit that is opened: where the page goes with its result, unless somebody has gone on
  let past: readonly Iterated[] | null = null; // of a fit that was done when it was opened: it is seen as it ended, and settles for nobody again

  /** Nobody follows what ran until now; a fit that was asked for in the meantime still comes. */
  function leave(): void {
    run += 1;
    stepAfter = null;
    past = null;
    stopFollowing();
    unseen = null;
    player.pause();
  }

  function stop(): void {
    clearTimeout(timer);
    leave();
  }

  const change = (part: Partial<FitState>, more: Partial<State> = {}): void =>
    store.set((state) => (state.fit ? { ...more, fit: { ...state.fit, ...part } } : more));

  /** Its scan was deleted: nobody asks for more of it. */
  const whyOver = (id: string): Promise<string | null> =>
    client.fit(id).then(
      () => null,
      (error: unknown) => (error instanceof ApiError && error.status === 404 ? text.fit.gone : null),
    );

  function follow(fit: FitState): void {
    leave();
    // A fit again is looked at as the one before it was.
    const look = store.get().fit ? {} : { showDistances: false };
    store.set({ ...look, fit, step: "body", active: null, isStarting: false, announcement: text.fit.announceStarted });
    const onConnection = (isConnected: boolean): void => change({ isConnected });
    stopFollowing = followFit(fit.links.events, { handlers, onConnection, whyOver: () => whyOver(fit.id) });
  }

  /** The fit before stays on the screen, its model where it has followed the landmarks, until this one is done. */
  function followUnseen(asked: FitState): void {
    leave();
    unseen = asked.links;
    let fit = asked;
    stopFollowing = followFit(fit.links.events, {
      handlers: {
        started: ({ body }) => (fit = { ...fit, started: body, drawingName: body.drawing }),
        iterated: ({ body }) => (fit = { ...fit, iterations: [...fit.iterations, body], shown: fit.iterations.length, playing: false }),
        done: (event) => {
          unseen = null;
          store.set({ fit, isStarting: false, followed: null });
          const { step } = store.get();
          handlers.done(event);
          store.set({ step }); // who moves landmarks stays with them
        },
        failed: ({ body }) => store.set((state) => ({ ...standStill(state), ...withProblem(state, "fit", body.reason) })),
        cancelled: () => store.set(standStill),
      },
      onConnection: (isConnected) => change({ isConnected }),
      whyOver: () => whyOver(asked.id),
    });
  }

  /** Nothing runs any more; a fit that was given up for a newer one ends where it was. */
  function standStill(state: State): Partial<State> {
    unseen = null;
    return { isStarting: false, followed: null, fit: state.fit?.state === "running" ? { ...state.fit, state: "cancelled" } : state.fit };
  }

  const handlers: Handlers = {
    started: ({ body }) => change({ started: body, drawingName: body.drawing }),
    iterated: ({ body }) => {
      const fit = store.get().fit;
      if (!fit) return;
      if (past) {
        past = [...past, body];
        return;
      }
      const before = fit.iterations.at(-1);
      const more = before?.stage === body.stage ? {} : { announcement: text.fit.announceStage(body.stage) };
      change({ iterations: [...fit.iterations, body] }, more);
      player.follow();
    },
    done: ({ body }) => {
      const said = [text.fit.announceDone(formatMm(body.result.surface_distance_mm.mean)), verdictWords(body.result), linesWords(body.result)].join(" ").trim();
      const upright = straightenedByFit(store.get(), frameOfRig(body.result));
      change({ state: "done", result: body.result, ...(past ? { iterations: past, shown: past.length - 1 } : {}) }, { ...upright, ...(stepAfter?.from === store.get().step ? { step: stepAfter.to } : {}) });
      stepAfter = past = null;
      const list = store.get().meta?.landmarks ?? [];
      const asked = openQuestions(store.get()).map((question) => sentenceOf(question, list));
      store.set({ announcement: asked.length > 0 ? `${said} ${questions.announceAsked(asked)}` : said });
      player.follow();
      void fetchDrawing();
      void fetchSurface();
    },
    failed: ({ body }) => {
      change({ state: "failed", reason: body.reason }, { step: "body", ...withProblem(store.get(), "fit", body.reason) });
    },
    cancelled: ({ body }) => change({ state: "cancelled", reason: body.reason }, { announcement: text.fit.cancelled }),
  };

  async function fetchDrawing(): Promise<void> {
    const fit = store.get().fit;
    if (fit?.drawingName == null) return;
    try {
      const drawing = await client.drawing(fit.links.drawing);
      if (store.get().fit?.id === fit.id) change({ drawing });
    } catch (error) {
      store.set((state) => withProblem(state, "fit", messageOf(error)));
    }
  }

  /** The surface and its distances; without them all else of the result still holds. */
  async function fetchSurface(): Promise<void> {
    const fit = store.get().fit;
    if (!fit) return;
    try {
      const [surface, distances] = await Promise.all([client.bytes(fit.links.fitted_ply).then(readPly), client.bytes(fit.links.distances)]);
      if (store.get().fit?.id === fit.id) change({ surface, distances: readDistances(distances) });
    } catch (error) {
      store.set((state) => withProblem(state, "distances", messageOf(error)));
    }
  }

  /** `isUnseen`: what is on the screen stays there until the new one is done. */
  async function begin(isUnseen: boolean): Promise<void> {
    const { scan, picks, certain: kept, stance, preset, refine } = store.get();
    if (!scan) return;
    const mine = ++run;
    const certain = certainNames(picks.present, kept);
    try {
      const { id, links, cuts } = await client.startFit({ scan: scan.info.id, stance, preset, refine, ...placesOf(picks.present), certain });
      if (mine !== run || store.get().scan?.info.id !== scan.info.id) {
        void client.cancel(links.cancel).catch(() => undefined); // nobody waits for it any more
        return;
      }
      const before = isUnseen ? (store.get().fit?.result ?? store.get().fit?.before ?? null) : null;
      (isUnseen ? followUnseen : follow)({ ...blankFit(id, links), playing: true, picks: picks.present, certain, before, cuts, asked: { stance, preset, refine } });
    } catch (error) {
      if (mine === run) store.set((state) => ({ ...standStill(state), ...withProblem(state, "fit", messageOf(error)) }));
    }
  }

  /** Ends at the service what nobody looks at any more. */
  function giveUpRunning(): void {
    const { fit } = store.get();
    const links = unseen ?? (fit?.state === "running" ? fit.links : null);
    leave();
    if (links) void client.cancel(links.cancel).catch(() => undefined);
  }

  function refitNow(): void {
    const { scan, fit } = store.get();
    if (!scan || !fit) return;
    giveUpRunning();
    store.set((state) => ({ isStarting: true, ...withProblem(state, "fit", null) }));
    void begin(fit.result !== null);
  }

  function refitSoon(): void {
    if (!store.get().fit) return;
    follower.show();
    const isRun = performance.now() - askedAt < PAUSE_MS;
    askedAt = performance.now();
    clearTimeout(timer);
    if (isRun) timer = setTimeout(refitNow, PAUSE_MS);
    else refitNow();
  }

  return {
    stop,

    async start(): Promise<void> {
      if (!store.get().scan || store.get().isStarting) return;
      clearTimeout(timer);
      store.set((state) => ({
        ...straightened(state, state.picks.present),
        ...withProblem(state, "fit", null),
        isStarting: true,
        active: null,
        step: "body",
      }));
      await begin(false);
    },

    /** Landmarks were moved, or a question about one was answered: the model follows, and at once the fit that belongs to them is made, as whoever starts with them would get it. */
    refit: (): void => refitSoon(),

    /** The fit that the address names, from its first event; one that is done leaves the page at `step`. */
    async open(id: string, step: Step | null = null): Promise<void> {
      try {
        const fit = await client.fit(id);
        // The settings come back with the fit, so that the next one is asked for as this one was; its drawing is the plan's.
        const asked = { stance: fit.asked_stance, preset: fit.preset, refine: fit.refine };
        store.set(asked);
        const isOver = fit.state === "done";
        follow({ ...blankFit(fit.id, fit.links), playing: !isOver, drawingName: fit.drawing, picks: picksOf({ landmarks: fit.landmarks, marks: fit.marks, unit: "mm" }), certain: fit.certain, asked, cuts: fit.cuts });
        if (isOver) [stepAfter, past] = [step && { from: store.get().step, to: step }, []];
      } catch (error) {
        store.set((state) => withProblem(state, "fit", messageOf(error)));
      }
    },

    async cancel(): Promise<void> {
      const { fit } = store.get();
      const links = unseen ?? (fit?.state === "running" ? fit.links : null);
      if (!links) return;
      try {
        await client.cancel(links.cancel);
      } catch (error) {
        store.set((state) => withProblem(state, "fit", messageOf(error)));
      }
    },

    /** The fit that knows it is made at once. */
    chooseStance(stance: StanceChoice): void {
      store.set({ stance });
      if (outdated(store.get()) === "settings") refitSoon();
    },

    /** Points are set by hand: a first fit that still runs is not waited for. */
    setAside(): void {
      const { fit } = store.get();
      if (fit?.state !== "running" || fit.before) return;
      giveUpRunning();
      store.set({ fit: null, isStarting: false });
    },
    choosePreset: (preset: string): void => store.set({ preset }),
    chooseRefine: (refine: boolean): void => store.set({ refine }),

    showMirror: (showMirror: boolean): void => store.set({ showMirror }),
    showDistances: (isOn: boolean): void => store.set((state) => withDistances(state, isOn)),
  };
}

export type FitActions = ReturnType<typeof fitActions>;
