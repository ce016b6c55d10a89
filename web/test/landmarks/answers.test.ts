// Answers to what a fit asks: saved, undone, and fitted again at once.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { FakeEventSource, fitLinks, withScan } from "../fakes";
import type { Vector } from "../../src/api/types";
import { certainNames } from "../../src/landmarks/certain";
import { openQuestions } from "../../src/landmarks/questions/questions";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const PLACES: Record<string, Vector> = { nipple_L: [-90, 0, 60], nipple_R: [90, 0, 60], umbilicus: [50, -200, 40], suprasternal_notch: [0, 200, 10] };
const OFF = { names: ["umbilicus"], reason: "umbilicus is 50 mm off." };
const EXCHANGED = { names: ["nipple_L", "nipple_R"], reason: "nipple_L and nipple_R look exchanged." };
const UNUSUAL = { names: ["suprasternal_notch"], reason: "suprasternal_notch is unusual." };

function resultOf(given: Record<string, Vector>, doubts: object): object {
  return { surface_distance_mm: { mean: 1.2 }, scan: { unit: "mm" }, landmarks: {}, landmarks_picked: given, ...doubts };
}

/** A fit that asks, with its page at the landmarks. */
async function asking(doubts: object, places = PLACES) {
  const startFit = vi.fn(async () => ({ id: `f${startFit.mock.calls.length}`, links: fitLinks(`f${startFit.mock.calls.length}`) }));
  const made = await withScan({ startFit });
  made.actions.landmarks.restore(places);
  await made.actions.fit.start();
  finish(places, doubts);
  const said = made.store.get().announcement;
  await settle();
  made.actions.page.goTo("points");
  return { ...made, startFit, said, asked: () => openQuestions(made.store.get()).map(({ names }) => names) };
}

function finish(given: Record<string, Vector>, doubts: object): void {
  FakeEventSource.last!.say("iterated", { iteration: 0, stage: "pose", mean_distance_mm: 5, nodes: [] });
  FakeEventSource.last!.say("done", { result: resultOf(given, doubts) });
}

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(1000);

test("what is asked is said aloud with the end of the fit", async () => {
  const { said } = await asking({ landmarks_not_followed: [OFF] }, { umbilicus: PLACES.umbilicus! });
  expect(said).toMatch(/^The fit is done: .* Please check: Umbilicus is 50 mm off\.$/);
});

test("kept: certain with the landmarks and in the next fit, from the beginning, and the page stays where it was", async () => {
  const { store, client, actions, startFit, asked } = await asking({ landmarks_not_followed: [EXCHANGED, OFF] });
  expect(asked()).toEqual([EXCHANGED.names, OFF.names]);
  actions.landmarks.keep(OFF.names);
  expect(asked()).toEqual([EXCHANGED.names]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: PLACES, certain: ["umbilicus"] }));
  expect(startFit.mock.lastCall).not.toEqual([expect.objectContaining({ start_from: "f1" })]);
  await settle();
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1]).toMatchObject({ landmarks: PLACES, certain: ["umbilicus"] });
  expect(store.get()).toMatchObject({ fit: { id: "f1" }, step: "points", saving: "saved" });
  FakeEventSource.last!.say("started", { stance: "standing", drawing: null, iterations_limit: 9, notes: [] });
  FakeEventSource.last!.say("iterated", { iteration: 0, stage: "pose", mean_distance_mm: 5, nodes: [] });
  expect(asked(), "the other question stays while the fit runs").toEqual([EXCHANGED.names]);
  finish(PLACES, { landmarks_not_followed: [EXCHANGED] });
  expect(store.get()).toMatchObject({ fit: { id: "f2", certain: ["umbilicus"] }, step: "points" });
  expect(asked()).toEqual([EXCHANGED.names]);
});

