import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { page } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { ProposedLandmark, ProposedLandmarks, Vector } from "../../src/api/types";
import { nextStep } from "../../src/app/nextStep";
import { certainNames } from "../../src/landmarks/certain";
import { isLookedAt, onlyAgreed } from "../../src/landmarks/proposals/agreed";
import { errorOf, isLikely, isSeen, openProposals } from "../../src/landmarks/proposals/proposals";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const at = (point: Vector, error_mm: number | null = 16, on_scan = true): ProposedLandmark => ({ point, confidence: 0.5, on_scan, error_mm });
const landmarks = { nipple_L: at([90, 0, 0]), nipple_R: at([-90, 0, 0]), umbilicus: at([0, -200, 0], 58), suprasternal_notch: at([0, 200, 0], 12, false) };

async function found(...rest: Parameters<typeof page>) {
  const made = page({ proposed: async () => ({ landmarks, not_proposed: {} }), ...rest[0] });
  await made.actions.scan.open("s1", null);
  made.actions.page.goTo("points");
  await vi.advanceTimersByTimeAsync(0);
  return made;
}

test("a proposal is labelled by the service's own radius, and nothing is made up where there is none", () => {
  expect(errorOf(at([0, 0, 0], 15.6))).toBe("16");
  expect(errorOf(at([0, 0, 0], null))).toBeNull();
  expect(isLikely({ ...at([0, 0, 0], null) })).toBe(false);
  expect(isLikely(at([0, 0, 0], 380))).toBe(false);
  expect([isLikely(at([0, 0, 0], 14)), isSeen(at([0, 0, 0], 14))]).toEqual([true, false]);
});

test("proposals come when landmarks are the matter, stay open, and go into no fit", async () => {
  const startFit = vi.fn(async () => Promise.reject(new ApiError("busy", 503)));
  const { store, client, actions } = await found({ startFit });
  expect(openProposals(store.get().proposals, store.get().picks.present).length).toBe(4);
  expect(store.get().picks.present).toEqual({});
  await actions.fit.start();
  expect(startFit).toHaveBeenCalledWith(expect.objectContaining({ landmarks: {} }));
  await vi.advanceTimersByTimeAsync(1000);
  expect(client.saveLandmarks).not.toHaveBeenCalled();
});

test("the primary button takes those that colour shows; then it fits, and whoever wants to checks the others one by one", async () => {
  const seen = { ...landmarks, nipple_L: at([90, 0, 0], 4), nipple_R: at([-90, 0, 0], 5) };
  const { store, actions } = await found({ proposed: vi.fn().mockResolvedValue({ landmarks: seen, not_proposed: {} }) });
  const next = nextStep(store.get());
  expect(next).toEqual({ kind: "confirm", names: ["nipple_L", "nipple_R"] });
  if (next.kind === "confirm") actions.landmarks.confirm(next.names);
  expect(store.get().picks.present).toEqual({ nipple_L: [90, 0, 0], nipple_R: [-90, 0, 0] });
  expect(nextStep(store.get())).toEqual({ kind: "fit", again: false, landmarks: 2, isProposed: true });
  actions.landmarks.wantNext();
  expect(nextStep(store.get()).kind).toBe("place");
});

test("what only the form proposes becomes no pick by one press for all: the fit finds it by itself", async () => {
  const { store } = await found();
  expect(nextStep(store.get())).toEqual({ kind: "fit", again: false, landmarks: 0, isProposed: true });
});

test("confirming is one step of the history and is saved; undone, the proposals are open again", async () => {
  const { store, client, actions } = await found();
  actions.landmarks.confirm(Object.keys(landmarks));
  expect(Object.keys(store.get().picks.present).length).toBe(4);
  await vi.advanceTimersByTimeAsync(500);
  expect(vi.mocked(client.saveLandmarks).mock.lastCall![1].landmarks).toMatchObject({ umbilicus: [0, -200, 0] });
  actions.landmarks.undo();
  expect(store.get().picks.present).toEqual({});
  expect(openProposals(store.get().proposals, {}).length).toBe(4);
});

test("the wanted landmark's proposal is taken by key, and the next one is wanted", async () => {
  const { store, actions } = await found();
  actions.landmarks.want("nipple_L");
  actions.landmarks.confirmWanted();
  expect(store.get()).toMatchObject({ active: "nipple_R", picks: { present: { nipple_L: [90, 0, 0] } } });
});

