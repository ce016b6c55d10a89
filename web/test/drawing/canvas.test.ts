// The full canvas as state, the colours of lines, and what leads back to the page.
import { Color } from "three";
import { afterEach, expect, test, vi } from "vitest";
import { drawingKey } from "../../src/drawing/keys";
import { INK, ownColour, polyline } from "../../src/drawing/lines/lines";
import { skinOf } from "../../src/drawing/lines/skin";
import { inkOf, segmentColours } from "../../src/viewer/lines/FatLines";
import { half, made } from "../shapes";
import { withScan } from "../fakes";

afterEach(() => void vi.unstubAllGlobals());

const press = (key: string) => ({ key, shiftKey: false, ctrlKey: false, metaKey: false, target: null }) as unknown as KeyboardEvent;

test("the canvas takes the pen; Escape ends first the line, then leads back", async () => {
  const { store, actions } = await withScan();
  actions.drawing.setSkin(() => skin);
  const skin = skinOf(made(half()));
  actions.drawing.fullCanvas(true);
  expect(store.get()).toMatchObject({ isCanvasFull: true, step: "plan", overlay: "scan", drawn: { tool: "pen" } });
  actions.drawing.click([0, 0, 100]);
  expect(drawingKey(store.get(), press("Escape"), actions.drawing)).toBe(true);
  expect(store.get()).toMatchObject({ isCanvasFull: true, drawn: { start: null, tool: "pen" } });
  drawingKey(store.get(), press("Escape"), actions.drawing);
  expect(store.get()).toMatchObject({ isCanvasFull: false, step: "plan", drawn: { tool: "none" } });
});

test("without its step or its scan there is no full canvas", async () => {
  const { store, actions } = await withScan();
  actions.drawing.fullCanvas(true);
  actions.page.goTo("body");
  expect(store.get().isCanvasFull).toBe(false);
  actions.page.goTo("plan");
  expect(store.get().isCanvasFull).toBe(false);
  actions.drawing.fullCanvas(true);
  await actions.scan.leave();
  expect(store.get().isCanvasFull).toBe(false);
});

test("the ink in the hand is the next line's colour, and can be given to one that is there", async () => {
  const { store, actions } = await withScan();
  const skin = skinOf(made(half()));
  actions.drawing.setSkin(() => skin);
  const draw = (y: number): void => actions.drawing.strokes([Array.from({ length: 12 }, (_, i) => skin.nearest([-40 + 7 * i, y, 100]).point)]);
  draw(0);
  actions.drawing.ink("#2b6cb0");
  draw(30);
  expect(store.get().drawn.lines.present.map(({ color }) => color)).toEqual([INK, "#2b6cb0"]);
  actions.drawing.recolour("Line 1", "#2f855a");
  expect(store.get().drawn.lines.present[0]!.color).toBe("#2f855a");
  actions.drawing.undo();
  expect(store.get().drawn.lines.present[0]!.color).toBe(INK);
});

test("lines are drawn in the colours that their files have, black ones in the ink of their layer, all with an outline that contrasts", () => {
  const paint = { ink: new Color("#ffffff"), outline: new Color("#1c1c1e") };
  const points: [number, number, number][] = [[0, 0, 0], [10, 0, 0], [10, 10, 0]];
  const lines = [polyline({ points, closed: false, color: "#2c5282" }), polyline({ points, closed: false, color: INK }), polyline({ points, closed: false, color: "#F4F4F4" })];
  const colours = segmentColours(lines, false, paint, "ink");
  expect(colours).toHaveLength(3 * 2 * 6);
  const at = (segment: number): string => `#${new Color(...(colours.subarray(6 * segment, 6 * segment + 3) as unknown as [number, number, number])).getHexString()}`;
  expect([at(0), at(1), at(2), at(4)]).toEqual(["#2c5282", "#2c5282", "#ffffff", "#f4f4f4"]);
  expect(inkOf("#2c5282", paint).outline.getHexString()).toBe("ffffff");
  expect(inkOf("#f4f4f4", paint).outline.getHexString()).toBe("1c1c1e");
  expect([ownColour(undefined), ownColour("#101010"), ownColour("#dd6b20")]).toEqual([null, null, "#dd6b20"]);
});
