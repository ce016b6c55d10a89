import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { FakeEventSource, fitLinks, page, scanInfo } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { Scan, Vector } from "../../src/api/types";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const file = (name = "scan.ply"): File => new File(["ply"], name);
const iterated = (iteration: number) => ({ iteration, stage: "pose", mean_distance_mm: 5 - iteration, nodes: [] });
const result = { surface_distance_mm: { mean: 1.2 }, scan: { unit: "m" }, landmarks: {} };

async function withScan(...rest: Parameters<typeof page>) {
  const made = page(...rest);
  await made.actions.scan.open("s1", null);
  return made;
}

test("an upload brings the scan, and its progress is shown on the way", async () => {
  const phases: (string | undefined)[] = [];
  const { store, actions } = page({
    upload: async (_file, _units, progress) => {
      progress(0.5);
      progress(1);
      return scanInfo("s2");
    },
  });
  store.subscribe((state) => phases.push(state.loading?.phase));
  await actions.scan.upload(file());
  expect(store.get().scan?.info.id).toBe("s2");
  expect(new Set(phases)).toEqual(new Set([undefined, "preparing", "sending"]));
  expect(store.get().loading).toBeNull();
});

test("a refused upload says why and leaves the scan before it, with its landmarks, where it was", async () => {
  const { store, actions } = await withScan({
    upload: () => Promise.reject(new ApiError("The file holds no triangles.", 422)),
  });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await actions.scan.upload(file());
  expect(store.get().problems.scan).toBe("The file holds no triangles.");
  expect(store.get().scan?.info.id).toBe("s1");
  expect(store.get().picks.present).toEqual({ nipple_L: [1, 2, 3] });
});

test("a file of another kind is not even sent", async () => {
  const upload = vi.fn();
  const { store, actions } = page({ upload });
  await actions.scan.upload(file("holiday.jpg"));
  expect(upload).not.toHaveBeenCalled();
  expect(store.get().problems.scan).toContain("holiday.jpg");
});

test("the scan asked for last wins over a slower, earlier one", async () => {
  let slow: (scan: Scan) => void = () => undefined;
  const { store, actions } = page({ upload: () => new Promise((done) => (slow = done)) });
  const first = actions.scan.upload(file());
  await actions.scan.open("s9", null);
  slow(scanInfo("late"));
  await first;
  expect(store.get().scan?.info.id).toBe("s9");
});

test("placing goes on to the next landmark and saves once for a run of clicks", async () => {
  const { store, client, actions } = await withScan();
  actions.landmarks.want("suprasternal_notch");
  actions.landmarks.place([0, 300, 0]);
  actions.landmarks.place([90, 100, 0]);
  expect(store.get().active).toBe("nipple_R");
  expect(store.get().saving).toBe("unsaved");
  await vi.advanceTimersByTimeAsync(500);
  expect(client.saveLandmarks).toHaveBeenCalledTimes(1);
  expect(vi.mocked(client.saveLandmarks).mock.calls[0]![1]).toMatchObject({
    unit: "mm",
    landmarks: { suprasternal_notch: [0, 300, 0], nipple_L: [90, 100, 0] },
  });
  expect(store.get().saving).toBe("saved");
});

test("a failed save is said, loses nothing, and can be tried again", async () => {
  const saveLandmarks = vi.fn().mockRejectedValueOnce(new ApiError("The service does not answer.", 0)).mockResolvedValue({});
  const { store, actions } = await withScan({ saveLandmarks });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get()).toMatchObject({ saving: "unsaved", problems: { landmarks: "The service does not answer." } });
  expect(store.get().picks.present).toEqual({ nipple_L: [1, 2, 3] });
  await actions.landmarks.saveNow();
  expect(store.get()).toMatchObject({ saving: "saved", problems: {} });
});

test("a landmark placed just before another scan comes is still saved with its own scan", async () => {
  const { client, actions } = await withScan();
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await actions.scan.open("s2", null);
  actions.landmarks.want("umbilicus");
  actions.landmarks.place([4, 5, 6]);
  await vi.advanceTimersByTimeAsync(500);
  const saved = vi.mocked(client.saveLandmarks).mock.calls.map(([scan, sent]) => [scan.id, sent.landmarks]);
  expect(saved).toEqual([
    ["s1", { nipple_L: [1, 2, 3] }],
    ["s2", { umbilicus: [4, 5, 6] }],
  ]);
});

