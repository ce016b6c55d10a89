// Running a fit: start, follow its events, cancel; the story is the same when the page is opened late or again.
import type { Client } from "../api/client";
import { followFit, type Handlers } from "../api/events";
import type { FitLinks, StanceChoice } from "../api/types";
import { readDistances } from "../state/distances";
import { type FitState, pickCount, type Session } from "../state/session";
import type { Store } from "../state/store";
import { text } from "../text";
import { formatMm } from "../units";
import type { Player } from "./playback";
import { messageOf, withProblem } from "./problems";
import { picksOf } from "./scan";
import { straightened } from "./straighten";

export function fitActions(store: Store<Session>, client: Client, player: Player) {
  let stopFollowing: () => void = () => undefined;

  function stop(): void {
    stopFollowing();
    player.pause();
  }

  const change = (part: Partial<FitState>, more: Partial<Session> = {}): void =>
    store.set((state) => (state.fit ? { ...more, fit: { ...state.fit, ...part } } : more));

  function follow(id: string, links: FitLinks, drawingName: string | null, picks: FitState["picks"]): void {
    stop();
    const fit: FitState = {
      id,
      links,
      state: "running",
      started: null,
      iterations: [],
      shown: -1,
      playing: true,
      result: null,
      drawing: null,
      drawingName,
      surface: null,
      distances: null,
      reason: null,
      isConnected: true,
      picks,
    };
    // A fit again is looked at as the one before it was.
    const look = store.get().fit ? {} : { overlay: "both" as const, showDistances: false };
    store.set({ ...look, fit, step: "fit", active: null, isStarting: false, announcement: text.fit.announceStarted });
    stopFollowing = followFit(links.events, { handlers, onConnection: (isConnected) => change({ isConnected }) });
  }

  const handlers: Handlers = {
    started: ({ body }) => change({ started: body, drawingName: body.drawing }),
    iterated: ({ body }) => {
      const fit = store.get().fit;
      if (!fit) return;
      const before = fit.iterations.at(-1);
      const more = before?.stage === body.stage ? {} : { announcement: text.fit.announceStage(body.stage) };
      change({ iterations: [...fit.iterations, body] }, more);
      player.follow();
    },
    done: ({ body }) => {
      const announcement = text.fit.announceDone(formatMm(body.result.surface_distance_mm.mean));
      const upright = straightened(store.get(), picksOf({ landmarks: body.result.landmarks, unit: body.result.scan.unit }));
      change({ state: "done", result: body.result }, { ...upright, step: "result", announcement });
      player.follow();
      void fetchDrawing();
      void fetchSurface();
    },
    failed: ({ body }) => {
      change({ state: "failed", reason: body.reason }, { step: "fit", ...withProblem(store.get(), "fit", body.reason) });
    },
    cancelled: ({ body }) => change({ state: "cancelled", reason: body.reason }, { announcement: text.fit.cancelled }),
  };

  async function fetchDrawing(): Promise<void> {
    const fit = store.get().fit;
    if (!fit || fit.drawingName === null) return;
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
      const [surface, distances] = await Promise.all([client.bytes(fit.links.fitted_ply), client.bytes(fit.links.distances)]);
      if (store.get().fit?.id === fit.id) change({ surface, distances: readDistances(distances) });
    } catch (error) {
      store.set((state) => withProblem(state, "distances", messageOf(error)));
    }
  }

  return {
    stop,

    async start(): Promise<void> {
      const { scan, picks, stance, preset, drawing, refine } = store.get();
      if (!scan || store.get().isStarting) return;
      store.set((state) => ({
        ...straightened(state, picks.present),
        ...withProblem(state, "fit", null),
        isStarting: true,
        active: null,
        step: "fit",
      }));
      try {
        const landmarks = { ...picks.present };
        const { id, links } = await client.startFit({ scan: scan.info.id, stance, preset, drawing: drawing || null, refine, landmarks });
        if (store.get().scan?.info.id !== scan.info.id) return;
        follow(id, links, drawing || null, picks.present);
      } catch (error) {
        store.set((state) => ({ isStarting: false, ...withProblem(state, "fit", messageOf(error)) }));
      }
    },

    /** The same once more with the landmarks as they are now; one that still runs is of no use any more. */
    async again(): Promise<void> {
      const { fit } = store.get();
      if (!fit) return;
      if (fit.state === "running") await this.cancel();
      await this.start();
    },

    /** The fit that the address names, from its first event. */
    async open(id: string): Promise<void> {
      try {
        const fit = await client.fit(id);
        const picks = store.get().picks.present;
        follow(fit.id, fit.links, fit.drawing, pickCount(store.get()) > 0 ? picks : null);
      } catch (error) {
        store.set((state) => withProblem(state, "fit", messageOf(error)));
      }
    },

    async cancel(): Promise<void> {
      const fit = store.get().fit;
      if (fit?.state !== "running") return;
      try {
        await client.cancel(fit.links.cancel);
      } catch (error) {
        store.set((state) => withProblem(state, "fit", messageOf(error)));
      }
    },

    chooseStance: (stance: StanceChoice): void => store.set({ stance }),
    choosePreset: (preset: string): void => store.set({ preset }),
    chooseRefine: (refine: boolean): void => store.set({ refine }),
    chooseDrawing: (drawing: string): void => store.set({ drawing }),
  };
}
