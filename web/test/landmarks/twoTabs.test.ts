// Two tabs that place landmarks on one scan: neither loses its picks, and each is told of the other's.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { memory, scanInfo, withScan } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { LandmarkFile, Scan, StoredLandmarks, Vector } from "../../src/api/types";

type Named = Pick<Scan, "id" | "links">;

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

/** A service that keeps landmarks, and refuses those that were not changed from the newest. */
function service() {
  const kept = new Map<string, StoredLandmarks>();
  const landmarks = async ({ id }: Named): Promise<StoredLandmarks> => structuredClone(kept.get(id) ?? { schema: "breastrig/landmarks@1", unit: "mm", landmarks: {}, certain: [], seen: "" });
  const saveLandmarks = vi.fn(async (scan: Named, file: LandmarkFile, seen: string | null): Promise<StoredLandmarks> => {
    if (seen !== null && seen !== (kept.get(scan.id)?.seen ?? "")) throw new ApiError("Somebody has changed these landmarks.", 412);
    const stored = { ...structuredClone(file), seen: JSON.stringify(file) };
    kept.set(scan.id, stored);
    return structuredClone(stored);
  });
  return { landmarks, saveLandmarks, placed: () => kept.get("s1")!.landmarks, certain: () => kept.get("s1")!.certain };
}

type Page = Awaited<ReturnType<typeof withScan>>;

function place({ actions }: Page, name: string, at: [number, number, number]): void {
  actions.landmarks.want(name);
  actions.landmarks.place(at);
}

const pause = (): Promise<unknown> => vi.advanceTimersByTimeAsync(500);

async function twoTabs() {
  const kept = service();
  const one = await withScan(kept);
  const two = await withScan(kept);
  return { kept, one, two };
}

test("different landmarks of two tabs are both kept, shown by the later one, and said", async () => {
  const { kept, one, two } = await twoTabs();
  place(one, "nipple_L", [1, 2, 3]);
  await pause();
  place(two, "nipple_R", [4, 5, 6]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] });
  expect(two.store.get()).toMatchObject({ saving: "saved", picks: { present: { nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] } } });
  expect(two.store.get().problems.landmarks).toBe("Changed in another tab or by somebody else, and shown here now: nipple_L, patient's left.");
  expect(two.store.get().announcement).toBe(two.store.get().problems.landmarks);

  two.actions.landmarks.undo();
  await pause();
  expect(kept.placed(), "undo takes back what was done here alone").toEqual({ nipple_L: [1, 2, 3] });

  await one.actions.landmarks.look();
  expect(one.store.get().problems.landmarks, "there is nothing new").toBeUndefined();
  place(two, "umbilicus", [7, 8, 9]);
  await pause();
  await one.actions.landmarks.look();
  expect(one.store.get().picks.present, "who comes back to the first tab has them too").toEqual({ nipple_L: [1, 2, 3], umbilicus: [7, 8, 9] });
  place(one, "suprasternal_notch", [0, 1, 0]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3], umbilicus: [7, 8, 9], suprasternal_notch: [0, 1, 0] });
});

test("of one landmark the later hand stays and the page says so; undo brings the other's place", async () => {
  const { kept, one, two } = await twoTabs();
  place(one, "nipple_L", [1, 2, 3]);
  await pause();
  place(two, "nipple_L", [2, 2, 2]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [2, 2, 2] });
  expect(two.store.get().problems.landmarks).toBe("Changed in another tab or by somebody else as well: nipple_L, patient's left. What was done here last counts.");
  two.actions.landmarks.undo();
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3] });
  await one.actions.landmarks.look();
  expect(one.store.get().picks.present).toEqual({ nipple_L: [1, 2, 3] });
});

test("what one tab takes out stays out, and certainty is brought together as well", async () => {
  const kept = service();
  const first = await withScan(kept);
  for (const [i, name] of ["nipple_L", "nipple_R", "umbilicus"].entries()) place(first, name, [i, i, i]);
  await pause();
  const one = await withScan(kept);
  const two = await withScan(kept);
  one.actions.landmarks.remove("nipple_R");
  one.actions.landmarks.keep(["umbilicus"]);
  await pause();
  two.actions.landmarks.move("nipple_L", [9, 9, 9]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [9, 9, 9], umbilicus: [2, 2, 2] });
  expect(kept.certain()).toEqual(["umbilicus"]);
  expect(two.store.get().certain).toEqual({ umbilicus: [2, 2, 2] });
});

test("what is placed while another's is being brought in is lost by neither", async () => {
  const { kept, one, two } = await twoTabs();
  place(one, "nipple_L", [1, 2, 3]);
  await pause();
  place(two, "nipple_R", [4, 5, 6]);
  vi.advanceTimersByTime(450); // on its way
  place(two, "umbilicus", [7, 8, 9]);
  await pause();
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3], nipple_R: [4, 5, 6], umbilicus: [7, 8, 9] });
  expect(two.store.get().saving).toBe("saved");
});

