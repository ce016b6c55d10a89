// Plays the iterations at the pace they arrive, but never faster than the eye follows.
// "At the end" is no state of its own: while playing, the player rests there until more arrives or the fit is over.
import type { Store } from "../../store/store";
import { type FitSlice, type FitState, isAtRest } from "../state";

const LIVE_MS = 60; // at least this long for each iteration
const SETTLE_MS = 600; // at least this long for all of them, so that the model is seen to settle
const REPLAY_MS = 110;

export interface Player {
  readonly follow: () => void;
  readonly replay: () => void;
  readonly pause: () => void;
  readonly toggle: () => void;
  readonly seek: (index: number) => void;
}

type Later = (action: () => void, milliseconds: number) => void;

export function createPlayer(
  store: Store<FitSlice>,
  prefersStill: () => boolean,
  later: Later = (action, ms) => void setTimeout(action, ms),
): Player {
  let run = 0; // a tick of an abandoned run does nothing
  let isTicking = false;

  const change = (part: Partial<FitState>): void =>
    store.set((state) => (state.fit ? { fit: { ...state.fit, ...part } } : {}));

  function tick(mine: number, pace: number): void {
    const fit = store.get().fit;
    if (mine !== run || !fit?.playing) {
      if (mine === run) isTicking = false;
      return;
    }
    const last = fit.iterations.length - 1;
    if (fit.shown >= last) {
      isTicking = false; // the next event starts it again
      if (isAtRest(fit)) change({ playing: false });
      return;
    }
    change({ shown: prefersStill() ? last : fit.shown + 1 });
    later(() => tick(mine, pace), pace);
  }

  /** Of a fit that came all at once the few iterations take their time. */
  const livePace = ({ result, iterations }: FitState): number => (result ? Math.max(LIVE_MS, SETTLE_MS / Math.max(1, iterations.length - 1)) : LIVE_MS);

  function start(pace: number): void {
    run += 1;
    isTicking = true;
    tick(run, pace);
  }

  function pause(): void {
    run += 1;
    isTicking = false;
    if (store.get().fit?.playing) change({ playing: false });
  }

  function replay(): void {
    if (!store.get().fit?.iterations.length) return;
    change({ shown: 0, playing: true });
    run += 1;
    const mine = run;
    isTicking = true;
    later(() => tick(mine, REPLAY_MS), REPLAY_MS);
  }

  return {
    follow: () => {
      const { fit } = store.get();
      if (fit?.playing && !isTicking) start(livePace(fit));
    },
    replay,
    pause,
    toggle: () => {
      const fit = store.get().fit;
      if (!fit) return;
      if (fit.playing) pause();
      else if (fit.shown >= fit.iterations.length - 1) replay();
      else {
        change({ playing: true });
        start(REPLAY_MS);
      }
    },
    seek: (index) => {
      pause();
      change({ shown: index });
    },
  };
}
