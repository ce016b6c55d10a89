import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { FakeEventSource, fitLinks, withScan } from "../fakes";
import { ApiError } from "../../src/api/client";
import { outdated } from "../../src/fit/outdated";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const iterated = (iteration: number) => ({ iteration, stage: "pose", mean_distance_mm: 5 - iteration, nodes: [] });
const result = { surface_distance_mm: { mean: 1.2 }, scan: { unit: "m" }, landmarks: {} };

test("a fit is followed from start to result", async () => {
  const startFit = vi.fn(async () => ({ id: "f1", links: fitLinks("f1") }));
  const { store, actions } = await withScan({ startFit });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  actions.fit.chooseRefine(true);
  await actions.fit.start();
  expect(startFit).toHaveBeenCalledWith({
    scan: "s1",
    stance: "auto",
    marks: {},
    preset: "default",
    refine: true,
    landmarks: { nipple_L: [1, 2, 3] },
    certain: [],
  });
  const source = FakeEventSource.last!;
  expect(source.url).toBe("/api/fits/f1/events");
  source.say("started", { stance: "standing", drawing: "lumpectomy", iterations_limit: 40, notes: [] });
  source.say("iterated", iterated(0));
  source.say("iterated", iterated(1));
  source.say("done", { result });
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get().fit).toMatchObject({ state: "done", shown: 1, playing: false, result, drawing: { shapes: [] } });
  expect(store.get().step).toBe("body");
});

test("a fit that fails says why where it was started, and its iterations stay", async () => {
  const { store, actions } = await withScan();
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("failed", { reason: "No start was found." });
  expect(store.get()).toMatchObject({ step: "body", problems: { fit: "No start was found." } });
  expect(store.get().fit).toMatchObject({ state: "failed", iterations: [{ iteration: 0 }] });
});

test("a fit again that is asked for from another step fails there, in words", async () => {
  const startFit = vi.fn().mockResolvedValueOnce({ id: "f1", links: fitLinks("f1") }).mockRejectedValue(new ApiError("The queue is full.", 503));
  const { store, actions } = await withScan({ startFit });
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("done", { result });
  store.set({ step: "points" });
  actions.fit.refit();
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get()).toMatchObject({ step: "points", isStarting: false, problems: { fit: "The queue is full." }, fit: { id: "f1", state: "done" } });
});

test("a fit that cannot be started says so and can be started again", async () => {
  const startFit = vi.fn().mockRejectedValueOnce(new ApiError("The queue is full.", 503)).mockResolvedValue({ id: "f2", links: fitLinks("f2") });
  const { store, actions } = await withScan({ startFit });
  await actions.fit.start();
  expect(store.get()).toMatchObject({ isStarting: false, problems: { fit: "The queue is full." } });
  await actions.fit.start();
  expect(store.get().fit?.id).toBe("f2");
  expect(store.get().problems).toEqual({});
});

test("cancelling asks the service; the end comes as an event like any other", async () => {
  const { store, client, actions } = await withScan();
  await actions.fit.start();
  await actions.fit.cancel();
  expect(client.cancel).toHaveBeenCalledWith("/api/fits/f1/cancel");
  expect(store.get().fit?.state).toBe("running");
  FakeEventSource.last!.say("cancelled", { reason: "The fit was cancelled." });
  expect(store.get().fit?.state).toBe("cancelled");
});

test("another scan ends the following of the fit before", async () => {
  const { store, actions } = await withScan();
  await actions.fit.start();
  const source = FakeEventSource.last!;
  await actions.scan.open("s2", null);
  expect(source.readyState).toBe(2);
  expect(store.get().fit).toBeNull();
});

