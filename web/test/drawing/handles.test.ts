// Handles of patterns: newest place only, nothing written before the hand lets go, one step to undo, and keys within limits.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fitLinks, page, scanInfo } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { Meta, PatternOnScan, PatternQuestion, Vector } from "../../src/api/types";
import { hasHandles } from "../../src/drawing/patterns/handles";
import { shownPatterns } from "../../src/drawing/state";
import type { FitState } from "../../src/fit/state";

const ID = "values/width_L";

/** A service that draws the width at the place's x. */
function answer({ name, parameters, drag }: PatternQuestion): PatternOnScan {
  const width = drag ? Math.min(drag.to[0], 100) : Number(parameters?.width_mm ?? 70);
  return {
    name,
    parameters: drag ? { ...parameters, width_mm: width } : (parameters ?? {}),
    unit: "mm",
    shapes: [{ name: "mastectomy_L", label: "ellipse", closed: true, color: "#c53030", points: [[width, 0, 0]], bridged: [false] }],
    handles: [{ name: "width_L", side: "L", label: "Width, left", at_mm: [width, 0, 0], grows: [1, 0, 0], numbers: [{ parameter: "width_mm", label: "Width", unit: "mm", value: width, min: 20, max: 100 }] }],
    limit: drag && drag.to[0] > 100 ? "Width stops at 100 mm." : "",
  };
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

async function begun(pattern: (question: PatternQuestion) => Promise<PatternOnScan> = async (question) => answer(question)) {
  const asked = vi.fn(pattern);
  const made = page({ pattern: async (_fit: string, question: PatternQuestion) => asked(question) });
  await made.actions.scan.open("s1", null);
  made.store.set((state) => ({ meta: { ...state.meta, patterns: [{ name: "ellipse", label: "Ellipse", parameters: [] }], drawings: [] } as unknown as Meta }));
  const fit = { id: "f1", links: fitLinks("f1"), state: "done", iterations: [], shown: -1, playing: false, drawing: null, drawingName: null } as unknown as FitState;
  made.actions.drawing.choosePattern("ellipse");
  made.store.set({ fit, step: "plan" });
  await vi.advanceTimersByTimeAsync(10);
  const live = () => made.store.get().drawn.live;
  return { ...made, asked, live };
}

test("handles are there in the step of drawing without a pen, once the body is fitted", async () => {
  const { store, live } = await begun();
  expect(live()!.handles.map(({ id }) => id)).toEqual([ID]);
  expect(hasHandles(store.get())).toBe(true);
  expect(hasHandles({ ...store.get(), step: "body" })).toBe(false);
  expect(hasHandles({ ...store.get(), fit: null })).toBe(false);
  expect(hasHandles({ ...store.get(), drawn: { ...store.get().drawn, tool: "pen" } })).toBe(false);
});

test("numbers that are typed quickly are one question at a time, and the last ones have their handles", async () => {
  const free: (() => void)[] = [];
  let isSlow = false;
  const { actions, asked, live } = await begun(async (question) => {
    if (isSlow) await new Promise<void>((done) => free.push(done));
    return answer(question);
  });
  isSlow = true;
  for (const width of [41, 42, 43, 44]) {
    actions.drawing.choosePattern(`ellipse:width_mm=${width}`);
    await vi.advanceTimersByTimeAsync(10);
  }
  expect(free).toHaveLength(1);
  free.shift()!();
  await vi.advanceTimersByTimeAsync(10);
  expect(free).toHaveLength(1);
  free.shift()!();
  await vi.advanceTimersByTimeAsync(10);
  expect(asked.mock.calls.map(([{ parameters }]) => parameters?.width_mm)).toEqual([undefined, 41, 44]);
  expect(live()!.handles.map(({ at_mm }) => at_mm[0])).toEqual([44]);
});

test("of the places that come while the service draws, only the newest is asked for", async () => {
  let free: (() => void)[] = [];
  const { actions, asked, live } = await begun(async (question) => {
    if (question.drag) await new Promise<void>((done) => free.push(done));
    return answer(question);
  });
  actions.handles.grab(ID);
  for (const x of [71, 72, 73, 74]) actions.handles.drag([x, 0, 0]);
  await vi.advanceTimersByTimeAsync(10);
  expect(free).toHaveLength(1);
  free.shift()!();
  await vi.advanceTimersByTimeAsync(10);
  free.shift()!();
  await vi.advanceTimersByTimeAsync(10);
  expect(asked.mock.calls.map(([{ drag }]) => drag?.to[0])).toEqual([undefined, 71, 74]);
  expect(live()!.values).toEqual({ width_mm: "74" });
  free = [];
});

test("nothing is written while it is dragged; then it is one step, and lines stay until the plan is laid anew", async () => {
  const { actions, store, client, live } = await begun();
  const link = scanInfo("s1").links.plan;
  const width = async () => (await client.plan(link)).items.map((item) => (item.kind === "pattern" ? item.parameters : null));
  actions.handles.grab(ID);
  actions.handles.drag([81.5, 0, 0]);
  await vi.advanceTimersByTimeAsync(10);
  expect(store.get().drawing).toBe("ellipse");
  expect(shownPatterns(store.get())!.shapes[0]!.points).toEqual([[81.5, 0, 0]]);
  await actions.handles.release();
  await vi.advanceTimersByTimeAsync(10);
  expect(store.get().drawing).toBe("ellipse:width_mm=81.5");
  expect(await width()).toEqual([{ width_mm: 81.5 }]);
  expect(store.get().announcement).toBe("Width, left: 81.5\u00a0mm");
  expect(live()!.handles[0]!.numbers[0]!.value, "the handles of what is drawn now").toBe(81.5);
  actions.drawing.undo();
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get().drawing).toBe("ellipse");
  expect(await width()).toEqual([{}]);
});