test("a placed landmark is never moved by its proposal", async () => {
  const { store, actions } = await found();
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  actions.landmarks.confirm(["nipple_L"]);
  expect(store.get().picks.present.nipple_L).toEqual([1, 2, 3]);
});

test("while the service still looks, it is asked again after the time that it names", async () => {
  const proposed = vi.fn().mockResolvedValueOnce({ retryAfterS: 2 }).mockResolvedValue({ landmarks });
  const { store } = await found({ proposed });
  expect(store.get().proposals).toEqual({ state: "looking" });
  await vi.advanceTimersByTimeAsync(2000);
  expect(store.get().proposals?.state).toBe("found");
  expect(proposed).toHaveBeenCalledTimes(2);
});

test("a refusal is shown with its reason, not asked again by itself, but on request", async () => {
  const proposed = vi.fn().mockRejectedValueOnce(new ApiError("The scan shows no torso.", 422)).mockResolvedValue({ landmarks });
  const { store, actions } = await found({ proposed });
  expect(store.get().proposals).toEqual({ state: "none", reason: "The scan shows no torso." });
  actions.landmarks.want("nipple_L");
  expect(proposed).toHaveBeenCalledTimes(1);
  await actions.proposals.look();
  expect(store.get().proposals?.state).toBe("found");
});

test("proposals for a scan that has gone are dropped", async () => {
  let late: (answer: ProposedLandmarks) => void = () => undefined;
  const { store, actions } = await found({ proposed: () => new Promise((done) => (late = done)) });
  await actions.scan.open("s2", null);
  late({ unit: "mm", landmarks, not_proposed: {} });
  await vi.advanceTimersByTimeAsync(0);
  expect(store.get().proposals).toBeNull();
});

test("proposals that come late say only what is open still, and nothing over what was said meanwhile", async () => {
  const proposed = async () => {
    await new Promise((done) => setTimeout(done, 3000));
    return { landmarks, not_proposed: {} };
  };
  const made = page({ proposed });
  await made.actions.scan.open("s1", null);
  made.actions.page.goTo("points");
  for (const [name, { point }] of Object.entries(landmarks)) {
    made.actions.landmarks.want(name);
    made.actions.landmarks.place(point);
  }
  made.store.set({ announcement: "Please check: one landmark." });
  await vi.advanceTimersByTimeAsync(3000);
  expect(made.store.get().proposals?.state).toBe("found");
  expect(made.store.get().announcement).toBe("Please check: one landmark.");
});

test("agreeing is weak: the pick stays unsure until it is moved, or confirmed where it is looked at closely", async () => {
  const { store, client, actions } = await found();
  const saved = () => vi.mocked(client.saveLandmarks).mock.lastCall![1];
  actions.landmarks.confirm(["nipple_L", "nipple_R"]);
  expect(onlyAgreed(store.get())).toEqual({ nipple_L: 0.5, nipple_R: 0.5 });
  actions.landmarks.move("nipple_R", [-90, 0.5, 0]);
  expect(onlyAgreed(store.get())).toEqual({ nipple_L: 0.5 });
  actions.landmarks.want("nipple_L");
  actions.landmarks.confirmWanted();
  expect(store.get().announcement).toMatch(/^Zoom in until single millimetres show/);
  expect(onlyAgreed(store.get())).toEqual({ nipple_L: 0.5 });
  actions.landmarks.seenBy(() => true);
  actions.landmarks.confirmWanted();
  expect(onlyAgreed(store.get())).toEqual({});
  await vi.advanceTimersByTimeAsync(500);
  expect(saved().certain).toEqual(["nipple_L"]);
  actions.landmarks.unkeep("nipple_L");
  expect(onlyAgreed(store.get()), "what is taken back is agreed to again").toEqual({ nipple_L: 0.5 });
});

test("a point that is felt and not seen stays agreed to however near the eye is", async () => {
  const { store, actions } = await found({ proposed: async () => ({ landmarks: { acromion_L: at([150, 200, 0]), nipple_L: at([90, 0, 0]) }, not_proposed: {} }) });
  actions.landmarks.seenBy(() => true);
  actions.landmarks.confirm(["acromion_L", "nipple_L"]);
  expect(onlyAgreed(store.get())).toEqual({ acromion_L: 0.5 });
  const { picks, certain } = store.get();
  expect(certainNames(picks.present, certain)).toEqual(["nipple_L"]);
  expect([isLookedAt(2600), isLookedAt(8000)]).toEqual([false, true]);
});
