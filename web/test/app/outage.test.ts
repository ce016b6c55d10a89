// The service is away, or the session has ended, while somebody types and draws: nothing of it is lost, all of it is saved by itself.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fakePlans, memory, NAMES, page, scanInfo } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { Cut, Cuts, LandmarkFile, Scan, StoredLandmarks } from "../../src/api/types";
import { lineAlong } from "../../src/drawing/lines/edits";
import { drawingOn, linesOn, noteOn } from "../../src/plan/items";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const TUMOUR = "tumour:side=R,clock=3,distance_mm=30,radius_mm=10";
const PLAN = scanInfo("s1").links.plan;
const CROP = { toPicture: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], lasso: [[0, 0], [1, 0], [0, 1]] as [number, number][] };

/** A service that can be taken away. */
function service() {
  const plans = fakePlans();
  const kept = { landmarks: { schema: "breastrig/landmarks@1", unit: "mm", landmarks: {}, seen: "0" } as StoredLandmarks, cuts: [] as readonly Cut[] };
  let trouble: ApiError | null = null;
  const up = <Given extends readonly unknown[], Answer>(ask: (...given: Given) => Promise<Answer>) =>
    async (...given: Given): Promise<Answer> => {
      if (trouble) throw trouble;
      return ask(...given);
    };
  const cuts = (): Cuts => ({ cuts: [...kept.cuts], digest: JSON.stringify(kept.cuts) });
  const client = {
    plan: up(plans.plan),
    savePlan: up(plans.savePlan),
    landmarks: up(async () => structuredClone(kept.landmarks)),
    saveLandmarks: up(async (_scan: Pick<Scan, "id">, file: LandmarkFile, seen: string | null) => {
      if (seen !== null && seen !== kept.landmarks.seen) throw new ApiError("Changed.", 412);
      kept.landmarks = { ...structuredClone(file), seen: String(Number(kept.landmarks.seen) + 1) };
      return structuredClone(kept.landmarks);
    }),
    cuts: up(async () => cuts()),
    saveCuts: up(async (_scan: Pick<Scan, "id">, wanted: readonly Cut[], seen: string) => {
      if (seen !== cuts().digest) throw new ApiError("Changed.", 412);
      kept.cuts = wanted;
      return cuts();
    }),
  };
  return {
    client,
    away: (error: ApiError | null) => (trouble = error),
    has: async () => {
      const { items } = await plans.plan(PLAN);
      return { lines: linesOn(items, "s1").map(({ name }) => name), drawing: drawingOn(items, "s1"), note: noteOn(items, "s1"), depth: items.find(({ kind }) => kind === "tumour"), landmarks: Object.keys(kept.landmarks.landmarks), cuts: kept.cuts.length };
    },
    versions: async () => (await plans.plan(PLAN)).version,
  };
}

type Page = ReturnType<typeof page>;

function work({ actions }: Page): void {
  actions.landmarks.want(NAMES[1]!);
  actions.landmarks.place([1, 2, 3]);
  actions.drawing.restore([{ ...lineAlong("Line 1", "#101010", [[0, 0, 0], [9, 0, 0]], false), id: "line-one" }]);
  actions.drawing.choosePattern(`reduction:areola_mm=42+${TUMOUR}`);
  actions.plan.depth(25);
  actions.plan.note("wants it smaller");
  actions.scan.crop(CROP);
}

const ALL = { lines: ["Line 1"], drawing: `reduction:areola_mm=42+${TUMOUR}`, note: "wants it smaller", landmarks: [NAMES[1]], cuts: 1 };
const NONE = { lines: [], drawing: "", note: "", landmarks: [], cuts: 0 };

test.each([
  ["the service is away", new ApiError("The service does not answer.", 0)],
  ["its disk is full", new ApiError("The disk is full.", 507)],
])("%s: it is said, kept in the tab, tried again by itself and saved", async (_why, error) => {
  const { client, away, has } = service();
  const made = page(client);
  await made.actions.scan.open("s1", null);
  away(error);
  work(made);
  await vi.advanceTimersByTimeAsync(500);
  expect(made.store.get().unsaved).toEqual({ what: ["cuts", "lines", "landmarks"], why: error.message, isFull: false });
  expect(made.store.get()).toMatchObject({ saving: "unsaved", drawn: { saving: "unsaved" } });
  expect(made.tab.length).toBe(3);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(await has()).toMatchObject(NONE);
  away(null);
  await vi.advanceTimersByTimeAsync(31_000);
  expect(await has()).toMatchObject(ALL);
  expect((await has()).depth).toMatchObject({ depth_mm: 25, clock: 3 });
  expect(made.store.get()).toMatchObject({ unsaved: null, saving: "saved", announcement: "Everything is saved.", drawn: { saving: "saved" } });
  expect(made.tab.length, "nothing of a patient stays in the browser").toBe(0);
});

test("as soon as the browser is online again it is tried at once, and what cannot pass by itself is not tried again and again", async () => {
  const { client, away, has } = service();
  const made = page(client);
  await made.actions.scan.open("s1", null);
  const savePlan = vi.spyOn(made.client, "savePlan");
  away(new ApiError("The service does not answer.", 0));
  work(made);
  await vi.advanceTimersByTimeAsync(120_000);
  away(null);
  made.actions.unsaved.soon();
  await vi.advanceTimersByTimeAsync(0);
  expect(await has()).toMatchObject(ALL);
  away(new ApiError("A note has 2000 letters at most.", 422));
  savePlan.mockClear();
  made.actions.plan.note("long");
  await vi.advanceTimersByTimeAsync(120_000);
  expect(savePlan).toHaveBeenCalledTimes(1);
  expect(made.store.get().unsaved).toMatchObject({ what: ["lines"], why: "A note has 2000 letters at most." });
});