test("a landmark that is dragged after a fit is fitted again; the model follows it at once, and the fit takes its place when it is done", async () => {
  const startFit = vi.fn(async (...[]: [request: object]) => ({ id: `f${startFit.mock.calls.length}`, links: fitLinks(`f${startFit.mock.calls.length}`) }));
  const { store, client, actions } = await withScan({ startFit });
  const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(1000);
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  actions.landmarks.move("nipple_L", [4, 5, 6]);
  await settle();
  expect(startFit, "before any fit a move is only saved").not.toHaveBeenCalled();
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("done", { result });
  await settle();
  actions.view.overlay("model");
  actions.page.goTo("points");

  actions.landmarks.move("nipple_L", [7, 8, 9]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: { nipple_L: [7, 8, 9] } }));
  await settle();
  expect(client.moved).toHaveBeenLastCalledWith(fitLinks("f1"), { nipple_L: [7, 8, 9] });
  expect(store.get()).toMatchObject({ fit: { id: "f1", state: "done", shown: 0 }, isStarting: true, followed: { fit: "f1" } });
  const second = FakeEventSource.last!;
  second.say("started", { stance: "standing", drawing: "lumpectomy", iterations_limit: 9, notes: [] });
  expect(store.get().fit?.id, "nothing to show yet").toBe("f1");
  second.say("iterated", iterated(1));
  expect(store.get().fit?.id, "the model stands where it has followed the landmark").toBe("f1");
  second.say("done", { result });
  expect(store.get()).toMatchObject({ fit: { id: "f2", shown: 0, started: { iterations_limit: 9 } }, isStarting: false, followed: null, overlay: "model", step: "points" });
  await settle();

  actions.landmarks.move("nipple_L", [8, 8, 9]);
  await settle();
  const third = FakeEventSource.last!;

  actions.landmarks.move("nipple_L", [9, 9, 9]); // while that one runs
  expect(client.cancel).toHaveBeenLastCalledWith("/api/fits/f3/cancel");
  await settle();
  third.say("done", { result });
  expect(store.get().fit?.id, "a fit that was given up reports nothing any more").toBe("f2");
  FakeEventSource.last!.say("iterated", iterated(1));
  FakeEventSource.last!.say("done", { result });
  expect(store.get()).toMatchObject({ fit: { id: "f4", state: "done" }, step: "points" });
  expect(startFit.mock.calls.every(([asked]) => !("start_from" in asked))).toBe(true);
});

test("a run of nudges is two fits: one for the first at once, one for where it ended", async () => {
  const startFit = vi.fn(async () => ({ id: `f${startFit.mock.calls.length}`, links: fitLinks(`f${startFit.mock.calls.length}`) }));
  const { store, client, actions } = await withScan({ startFit });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([0, 0, 0]);
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("done", { result });
  await vi.advanceTimersByTimeAsync(1000);
  for (let i = 1; i <= 10; i += 1) {
    actions.landmarks.move("nipple_L", [i, 0, 0]);
    await vi.advanceTimersByTimeAsync(30);
  }
  await vi.advanceTimersByTimeAsync(1000);
  expect(startFit.mock.calls.length).toBe(3);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: { nipple_L: [10, 0, 0] } }));
  expect(client.cancel).toHaveBeenCalledWith("/api/fits/f2/cancel");
  FakeEventSource.last!.say("failed", { reason: "Too far." });
  expect(store.get()).toMatchObject({ fit: { id: "f1", state: "done" }, isStarting: false, problems: { fit: "Too far." } });
  actions.landmarks.undo();
  await vi.advanceTimersByTimeAsync(1000);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: { nipple_L: [9, 0, 0] } }));
});

test("a fit whose landmarks were moved before the service answered is cancelled and never shown", async () => {
  const answers: ((id: string) => void)[] = [];
  const startFit = vi.fn(() => new Promise<{ id: string; links: ReturnType<typeof fitLinks> }>((done) => answers.push((id) => done({ id, links: fitLinks(id) }))));
  const { store, client, actions } = await withScan({ startFit });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([0, 0, 0]);
  void actions.fit.start();
  answers[0]!("f1");
  await vi.advanceTimersByTimeAsync(1000);
  FakeEventSource.last!.say("done", { result });
  actions.landmarks.move("nipple_L", [1, 0, 0]);
  await vi.advanceTimersByTimeAsync(1000);
  actions.landmarks.move("nipple_L", [2, 0, 0]);
  answers[2]!("f3");
  await vi.advanceTimersByTimeAsync(10);
  answers[1]!("f2");
  await vi.advanceTimersByTimeAsync(10);
  expect(client.cancel).toHaveBeenLastCalledWith("/api/fits/f2/cancel");
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("done", { result });
  expect(store.get().fit?.id).toBe("f3");
});

