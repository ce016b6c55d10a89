// The model follows a dragged landmark: one question at a time, the newest picks only, and nothing stays.
import { beforeEach, afterEach, expect, test, vi } from "vitest";
import { FakeEventSource, withScan } from "../fakes";
import { shownPoses, showsFittedSurface } from "../../src/fit/state";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(1000);
const nodesAt = (x: number) => ({ nodes: [{ name: "pelvis", translation: [x, 0, 0] }] });

/** A fit that is done, and a service that answers when the test says so. */
async function fitted() {
  const answers: (() => void)[] = [];
  const moved = vi.fn((_links: unknown, picks: Record<string, number[]>) => new Promise((done, fail) => answers.push(() => (picks.nipple_L![0]! < 0 ? fail(new Error("too many")) : done(nodesAt(picks.nipple_L![0]!))))));
  const made = await withScan({ moved } as never);
  made.actions.landmarks.restore({ nipple_L: [1, 0, 0], umbilicus: [0, 0, 0] });
  await made.actions.fit.start();
  FakeEventSource.last!.say("iterated", { iteration: 0, stage: "pose", mean_distance_mm: 5, nodes: [] });
  FakeEventSource.last!.say("done", { result: { surface_distance_mm: { mean: 1 }, stance: "standing", refined: true } });
  await settle();
  const answer = async (): Promise<void> => {
    answers.shift()!();
    await vi.advanceTimersByTimeAsync(1);
  };
  return { ...made, moved, answer, waiting: () => answers.length };
}

test("while an answer is awaited only the newest place of the mark is kept, and that is asked for next", async () => {
  const { store, actions, moved, answer, waiting } = await fitted();
  actions.follower.begin();
  for (const x of [2, 3, 4]) actions.follower.move({ nipple_L: [x, 0, 0] });
  expect(moved).toHaveBeenCalledTimes(1);
  await answer();
  expect(shownPoses(store.get())).toEqual(nodesAt(1).nodes);
  expect(moved.mock.calls.map(([, picks]) => picks)).toEqual([{ nipple_L: [1, 0, 0], umbilicus: [0, 0, 0] }, { nipple_L: [4, 0, 0], umbilicus: [0, 0, 0] }]);
  await answer();
  expect(shownPoses(store.get())).toEqual(nodesAt(4).nodes);
  expect(showsFittedSurface({ ...store.get(), models: {} }), "the rig stands for the surface").toBe(false);
  expect(store.get().picks.present.nipple_L, "the state learns of it at the end").toEqual([1, 0, 0]);
  expect(waiting()).toBe(0);
});

test("a drag that is given up leaves the model where it was, whatever answer still comes", async () => {
  const { store, actions, answer } = await fitted();
  actions.follower.move({ nipple_L: [2, 0, 0] });
  actions.follower.giveUp();
  await answer();
  expect(store.get().followed).toBeNull();
});

test("a service that cannot follow is no problem that anybody has to read", async () => {
  const { store, actions, answer, waiting } = await fitted();
  actions.follower.move({ nipple_L: [-1, 0, 0] });
  await answer();
  expect(store.get()).toMatchObject({ followed: null, problems: {} });
  actions.follower.move({ nipple_L: [3, 0, 0] });
  expect(waiting(), "the next move asks again").toBe(1);
});

test("nothing is asked before a fit is done", async () => {
  const { actions, client } = await withScan();
  actions.landmarks.restore({ nipple_L: [1, 0, 0] });
  actions.follower.move({ nipple_L: [2, 0, 0] });
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", { iteration: 0, stage: "pose", mean_distance_mm: 5, nodes: [] });
  actions.follower.move({ nipple_L: [2, 0, 0] });
  expect(client.moved).not.toHaveBeenCalled();
});