test("picks of a scan that was left are brought together too, and again when it comes back", async () => {
  const { kept, one, two } = await twoTabs();
  place(one, "nipple_L", [1, 2, 3]);
  await pause();
  place(two, "nipple_R", [4, 5, 6]);
  await two.actions.scan.open("s2", null);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] });
  expect(two.store.get().problems.landmarks).toBeUndefined();
  await two.actions.scan.open("s1", null);
  two.actions.landmarks.remove("nipple_L");
  await pause();
  expect(kept.placed()).toEqual({ nipple_R: [4, 5, 6] });
});

/** A service of one scan, to which somebody may give another size. */
function sizedService() {
  let scale = 1;
  let kept: StoredLandmarks = { schema: "breastrig/landmarks@1", unit: "mm", landmarks: {}, certain: [], seen: "" };
  const times = (file: LandmarkFile, factor: number): LandmarkFile["landmarks"] => Object.fromEntries(Object.entries(file.landmarks).map(([name, at]) => [name, at.map((value) => factor * value) as unknown as Vector]));
  const shown = (): StoredLandmarks => ({ ...kept, landmarks: times(kept, scale), seen: Object.keys(kept.landmarks).length === 0 ? "" : `${kept.seen} at ${scale}`, ...(scale === 1 ? {} : { scale }) });
  return {
    resize: (to: number): void => void (scale = to),
    placed: () => Object.fromEntries(Object.entries(shown().landmarks).map(([name, at]) => [name, at.map((value) => Math.round(1e6 * value) / 1e6)])),
    scan: async (id: string) => ({ ...scanInfo(id), ...(scale === 1 ? {} : { scale: { factor: scale } }) }) as Scan,
    landmarks: async () => shown(),
    saveLandmarks: vi.fn(async (_scan: Named, file: LandmarkFile, seen: string | null) => {
      if (seen !== null && seen !== shown().seen) throw new ApiError("Somebody has changed these landmarks.", 412);
      kept = { ...file, landmarks: times(file, 1 / (file.scale ?? scale)), seen: JSON.stringify(file) };
      return shown();
    }),
  };
}

test("what is placed in a tab that shows the size before is kept in that size, and all that is shown is, too", async () => {
  const kept = sizedService();
  const one = await withScan(kept);
  kept.resize(1.25);
  place(one, "nipple_L", [10, 20, 30]);
  await pause();
  expect(kept.placed(), "though nobody had placed any before: their tag is the same in each size").toEqual({ nipple_L: [12.5, 25, 37.5] });
  kept.resize(0.8);
  const two = await withScan(kept);
  kept.resize(1.25);
  place(two, "nipple_R", [8, 0, 0]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [12.5, 25, 37.5], nipple_R: [12.5, 0, 0] });
  expect(two.store.get().picks.present.nipple_L!.map(Math.round)).toEqual([8, 16, 24]);
  expect(two.store.get().problems.landmarks, "nobody has moved any").toBeUndefined();
  place(one, "umbilicus", [0, 0, 10]);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [12.5, 25, 37.5], nipple_R: [12.5, 0, 0], umbilicus: [0, 0, 12.5] });
  expect(one.store.get().picks.present).toEqual({ nipple_L: [10, 20, 30], nipple_R: [10, 0, 0], umbilicus: [0, 0, 10] });
});

test("what could not be saved is kept in its size until the page is opened again, whatever size the scan then has", async () => {
  const kept = sizedService();
  const tab = memory();
  const one = await withScan({ ...kept, saveLandmarks: vi.fn(() => Promise.reject(new ApiError("Nobody answers.", 0))) }, tab);
  place(one, "nipple_L", [10, 20, 30]);
  await pause();
  kept.resize(1.25);
  const again = await withScan(kept, tab);
  await pause();
  expect(again.store.get()).toMatchObject({ picks: { present: { nipple_L: [12.5, 25, 37.5] } }, saving: "saved" });
  expect(kept.placed()).toEqual({ nipple_L: [12.5, 25, 37.5] });
});

test("a page that closes while a save is on its way sends the last picks all the same", async () => {
  const { kept, one } = await twoTabs();
  place(one, "nipple_L", [1, 2, 3]);
  vi.advanceTimersByTime(450);
  place(one, "nipple_R", [4, 5, 6]);
  void one.actions.landmarks.flush(true);
  expect(kept.saveLandmarks, "at once, for nothing runs on a page that is gone").toHaveBeenCalledTimes(2);
  await pause();
  expect(kept.placed()).toEqual({ nipple_L: [1, 2, 3], nipple_R: [4, 5, 6] });
});
