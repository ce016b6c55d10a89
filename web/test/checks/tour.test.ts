// The tour of the points that are worth checking: answers become landmarks in one step, and the page says whether the lines narrowed.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { Checks, PlanLesion, Vector } from "../../src/api/types";
import * as text from "../../src/checks/text";
import { asksOf, narrowing, outcomeWords, stepsOf } from "../../src/checks/state";
import { fingersOf, wideOf } from "../../src/fit/fingers";
import { isUnusable } from "../../src/fit/state";
import { FakeEventSource, type fakePlans, fitLinks, withScan } from "../fakes";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(1000);

const checkOf = (name: string, place: Vector, mm: number): Checks["checks"][number] => ({ name, label: name, side: "L", place, normal: [0, 0, 1], radius_mm: 12, point: { face: 0, barycentric: [1, 0, 0] }, line_error_mm: mm, fingers: 1 });
const worth: Checks = { lines: "breasts", line_error_mm: 24, fingers: 3, expected_line_error_mm: 8, expected_fingers: 1, worth_it: true, checks: [checkOf("nipple_L", [1, 0, 0], 12), checkOf("umbilicus", [0, 0, 0], 8)], reason: null };

/** A fit without landmarks whose lines are 24 mm off, of which the service says so; the next one says what `after` says. */
async function fitted(found: Checks | null = worth) {
  const moved = vi.fn<(links: unknown, picks: unknown) => Promise<{ nodes: never[] }>>(async () => ({ nodes: [] }));
  let started = 0;
  const startFit = async () => ({ id: `f${(started += 1)}`, links: fitLinks(`f${started}`), cuts: "" });
  const made = await withScan({ moved, startFit, checks: vi.fn(async () => found) } as never);
  const done = async (mm: number, more: object = {}): Promise<void> => {
    FakeEventSource.last!.say("iterated", { iteration: 0, stage: "pose", mean_distance_mm: 5, nodes: [] });
    FakeEventSource.last!.say("done", { result: { surface_distance_mm: { mean: 1 }, stance: "standing", refined: true, line_error_mm: mm, ...more } });
    await settle();
  };
  await made.actions.fit.start();
  await done(24);
  return { ...made, moved, done };
}

test("the answers become landmarks in one step that can be undone, certain, and the fit that knows them is made", async () => {
  const { store, actions, done, moved } = await fitted();
  expect(asksOf(store.get())).toEqual({ isKnown: true, count: 2, points: 2, expected: 8, outcome: "" });
  actions.checks.begin();
  expect(store.get().checks.tour).toMatchObject({ at: 0, before: 24 });
  expect(store.get().announcement).toMatch(/^Point 1 of 2: nipple_L\. Is the dot there\? Lines are three fingers wide, ±\s24\smm; then about two fingers wide/);
  actions.checks.move([3, 0, 0]);
  await settle();
  expect(narrowing(store.get()), "the halo shows what is expected").toBe(0.5);
  expect(moved.mock.lastCall![1], "the model follows").toMatchObject({ nipple_L: [3, 0, 0] });
  actions.checks.yes();
  expect(store.get().picks.present, "not before the end").toEqual({});
  actions.checks.yes();
  expect(store.get().picks.present).toEqual({ nipple_L: [3, 0, 0], umbilicus: [0, 0, 0] });
  expect(store.get().picks.past).toHaveLength(1);
  expect(Object.keys(store.get().certain)).toEqual(["nipple_L", "umbilicus"]);
  await settle();
  expect(store.get().checks.tour, "until the fit is there").not.toBeNull();
  await done(9);
  expect(store.get().checks).toMatchObject({ tour: null, outcome: { from: 24, to: 9 } });
  expect(store.get().announcement).toMatch(/have narrowed: they were three fingers wide/);
});