test("a limit is said where it is reached, and a refusal of the service too; the last that could be drawn stays", async () => {
  const { actions, store, live } = await begun(async (question) => {
    if (question.drag && question.drag.to[0] < 0) throw new ApiError("The handle was dragged off the fitted skin; drag it on the body.", 422);
    return answer(question);
  });
  actions.handles.grab(ID);
  actions.handles.drag([300, 0, 0]);
  await vi.advanceTimersByTimeAsync(10);
  expect(live()!.limit).toBe("Width stops at 100 mm.");
  actions.handles.drag([-5, 0, 0]);
  await vi.advanceTimersByTimeAsync(10);
  expect(live()!.limit).toMatch(/off the fitted skin/);
  await actions.handles.release();
  expect(store.get().drawing).toBe("ellipse:width_mm=100");
});

test("keys move a handle by steps within its limits; a pause lets go, as one step", async () => {
  const { actions, store, live } = await begun();
  for (const by of [1, 1, 5]) {
    actions.handles.grab(ID);
    actions.handles.step(by);
    await vi.advanceTimersByTimeAsync(100);
  }
  expect(live()!.values).toEqual({ width_mm: "77" });
  expect(store.get().drawing).toBe("ellipse");
  await vi.advanceTimersByTimeAsync(1000);
  expect(store.get().drawing).toBe("ellipse:width_mm=77");
  for (let count = 0; count < 6; count += 1) {
    actions.handles.grab(ID);
    actions.handles.step(5);
    await vi.advanceTimersByTimeAsync(100);
  }
  expect(live()!.values).toEqual({ width_mm: "100" });
  expect(live()!.limit).toBe("Width stops at 100\u00a0mm.");
});

test("what was taken and given back changes nothing", async () => {
  const { actions, store, live } = await begun();
  actions.handles.grab(ID);
  actions.handles.drag([90, 0, 0] as Vector);
  await vi.advanceTimersByTimeAsync(10);
  actions.handles.cancel();
  await vi.advanceTimersByTimeAsync(10);
  expect(store.get().drawing).toBe("ellipse");
  expect(live()).toMatchObject({ held: null, dragged: null, limit: "" });
  expect(live()!.handles[0]!.at_mm).toEqual([70, 0, 0]);
});

test("handles that cannot be had just now come later; those of a pattern that cannot be drawn are not asked for again", async () => {
  let status = 429;
  const { asked, live } = await begun(async (question) => {
    if (status !== 200) throw new ApiError("no", status);
    return answer(question);
  });
  expect(asked).toHaveBeenCalledTimes(1);
  status = 200;
  await vi.advanceTimersByTimeAsync(5000);
  expect(live()!.handles).toHaveLength(1);
  const refused = await begun(async () => Promise.reject(new ApiError("The limbs reach the fold.", 422)));
  await vi.advanceTimersByTimeAsync(20_000);
  expect(refused.asked).toHaveBeenCalledTimes(3); // the whole, and each side alone
  expect(refused.live()!.handles).toEqual([]);
});
