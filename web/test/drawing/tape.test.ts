// The tape measure: lengths along the skin, click after click, and nothing of it kept.
import { PlaneGeometry, SphereGeometry } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { ApiError, type Client } from "../../src/api/client";
import type { Lengths, Vector } from "../../src/api/types";
import { drawingKey } from "../../src/drawing/keys";
import { type Skin, skinOf } from "../../src/drawing/lines/skin";
import { tapeBack, tapeFrom, tapeHasHole, tapeLength, tapeTo } from "../../src/drawing/tape/tape";
import { tape as words } from "../../src/drawing/text";
import type { FitState } from "../../src/fit/state";
import { workspaceOf } from "../../src/stances/state";
import { fitLinks, withScan } from "../fakes";
import { cut, made } from "../shapes";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const flat = (() => {
  const geometry = new PlaneGeometry(0.4, 0.4, 20, 20);
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  return skinOf(geometry);
})();
const ball = (): Skin => skinOf(made(new SphereGeometry(0.1, 192, 128)));

async function measuring(skin: Skin = flat, answers: Partial<Client> = {}) {
  const page = await withScan(answers);
  page.actions.drawing.setSkin(() => skin);
  page.actions.drawing.take("tape");
  const key = (name: string): boolean => drawingKey(page.store.get(), { key: name, target: null } as unknown as KeyboardEvent, page.actions.drawing);
  return { ...page, key, tape: () => page.store.get().drawn.tape };
}

vi.stubGlobal("HTMLElement", EventTarget); // the keys ask whether a button has the focus

test("over a ball the length is that of the great circle", () => {
  const skin = ball();
  for (const degrees of [20, 60, 120]) {
    const angle = (degrees * Math.PI) / 180;
    const tape = tapeTo(skin, tapeFrom([100, 0, 0]), [100 * Math.cos(angle), 60 * Math.sin(angle), 80 * Math.sin(angle)]);
    expect(tapeLength(tape)! / (100 * angle), `${degrees}°`).toBeGreaterThan(0.99);
    expect(tapeLength(tape)! / (100 * angle), `${degrees}°`).toBeLessThan(1.01);
    expect(tapeHasHole(tape)).toBe(false);
  }
});

test("each leg has its own length, and the way lies on the skin from click to click", async () => {
  const { actions, tape } = await measuring();
  for (const at of [[0, 0, 0], [100, 0, 0], [100, 50, 0]] as Vector[]) actions.drawing.measure(at);
  expect(tape()!.legs.map(({ mm }) => Math.round(mm! * 1000) / 1000)).toEqual([100, 50]);
  expect(words.total(tape()!)).toBe("150\u00a0mm in all");
  for (const { points } of tape()!.legs) for (const [, , z] of points) expect(Math.abs(z)).toBeLessThan(1e-6);
  expect(tape()!.legs[1]!.points.at(-1)).toEqual([100, 50, 0]);
});

test("where there is a fit the service measures on the fitted skin, as its measures and tape sheet do", async () => {
  let answer: (legs: Lengths) => void = () => undefined;
  const lengths = vi.fn<Client["lengths"]>(() => new Promise((done) => (answer = done)));
  const { actions, tape, store } = await measuring(flat, { lengths });
  store.set({ fit: { id: "f1", links: fitLinks("f1"), state: "done", iterations: [] } as unknown as FitState });
  actions.drawing.measure([0, 0, 0]);
  actions.drawing.measure([100, 0, 0]);
  expect(lengths).toHaveBeenCalledExactlyOnceWith("/api/fits/f1", [[0, 0, 0], [100, 0, 0]]);
  expect(tapeLength(tape()!), "no number of the page's own").toBeNull();
  expect(words.total(tape()!)).toBe("… in all");
  const points: Vector[] = [[0, 0, 0], [50, 0, 9], [100, 0, 0]];
  answer({ legs: [{ mm: 103.4, points }] });
  await vi.advanceTimersByTimeAsync(0);
  expect(tape()!.legs).toEqual([{ mm: 103.4, points, hasHole: false }]);
  expect(store.get().announcement).toBe("103\u00a0mm in all");
  lengths.mockRejectedValueOnce(new ApiError("A place lies off the fitted skin; measure on the body.", 422));
  actions.drawing.measure([100, 90, 0]);
  await vi.advanceTimersByTimeAsync(0);
  expect(tape()!.places).toEqual([[0, 0, 0], [100, 0, 0]]);
  expect(store.get().problems.drawing).toContain("off the fitted skin");
});

test("over a hole it is straight and says so; where no skin leads nothing is measured", async () => {
  const holed = (half: number): Skin => skinOf(made(cut(new PlaneGeometry(0.2, 0.2, 100, 100), (x) => Math.abs(x) > half)));
  const { actions, tape, store } = await measuring(holed(0.01));
  actions.drawing.measure([-50, 0, 0]);
  actions.drawing.measure([50, 0, 0]);
  expect(tape()!.legs[0]).toMatchObject({ hasHole: true });
  expect(tapeLength(tape()!)).toBeCloseTo(100, 1);
  expect(words.length(100, true)).toBe("≈\u00a0100\u00a0mm, over a hole");
  actions.drawing.setSkin(() => holed(0.04));
  actions.drawing.measure([-60, 0, 0]);
  expect(tape()!.legs).toHaveLength(1);
  expect(store.get().announcement).toMatch(/^No scanned skin leads there/);
  expect(words.says(tape()!)).toBe(store.get().announcement);
});

test("Escape ends the tape, which stays to be read; the next click begins another one, Escape again puts the tool down", async () => {
  const { actions, tape, key, store } = await measuring();
  actions.drawing.measure([0, 0, 0]);
  actions.drawing.measure([30, 0, 0]);
  expect(key("Escape")).toBe(true);
  expect(tape()).toMatchObject({ isEnded: true });
  expect(tapeLength(tape()!)).toBeCloseTo(30, 6);
  actions.drawing.measure([0, 80, 0]);
  expect(tape()).toEqual(tapeFrom([0, 80, 0]));
  key("Escape");
  expect(tape(), "a single place measures nothing").toBeNull();
  key("Escape");
  expect(store.get().drawn.tool).toBe("none");
});

test("M takes the tape and puts it down, Enter ends it, Z takes back a place", async () => {
  const { actions, tape, key, store } = await measuring();
  for (const x of [0, 30, 60]) actions.drawing.measure([x, 0, 0]);
  key("z");
  expect(tapeLength(tape()!)).toBeCloseTo(30, 6);
  key("Enter");
  expect(tape()!.isEnded).toBe(true);
  key("m");
  expect(store.get().drawn).toMatchObject({ tool: "none", tape: null });
  key("m");
  expect(store.get().drawn.tool).toBe("tape");
  expect(tapeBack(tapeFrom([0, 0, 0]))).toBeNull();
});

test("nothing of it is saved, undone or put aside with the scan", async () => {
  const { actions, store, client } = await measuring();
  actions.drawing.measure([0, 0, 0]);
  actions.drawing.measure([30, 0, 0]);
  await vi.advanceTimersByTimeAsync(5000);
  expect(store.get().drawn.lines.present).toEqual([]);
  expect(store.get().drawn.saving).toBe("saved");
  expect((client as unknown as { savePlan: ReturnType<typeof vi.fn> }).savePlan).not.toHaveBeenCalled();
  expect(workspaceOf(store.get()).drawn.tape).toBeNull();
});