test("a reload and a sign-in in between: the page shows it again and saves it, with what another tab has done meanwhile", async () => {
  const { client, away, has } = service();
  const tab = memory();
  const made = page(client, tab);
  const other = page(client);
  await made.actions.scan.open("s1", null);
  await other.actions.scan.open("s1", null);
  away(new ApiError("Sign in.", 401));
  work(made);
  await vi.advanceTimersByTimeAsync(500);
  vi.clearAllTimers(); // the page is gone
  away(null);
  other.actions.plan.note("theirs");
  other.actions.landmarks.want(NAMES[2]!);
  other.actions.landmarks.place([4, 5, 6]);
  await vi.advanceTimersByTimeAsync(1000);

  const again = page(client, tab);
  await again.actions.scan.open("s1", null);
  expect(again.store.get()).toMatchObject({ drawing: ALL.drawing, drawn: { note: "wants it smaller\ntheirs", depthMm: 25 } });
  await vi.advanceTimersByTimeAsync(1000);
  expect(await has()).toMatchObject({ ...ALL, note: "wants it smaller\ntheirs", landmarks: [NAMES[1], NAMES[2]] });
  expect(again.store.get()).toMatchObject({ saving: "saved", drawn: { saving: "saved" } });
  expect(again.store.get().problems.landmarks).toContain("another tab");
  expect(tab.length).toBe(0);
});

test("what was typed on a scan that is not opened again is saved all the same", async () => {
  const { client, away, has } = service();
  const tab = memory();
  const made = page(client, tab);
  await made.actions.scan.open("s1", null);
  away(new ApiError("The service does not answer.", 0));
  work(made);
  await vi.advanceTimersByTimeAsync(500);
  vi.clearAllTimers(); // the page is gone
  const again = page(client, tab); // the list of patients
  away(null);
  await again.actions.unsaved.now();
  expect(await has()).toMatchObject(ALL);
  expect(tab.length).toBe(0);
});

test("the stance that waits is saved as well, and is said to be", async () => {
  const { client, away, has } = service();
  const made = page(client);
  await made.actions.scan.open("s1", null);
  away(new ApiError("The service does not answer.", 0));
  work(made);
  await vi.advanceTimersByTimeAsync(500);
  made.store.set((state) => ({ scan: { ...state.scan!, info: scanInfo("s2") }, stances: { ...state.stances, other: { ...state, scan: state.scan } } })); // as when the other pane is tapped
  away(null);
  await vi.advanceTimersByTimeAsync(31_000);
  expect(await has()).toMatchObject(ALL);
  expect(made.store.get().stances.other).toMatchObject({ saving: "saved", drawn: { saving: "saved" } });
});

test("two tabs that gave the same pattern other numbers: the page asks which stay", async () => {
  const { client, away, has } = service();
  const [mine, theirs] = [page(client), page(client)];
  for (const each of [mine, theirs]) await each.actions.scan.open("s1", null);
  away(new ApiError("The service does not answer.", 0));
  mine.actions.drawing.choosePattern("reduction:areola_mm=40");
  await vi.advanceTimersByTimeAsync(100);
  away(null);
  theirs.actions.drawing.choosePattern("reduction:areola_mm=44");
  await vi.advanceTimersByTimeAsync(31_000);
  expect(mine.store.get()).toMatchObject({ drawing: "reduction:areola_mm=40", drawn: { saving: "saved", contested: { drawing: "reduction:areola_mm=44" } } });
  mine.actions.plan.settle(true);
  await vi.advanceTimersByTimeAsync(100);
  expect(await has()).toMatchObject({ drawing: "reduction:areola_mm=44" });
  expect(mine.store.get().drawn.contested).toBeNull();
});

test.each(["the scan is deleted", "the patient is deleted", "somebody signs out", "it is left without saving", "the service has the scan no more"])("nothing is kept when %s", async (how) => {
  const { client, away } = service();
  vi.stubGlobal("location", { assign: () => undefined });
  const made = page({ ...client, deletePatient: vi.fn(), signOut: vi.fn() });
  const { actions, tab } = made;
  await actions.scan.open("s1", null);
  away(new ApiError("The service does not answer.", 0));
  work(made);
  await vi.advanceTimersByTimeAsync(500);
  expect(tab.length).toBe(3);
  if (how === "the scan is deleted") {
    await actions.deletion.confirm();
    await actions.deletion.send();
  } else if (how === "the patient is deleted") {
    actions.patients.remove("of-s1");
    await vi.advanceTimersByTimeAsync(11_000);
  } else if (how === "the service has the scan no more") {
    away(new ApiError("This scan is not there.", 404));
    await vi.advanceTimersByTimeAsync(31_000);
  } else {
    void (how === "somebody signs out" ? actions.signOut() : actions.scan.leave());
    await vi.advanceTimersByTimeAsync(0);
    expect(made.store.get().leaving).toEqual(["landmarks", "lines"]);
    actions.leaving.leaveAnyhow();
    await vi.advanceTimersByTimeAsync(0);
  }
  expect(tab.length).toBe(0);
});