test("skipped landmarks are passed over, and undo and redo are saved as well", async () => {
  const { store, client, actions } = await withScan();
  actions.landmarks.wantNext();
  actions.landmarks.skip();
  expect(store.get().active).toBe("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  actions.landmarks.undo();
  await vi.advanceTimersByTimeAsync(500);
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1].landmarks).toEqual({});
  actions.landmarks.redo();
  await vi.advanceTimersByTimeAsync(500);
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1].landmarks).toEqual({ nipple_L: [1, 2, 3] });
});

test("imported landmarks join the placed ones and stand the body upright", async () => {
  const { store, actions } = await withScan();
  const landmarks: Record<string, Vector> = {
    nipple_L: [0, 100, 0],
    nipple_R: [0, -100, 0],
    suprasternal_notch: [-150, 0, 0],
    umbilicus: [200, 0, 0],
  };
  await actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks })], "landmarks.json"));
  expect(Object.keys(store.get().picks.present).length).toBe(4);
  expect(store.get().scan).toMatchObject({ frameFrom: "landmarks", frame: { up: [-1, 0, 0] } });
});

test("a body that was turned by hand stays as it was turned", async () => {
  const { store, actions } = await withScan();
  actions.scan.turn("sideways");
  const { frame } = store.get().scan!;
  const landmarks = { nipple_L: [0, 100, 0], nipple_R: [0, -100, 0], suprasternal_notch: [-150, 0, 0], umbilicus: [200, 0, 0] };
  await actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks })], "landmarks.json"));
  expect(store.get().scan?.frame).toEqual(frame);
});

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
    preset: "default",
    drawing: "lumpectomy",
    refine: true,
    landmarks: { nipple_L: [1, 2, 3] },
  });
  const source = FakeEventSource.last!;
  expect(source.url).toBe("/api/fits/f1/events");
  source.say("started", { stance: "standing", drawing: "lumpectomy", iterations_limit: 40, notes: [] });
  source.say("iterated", iterated(0));
  source.say("iterated", iterated(1));
  source.say("done", { result });
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get().fit).toMatchObject({ state: "done", shown: 1, playing: false, result, drawing: { shapes: [] } });
  expect(store.get().step).toBe("result");
});

test("a fit that fails says why where it was started, and its iterations stay", async () => {
  const { store, actions } = await withScan();
  await actions.fit.start();
  FakeEventSource.last!.say("iterated", iterated(0));
  FakeEventSource.last!.say("failed", { reason: "No start was found." });
  expect(store.get()).toMatchObject({ step: "fit", problems: { fit: "No start was found." } });
  expect(store.get().fit).toMatchObject({ state: "failed", iterations: [{ iteration: 0 }] });
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

test("a landmark that is dragged after a fit is fitted again from there; the picture of the one before stays until the new one has its own", async () => {
  const startFit = vi.fn(async () => ({ id: `f${startFit.mock.calls.length}`, links: fitLinks(`f${startFit.mock.calls.length}`) }));
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
  actions.view.overlay("swipe");
  actions.page.goTo("landmarks");

  actions.landmarks.move("nipple_L", [7, 8, 9]);
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: { nipple_L: [7, 8, 9] }, start_from: "f1" }));
  await settle();
  expect(store.get()).toMatchObject({ fit: { id: "f1", state: "done", shown: 0 }, isStarting: true });
  const second = FakeEventSource.last!;
  second.say("started", { stance: "standing", drawing: "lumpectomy", iterations_limit: 9, notes: [] });
  expect(store.get().fit?.id, "nothing to show yet").toBe("f1");
  second.say("iterated", iterated(1));
  expect(store.get()).toMatchObject({ fit: { id: "f2", shown: 0, started: { iterations_limit: 9 } }, isStarting: false, overlay: "swipe", step: "landmarks" });

  actions.landmarks.move("nipple_L", [9, 9, 9]); // while that one runs
  expect(client.cancel).toHaveBeenLastCalledWith("/api/fits/f2/cancel");
  await settle();
  second.say("iterated", iterated(2));
  expect(store.get().fit?.iterations.length, "a fit that was given up reports nothing any more").toBe(1);
  FakeEventSource.last!.say("iterated", iterated(1));
  FakeEventSource.last!.say("done", { result });
  expect(store.get()).toMatchObject({ fit: { id: "f3", state: "done" }, step: "landmarks" });
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ start_from: "f1" }));
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
  expect(startFit).toHaveBeenLastCalledWith(expect.objectContaining({ landmarks: { nipple_L: [9, 0, 0] }, start_from: "f1" }));
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
  expect(store.get().fit?.id).toBe("f3");
});