test("what cannot be seen places nothing; with no answer at all nothing is fitted", async () => {
  const { store, actions } = await fitted();
  const { fit } = store.get();
  actions.checks.begin();
  actions.checks.unseen();
  actions.checks.unseen();
  await settle();
  expect(store.get()).toMatchObject({ checks: { tour: null, outcome: null }, isStarting: false, announcement: "Nothing was checked; the lines are as they were." });
  expect(store.get().picks.present).toEqual({});
  expect(store.get().fit!.id).toBe(fit!.id);
});

test("who leaves keeps what was answered, and drops what was only moved", async () => {
  const { store, actions, done } = await fitted();
  actions.checks.begin();
  actions.checks.move([5, 0, 0]);
  actions.checks.leave();
  expect([store.get().checks.tour, store.get().picks.present, store.get().followed]).toEqual([null, {}, null]);
  actions.checks.begin();
  actions.checks.yes();
  actions.checks.leave();
  expect(store.get().picks.present).toEqual({ nipple_L: [1, 0, 0] });
  await settle();
  await done(25);
  expect(store.get().announcement, "it is said that nothing was gained").toMatch(/have not narrowed: they are three fingers wide/);
});

test("while points are checked the scan is seen alone, and afterwards what was seen before", async () => {
  const { store, actions } = await fitted();
  store.set({ overlay: "both" });
  actions.checks.begin();
  expect(store.get().overlay).toBe("scan");
  actions.checks.leave();
  expect(store.get().overlay).toBe("both");
});

test("a tour that does not pay is not offered, nor one on a fit that cannot be used", async () => {
  const { store } = await fitted({ ...worth, worth_it: false });
  expect(stepsOf(store.get())).toEqual([]);
  const { store: other, done, actions } = await fitted();
  await actions.fit.start();
  await done(24, { verdict: { level: "unusable", reasons: ["No skin."] } });
  expect(isUnusable(other.get())).toBe(true);
  expect(stepsOf(other.get())).toEqual([]);
});

test("as soon as the plan changes its checks are awaited; they are asked for when it rests and is saved", async () => {
  const { store, actions, client } = await fitted();
  const asked = vi.mocked(client.checks);
  expect([asked.mock.calls.length, store.get().checks.awaited.size]).toEqual([1, 0]);
  for (const depth of [3, 4]) {
    actions.plan.lesions([{ id: "a", name: "Lesion 1", scan: "s1", center: [0, 0, -depth], radius_mm: 5 } as unknown as PlanLesion]);
    await Promise.resolve();
    await Promise.resolve();
    expect([...store.get().checks.awaited]).toEqual([store.get().fit!.id]);
    await vi.advanceTimersByTimeAsync(100);
  }
  actions.checks.begin();
  expect(store.get().checks.tour, "the points of these lines are not known yet").toBeNull();
  await settle();
  expect(asked).toHaveBeenCalledTimes(2);
  expect((client as unknown as ReturnType<typeof fakePlans>).savePlan.mock.invocationCallOrder[0]).toBeLessThan(asked.mock.invocationCallOrder[1]!);
  expect(store.get().checks.awaited.size).toBe(0);
  expect(store.get().checks.tour, "the tour that was asked for has begun").not.toBeNull();
  store.set(({ drawn }) => ({ drawn: { ...drawn, note: "no line of it" } }));
  await settle();
  expect(asked, "words narrow nothing").toHaveBeenCalledTimes(2);
});

test("the button names the other scan in as few words as its own", () => {
  expect([text.checks.begin(3, ""), text.checks.begin(1, "standing 2"), text.checks.begin(3, "supine")]).toEqual(["Check 3 points", "Check 1 standing 2 point", "Check 3 supine points"]);
});

test("a width is counted in fingers", () => {
  expect([0, 10, 10.1, 20, 20.1, 60, 61, null].map(fingersOf)).toEqual([1, 1, 2, 2, 3, 3, null, null]);
  expect(wideOf(12)).toBe("two fingers wide");
  expect(outcomeWords({ fit: "f", from: 12.2, to: 11.8 }), "less than a millimetre is nothing").toMatch(/have not narrowed/);
});