test("no longer kept: it is fitted without, and may be asked about again", async () => {
  const { store, actions, startFit, asked } = await asking({ landmarks_unusual: [UNUSUAL] }, { ...PLACES, nipple_L: PLACES.nipple_R!, nipple_R: PLACES.nipple_L! });
  actions.landmarks.keep(UNUSUAL.names);
  expect(asked()).toEqual([]);
  actions.landmarks.unkeep("suprasternal_notch");
  await settle();
  expect(asked()).toEqual([UNUSUAL.names]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ certain: [] }));
  expect(certainNames(store.get().picks.present, store.get().certain)).toEqual([]);
});

test("taken out: one step of the history, and undoing it is fitted as well", async () => {
  const { store, client, actions, startFit, asked } = await asking({ landmarks_not_followed: [OFF, EXCHANGED] });
  const { umbilicus: _out, ...rest } = PLACES;
  actions.landmarks.takeOut("umbilicus");
  expect(asked()).toEqual([EXCHANGED.names]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: rest }));
  await settle();
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1].landmarks).toEqual(rest);
  actions.landmarks.undo();
  await settle();
  expect(store.get().picks.present).toEqual(PLACES);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: PLACES }));
  actions.landmarks.redo();
  await settle();
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: rest }));
  expect(startFit).toHaveBeenCalledTimes(4);
});

test("exchanged: both sides in one step, fitted at once; undo puts them back", async () => {
  const { store, actions, startFit, asked } = await asking({ landmarks_not_followed: [EXCHANGED] });
  const right = { ...PLACES, nipple_L: PLACES.nipple_R!, nipple_R: PLACES.nipple_L! };
  actions.landmarks.exchange(EXCHANGED.names);
  expect(store.get().picks.present).toEqual(right);
  expect(asked()).toEqual([]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: right }));
  actions.landmarks.undo();
  expect(store.get().picks.present).toEqual(PLACES);
  await settle();
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: PLACES }));
});

test("before any fit an answer is saved and starts none", async () => {
  const startFit = vi.fn();
  const { store, client, actions } = await withScan({ startFit });
  actions.landmarks.restore(PLACES);
  const [question] = openQuestions(store.get());
  expect(question).toMatchObject({ names: EXCHANGED.names, exchange: "sides" });
  actions.landmarks.exchange(question!.names);
  await settle();
  expect(openQuestions(store.get())).toEqual([]);
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1].landmarks).toMatchObject({ nipple_L: [90, 0, 60] });
  expect(startFit).not.toHaveBeenCalled();
});

test("what is certain comes with the scan and with a file, and waits for signing in again", async () => {
  const answer = { schema: "breastrig/landmarks@1" as const, unit: "mm" as const, landmarks: PLACES, certain: ["umbilicus"] };
  const { store, actions } = await withScan({ landmarks: async () => answer });
  const certain = (): string[] => certainNames(store.get().picks.present, store.get().certain);
  expect(certain()).toEqual(["umbilicus"]);
  await actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks: { nipple_L: [95, 0, 60] }, certain: ["nipple_L"] })], "l.json"));
  expect(certain()).toEqual(["nipple_L", "umbilicus"]);
  await actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks: { umbilicus: [1, -200, 40] } })], "l.json"));
  expect(certain(), "another place is another pick").toEqual(["nipple_L"]);
  actions.landmarks.restore(PLACES, ["suprasternal_notch"]);
  expect(certain()).toEqual(["suprasternal_notch"]);
  await settle();
});

test("of a file that is read for a scan of another size it is said in which size its places were taken", async () => {
  const { store, actions } = await withScan();
  const read = async (): Promise<void> => actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks: { nipple_L: [95, 0, 60] } })], "l.json"));
  await read();
  expect(store.get().problems.landmarks).toBeUndefined();
  const { scan } = store.get();
  store.set({ scan: { ...scan!, info: { ...scan!.info, scale: { factor: 1.03, between: ["nipple_L", "xiphoid"], mm: 210, measured_mm: 203.9, ends: [[0, 0, 0], [0, 210, 0]] } } } });
  await read();
  expect(store.get().problems.landmarks).toContain("1.030 times that of its own file");
  expect(store.get().announcement).toContain(store.get().problems.landmarks);
  await settle();
});