test("a fit that the address names brings its settings back, and is compared with the landmarks that it was asked with", async () => {
  const fit = async (id: string) => ({ id, links: fitLinks(id), asked_stance: "supine", preset: "paper", drawing: "mastectomy", refine: false, landmarks: { nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] }, certain: [] });
  const landmarks = async () => ({ schema: "breastrig/landmarks@1", unit: "mm", landmarks: { nipple_L: [1, 2, 3], nipple_R: [4, 5, 6], umbilicus: [0, 0, 0] } });
  const { store, actions } = await withScan({ fit, landmarks } as never);
  await actions.fit.open("f1");
  expect(store.get()).toMatchObject({ stance: "supine", preset: "paper", refine: false });
  FakeEventSource.last!.say("done", { result: { ...result, landmarks_picked: { nipple_L: [0.001, 0.002, 0.003] } } });
  expect(outdated(store.get()), "the umbilicus was placed after the fit").toBe("landmarks");
  actions.landmarks.remove("umbilicus");
  expect(outdated(store.get())).toBeNull();
  actions.fit.chooseRefine(true);
  expect(outdated(store.get())).toBe("settings");
});

test("a fit that was done when it was opened is seen as it ended, and can be played again; one that runs is seen to settle", async () => {
  const fit = async (id: string) => ({ id, links: fitLinks(id), state: id === "f1" ? "done" : "running", asked_stance: "auto", preset: "default", drawing: null, refine: true, landmarks: {}, certain: [] });
  const { store, actions } = await withScan({ fit } as never);
  for (const [id, ofOld] of [["f1", true], ["f2", false]] as const) {
    const seen = new Set<string>();
    const leave = store.subscribe(({ overlay }) => seen.add(overlay));
    await actions.fit.open(id);
    for (const i of [0, 1, 2]) FakeEventSource.last!.say("iterated", iterated(i));
    FakeEventSource.last!.say("done", { result });
    if (ofOld) expect(store.get().fit).toMatchObject({ state: "done", shown: 2, playing: false });
    await vi.advanceTimersByTimeAsync(2000);
    expect(store.get().fit).toMatchObject({ state: "done", shown: 2, playing: false });
    expect(store.get().fit!.iterations).toHaveLength(3);
    expect(seen.has("both"), "the model over the scan").toBe(!ofOld);
    leave();
  }
});

test("landmarks that were only agreed to are no change when the fit is opened again, whatever its result says of them", async () => {
  const given = { nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] };
  const fit = async (id: string) => ({ id, links: fitLinks(id), asked_stance: "auto", preset: "default", drawing: null, refine: true, landmarks: given, certain: [] });
  const { store, actions } = await withScan({ fit, landmarks: async () => ({ schema: "breastrig/landmarks@1", unit: "mm", landmarks: given }) } as never);
  await actions.fit.open("f1");
  FakeEventSource.last!.say("done", { result: { ...result, landmarks_picked: { nipple_L: [0.001, 0.002, 0.003] }, landmarks_agreed: ["nipple_R"] } });
  expect(outdated(store.get())).toBeNull();
});

test("what the fit has guessed is confirmed by the same word: the fit that knows it is made at once, and kept", async () => {
  const { store, client, actions } = await withScan();
  await actions.fit.start();
  FakeEventSource.last!.say("done", { result: { ...result, stance: "standing", stance_asked: true } });
  const startFit = vi.spyOn(client, "startFit");
  actions.fit.chooseStance("standing");
  await vi.advanceTimersByTimeAsync(500);
  expect(startFit).toHaveBeenCalledExactlyOnceWith(expect.objectContaining({ stance: "standing" }));
  FakeEventSource.last!.say("done", { result: { ...result, stance: "standing" } });
  expect(outdated(store.get())).toBeNull();
  actions.fit.chooseStance("supine");
  await vi.advanceTimersByTimeAsync(500);
  expect(startFit, "another word is another fit").toHaveBeenLastCalledWith(expect.objectContaining({ stance: "supine" }));
});

test("who listens hears the verdict with the number", async () => {
  const { store, actions } = await withScan();
  await actions.fit.start();
  FakeEventSource.last!.say("done", { result: { ...result, verdict: { level: "check", reasons: ["Half of the body is missing."] } } });
  expect(store.get().announcement).toBe("The fit is done: mean distance 1.2 millimetres. To be checked. Half of the body is missing.");
});
