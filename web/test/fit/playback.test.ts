import { expect, test } from "vitest";
import type { Iterated } from "../../src/api/types";
import { initialSession, type Session } from "../../src/app/session";
import { createPlayer } from "../../src/fit/playback/playback";
import type { FitState } from "../../src/fit/state";
import { createStore } from "../../src/store/store";

function setUp(isStill = false) {
  const fit = { id: "f", state: "running", iterations: [], shown: -1, playing: true } as unknown as FitState;
  const store = createStore<Session>({ ...initialSession, fit });
  const timers: { at: number; action: () => void }[] = [];
  let now = 0;
  const player = createPlayer(store, () => isStill, (action, ms) => timers.push({ at: now + ms, action }));
  const shownAt: [number, number][] = [];
  store.subscribe((state, before) => {
    if (state.fit?.shown !== before.fit?.shown) shownAt.push([now, state.fit!.shown]);
  });
  return {
    store,
    player,
    shownAt,
    arrive: (count: number, state: FitState["state"] = "running") => {
      const more = Array.from({ length: count }, (_, i) => ({ iteration: i }) as Iterated);
      store.set(({ fit: old }) => ({ fit: { ...old!, state, iterations: [...old!.iterations, ...more] } }));
      player.follow();
    },
    pass: (ms: number) => {
      const end = now + ms;
      for (;;) {
        timers.sort((a, b) => a.at - b.at);
        const next = timers[0];
        if (!next || next.at > end) break;
        timers.shift();
        now = next.at;
        next.action();
      }
      now = end;
    },
  };
}

test("iterations that come in a burst are shown one after the other, at least 60 ms apart", () => {
  const { arrive, pass, shownAt } = setUp();
  arrive(3);
  arrive(2);
  pass(1000);
  expect(shownAt.map(([, shown]) => shown)).toEqual([0, 1, 2, 3, 4]);
  for (let i = 1; i < shownAt.length; i += 1) expect(shownAt[i]![0] - shownAt[i - 1]![0]).toBeGreaterThanOrEqual(60);
});

test("the player waits at the end for the next iteration and rests when the fit is over", () => {
  const { arrive, pass, shownAt, store } = setUp();
  arrive(1);
  pass(500);
  arrive(1);
  pass(10);
  expect(shownAt).toEqual([[0, 0], [500, 1]]);
  expect(store.get().fit?.playing).toBe(true);
  arrive(0, "done");
  pass(200);
  expect(store.get().fit?.playing).toBe(false);
});

test("the slider stops the play, and replay starts again from the beginning", () => {
  const { arrive, pass, player, shownAt, store } = setUp();
  arrive(4, "done");
  pass(70);
  player.seek(3);
  pass(1000);
  expect(store.get().fit).toMatchObject({ shown: 3, playing: false });
  shownAt.length = 0;
  player.replay();
  pass(2000);
  expect(shownAt.map(([, shown]) => shown)).toEqual([0, 1, 2, 3]);
  expect(store.get().fit?.playing).toBe(false);
});

test("the button pauses, goes on from there, and replays once the end is reached", () => {
  const { arrive, pass, player, shownAt, store } = setUp();
  arrive(4, "done");
  pass(70);
  player.toggle();
  pass(1000);
  expect(store.get().fit).toMatchObject({ shown: 1, playing: false });
  player.toggle();
  pass(1000);
  expect(store.get().fit).toMatchObject({ shown: 3, playing: false });
  shownAt.length = 0;
  player.toggle();
  pass(2000);
  expect(shownAt.map(([, shown]) => shown)).toEqual([0, 1, 2, 3]);
});

test("whoever asked for less motion sees the newest iteration only", () => {
  const { arrive, pass, shownAt } = setUp(true);
  arrive(5);
  pass(500);
  expect(shownAt.map(([, shown]) => shown)).toEqual([4]);
});
