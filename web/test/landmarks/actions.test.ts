import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { withScan } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { Vector } from "../../src/api/types";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
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

test("undo and redo say which landmarks they changed, and how", async () => {
  const { store, actions } = await withScan();
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  actions.landmarks.move("nipple_L", [4, 5, 6]);
  actions.landmarks.remove("nipple_L");
  const says = (["undo", "undo", "undo", "redo"] as const).map((way) => {
    actions.landmarks[way]();
    return store.get().undone?.says;
  });
  const nipple = "nipple_L, patient's left"; // by its label, which here is its name
  expect(says).toEqual([`Undone: removed ${nipple}.`, `Undone: moved ${nipple}.`, `Undone: placed ${nipple}.`, `Redone: placed ${nipple}.`]);
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
  const { frame, frameFrom } = store.get().scan!;
  expect(frameFrom).toBe("landmarks");
  expect(frame.up[0]).toBeLessThan(-0.97);
});

test("a body that was turned by hand stays as it was turned", async () => {
  const { store, actions } = await withScan();
  actions.scan.turn("sideways");
  const { frame } = store.get().scan!;
  const landmarks = { nipple_L: [0, 100, 0], nipple_R: [0, -100, 0], suprasternal_notch: [-150, 0, 0], umbilicus: [200, 0, 0] };
  await actions.landmarks.importFile(new File([JSON.stringify({ unit: "mm", landmarks })], "landmarks.json"));
  expect(store.get().scan?.frame).toEqual(frame);
});

test("a file that the service cannot read is its own sentence, and nothing is lost", async () => {
  const { store, actions } = await withScan({ landmarkFile: () => Promise.reject(new ApiError("This landmark file is empty; pick landmarks.", 422)) });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await actions.landmarks.importFile(new File([""], "l.csv"));
  expect(store.get()).toMatchObject({ problems: { landmarks: "This landmark file is empty; pick landmarks." }, picks: { present: { nipple_L: [1, 2, 3] } } });
});
