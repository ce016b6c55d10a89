// The own drawing: each change one step of the history, saved soon after, never lost on a failed request; files in and out.
import { PlaneGeometry } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fakePlans, page } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { PlanLine, StoredPlan, Vector } from "../../src/api/types";
import { lineAlong } from "../../src/drawing/lines/edits";
import { readDrawing, toDrawing, toText, UnreadableDrawing } from "../../src/drawing/lines/files";
import { drawingKey } from "../../src/drawing/keys";
import { lengthOf } from "../../src/drawing/lines/lines";
import { skinOf } from "../../src/drawing/lines/skin";
import { layerKey } from "../../src/drawing/state";

const skin = (() => {
  const geometry = new PlaneGeometry(0.4, 0.4, 20, 20); // 400 mm square in z = 0
  geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  return skinOf(geometry);
})();

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

async function drawing(answers: Parameters<typeof page>[0] = {}) {
  const made = page({ importExample: async () => ({ ...(await made.client.scan("s1")) }), ...answers });
  await made.actions.scan.takeExample("standing");
  made.actions.drawing.setSkin(() => skin);
  made.actions.drawing.take("pen");
  const { savePlan: saved } = made.client as unknown as { savePlan: ReturnType<typeof vi.fn> };
  const names = (): string[] => made.store.get().drawn.lines.present.map(({ name }) => name);
  return { ...made, saved, names };
}

const stroke = (from: number, to: number): Vector[] => Array.from({ length: 20 }, (_, i) => [from + ((to - from) * i) / 19, 0, 0]);

test("a stroke is a line, saved once after a run of them", async () => {
  const { actions, store, saved, names } = await drawing();
  actions.drawing.strokes([stroke(-50, 50)]);
  actions.drawing.strokes([stroke(0, 30)]);
  expect(names()).toEqual(["Line 1", "Line 2"]);
  expect(lengthOf(store.get().drawn.lines.present[0]!)).toBeCloseTo(100, 6);
  expect(store.get().drawn.saving).toBe("unsaved");
  await vi.advanceTimersByTimeAsync(500);
  expect(saved).toHaveBeenCalledTimes(1);
  expect((saved.mock.calls[0]![1] as PlanLine[]).map(({ name }) => name)).toEqual(["Line 1", "Line 2"]);
  expect(store.get().drawn.saving).toBe("saved");
});

test("a depth of a line is one step to undo, which says it", async () => {
  const { actions, store, names } = await drawing();
  actions.drawing.strokes([stroke(-50, 50)]);
  actions.drawing.cutTo(names()[0]!, 25);
  expect(store.get().drawn.lines.present[0]!.depthMm).toBe(25);
  actions.drawing.undo();
  expect(store.get().drawn.lines.present[0]!.depthMm).toBeUndefined();
  expect(store.get().undone?.says).toContain("depth of Line 1: 25");
});

test("a stroke that is cut where it leaves the skin is as many lines and one step to undo", async () => {
  const { actions, names } = await drawing();
  actions.drawing.strokes([stroke(-50, -10), [[0, 0, 0]], stroke(10, 50)]);
  expect(names()).toEqual(["Line 1", "Line 2"]);
  actions.drawing.undo();
  expect(names()).toEqual([]);
  actions.drawing.redo();
  expect(names()).toEqual(["Line 1", "Line 2"]);
});

test("clicks go on from the last corner until the line is ended, and its start closes it", async () => {
  const { actions, store } = await drawing();
  const line = () => store.get().drawn.lines.present[0]!;
  for (const at of [[0, 0, 0], [40, 0, 0], [40, 40, 0], [0, 40, 0]] as Vector[]) actions.drawing.click(at);
  expect(line().corners).toHaveLength(4);
  actions.drawing.click([3, 2, 0]);
  expect(line()).toMatchObject({ closed: true, name: "Line 1" });
  expect(lengthOf(line())).toBeCloseTo(160, 6);
  expect(store.get().drawn.open).toBeNull();
  actions.drawing.close("Line 1");
  expect(line().closed).toBe(false);
});

test("undo and redo go step by step, through the first click too", async () => {
  const { actions, store, names } = await drawing();
  actions.drawing.strokes([stroke(-50, 50)]);
  actions.drawing.click([0, 20, 0]);
  expect(store.get().drawn.start).toEqual([0, 20, 0]);
  actions.drawing.undo();
  expect(store.get().drawn.start).toBeNull();
  actions.drawing.erase("Line 1");
  expect(names()).toEqual([]);
  actions.drawing.undo();
  expect(names()).toEqual(["Line 1"]);
  actions.drawing.undo();
  expect(names()).toEqual([]);
  actions.drawing.redo();
  expect(names()).toEqual(["Line 1"]);
});

test("undo and redo say what they changed", async () => {
  const { actions, store } = await drawing();
  const says = () => store.get().undone?.says;
  const number = (name: string, label: string, more: object = {}) => ({ name, label, unit: "mm", default: null, needed: true, min: null, max: null, choices: null, ...more });
  const tumour = [number("side", "side", { unit: "", choices: ["L", "R"] }), number("clock", "hour", { unit: "h" }), number("distance_mm", "distance"), number("radius_mm", "radius")];
  const patterns = [{ name: "reduction", label: "Reduction", parameters: [number("areola_mm", "new areola")] }, { name: "tumour", label: "Tumour", parameters: tumour }];
  store.set(({ meta }) => ({ meta: { ...meta, patterns, drawings: [] } as unknown as typeof meta }));
  actions.drawing.strokes([stroke(-50, -10), stroke(10, 50)]);
  actions.drawing.rename("Line 1", "cut");
  actions.drawing.recolour("cut", "#c53030");
  actions.drawing.choosePattern("reduction:areola_mm=42");
  actions.drawing.choosePattern("reduction:areola_mm=50+tumour:side=L,clock=12,distance_mm=40,radius_mm=15");
  actions.drawing.choosePattern("reduction:areola_mm=50+tumour:side=R,clock=10.5,distance_mm=40,radius_mm=15");
  actions.drawing.restore([]);
  const all: (string | undefined)[] = [];
  for (let i = 0; i < 7; i += 1) {
    actions.drawing.undo();
    all.push(says());
  }
  expect(all).toEqual([
    "Undone: cut, Line 2 erased.",
    "Undone: side Patient's right instead of Patient's left, hour 10:30 o'clock instead of 12 o'clock.",
    "Undone: new areola 50\u00a0mm instead of 42\u00a0mm, Tumour chosen.",
    "Undone: Reduction chosen.",
    "Undone: cut in another colour.",
    "Undone: Line 1 called cut.",
    "Undone: Line 1, Line 2 drawn.",
  ]);
  actions.drawing.redo();
  expect(says()).toBe("Redone: Line 1, Line 2 drawn.");
});

test("who chooses a pattern with the pen in the hand puts it down: the pattern's handles are there to drag", async () => {
  const { actions, store } = await drawing();
  actions.drawing.take("pen");
  actions.drawing.click([0, 0, 0]);
  actions.drawing.choosePattern("reduction");
  expect(store.get().drawn).toMatchObject({ tool: "none", start: null, open: null });
});

test("a failed request loses nothing: the lines stay, it is said, and the next try saves all", async () => {
  let fails = true;
  const kept = fakePlans();
  const { actions, store, names } = await drawing({
    savePlan: async (link, items, seen) => {
      if (fails) throw new ApiError("The service does not answer.", 0);
      return kept.savePlan(link, items, seen);
    },
  });
  actions.drawing.strokes([stroke(-50, 50)]);
  await vi.advanceTimersByTimeAsync(500);
  expect(store.get().drawn.saving).toBe("unsaved");
  expect(store.get().problems.drawing).toBe("The service does not answer.");
  expect(names()).toEqual(["Line 1"]);
  fails = false;
  await actions.drawing.saveNow();
  expect(store.get().drawn.saving).toBe("saved");
  expect(store.get().problems.drawing).toBeUndefined();
});

test("what was wrong with a file stays said while lines from before are saved", async () => {
  const { store, actions } = await drawing();
  const line = { schema: "breastrig/drawing@1", unit: "mm", shapes: [{ name: "one", closed: false, color: "#b83280", points: [[0, 0, 0], [10, 0, 0]] }] };
  const file = (text: string): File => new File([text], "d.json");
  await actions.drawing.importFile(file(JSON.stringify(line)));
  await actions.drawing.importFile(file("{"));
  const said = store.get().problems.drawing;
  expect(said).toContain("not valid JSON");
  await vi.advanceTimersByTimeAsync(5000);
  expect(store.get()).toMatchObject({ drawn: { saving: "saved" }, problems: { drawing: said } });
});

test("a tumour is a circle with its radius along the skin; the radius stays within what the model takes", async () => {
  const { actions, store } = await drawing();
  actions.drawing.radius(500);
  expect(store.get().drawn.radiusMm).toBe(80);
  actions.drawing.radius(20);
  actions.drawing.tumour([10, 10, 3]);
  const circle = store.get().drawn.lines.present[0]!;
  expect(circle).toMatchObject({ name: "Tumour 20 mm", closed: true });
  for (const [x, y] of circle.points) expect(Math.hypot(x - 10, y - 10)).toBeCloseTo(20, 4);
});

test("names are free or refused", async () => {
  const { actions, names } = await drawing();
  actions.drawing.strokes([stroke(-50, 50)]);
  actions.drawing.strokes([stroke(0, 30)]);
  expect(actions.drawing.rename("Line 1", "Line 2")).toBe(false);
  expect(actions.drawing.rename("Line 1", " ")).toBe(false);
  expect(actions.drawing.rename("Line 1", " incision ")).toBe(true);
  expect(names()).toEqual(["incision", "Line 2"]);
});

test("a line is switched off and on without a step of the history", async () => {
  const { actions, store } = await drawing();
  actions.drawing.strokes([stroke(-50, 50)]);
  const { past } = store.get().drawn.lines;
  actions.drawing.show("own", ["Line 1"], false);
  expect(store.get().drawn.hidden.has(layerKey("own", "Line 1"))).toBe(true);
  actions.drawing.show("own", ["Line 1"], true);
  expect([...store.get().drawn.hidden]).toEqual([]);
  expect(store.get().drawn.lines.past).toBe(past);
});

test("what the service keeps of a scan is there when the scan is opened", async () => {
  const items = [{ kind: "line", id: "a", scan: "s1", name: "incision", points: [[0, 0, 0], [10, 0, 0]] }, { kind: "line", id: "b", scan: "s2", name: "other", points: [[0, 0, 0]] }];
  const made = page({ plan: async () => ({ version: 3, whole: true, scans: [], items }) as unknown as StoredPlan });
  await made.actions.scan.open("s1", null);
  expect(made.store.get().drawn.lines.present).toMatchObject([{ id: "a", name: "incision", closed: false, corners: [0, 1] }]);
  expect(made.store.get().drawn.saving).toBe("saved");
});

test("leaving the step puts the pen down and keeps the line", async () => {
  const { actions, store, names } = await drawing();
  actions.drawing.click([0, 0, 0]);
  actions.drawing.click([30, 0, 0]);
  actions.page.goTo("body");
  expect(store.get().drawn).toMatchObject({ tool: "none", open: null });
  expect(names()).toEqual(["Line 1"]);
});

test("keys work in the step alone, and leave the browser's own alone", async () => {
  const { actions, store } = await drawing();
  const key = (name: string, more: object = {}): boolean => drawingKey(store.get(), { key: name, target: null, ...more } as unknown as KeyboardEvent, actions.drawing);
  expect(key("t")).toBe(true);
  expect(store.get().drawn.tool).toBe("tumour");
  expect(key("Escape")).toBe(true);
  expect(store.get().drawn.tool).toBe("none");
  expect(key("p", { ctrlKey: true })).toBe(false);
  expect(key("f")).toBe(false);
  actions.page.goTo("body");
  expect(key("p")).toBe(false);
});

test("a file holds what was drawn, in millimetres, and is read in any unit", () => {
  const text = toText([lineAlong("a", "#c53030", [[0, 0, 0], [10.12345, 0, 0], [10, 10, 0]], true)]);
  expect(JSON.parse(text)).toMatchObject({ schema: "breastrig/drawing@1", unit: "mm", shapes: [{ name: "a", closed: true, points: [[0, 0, 0], [10.123, 0, 0], [10, 10, 0]] }] });
  expect(readDrawing(text, "m")).toMatchObject([{ name: "a", closed: true, color: "#c53030" }]);
  const metres = JSON.stringify({ unit: "m", shapes: [{ name: "b", points: [[0, 0, 0], [0.01, 0, 0]] }] });
  expect(readDrawing(metres, "mm")[0]!.points[1]).toEqual([10, 0, 0]);
  expect(toDrawing([]).shapes).toEqual([]);
});

test.each([
  ["{", "not valid JSON"],
  ["null", "no “shapes”"],
  ['{"unit":"ell","shapes":[]}', "“ell” is not known"],
  ['{"shapes":[]}', "holds no lines"],
  ['{"shapes":[{"name":"a","surface_points":[]}]}', "no points on a scan"],
  ['{"shapes":[{"name":"a","points":[[0,0]]}]}', "not three numbers"],
])("a file that is no drawing is refused with a sentence: %s", (text, words) => {
  expect(() => readDrawing(text, "mm")).toThrow(UnreadableDrawing);
  expect(() => readDrawing(text, "mm")).toThrow(words);
});

test("lines of a file a little off the skin are moved onto it, those farther off are left out, and both is said", async () => {
  const { actions, store, names } = await drawing();
  const shapes = [{ name: "near", points: [[0, 0, 6], [10, 0, 6]] }, { name: "far", points: [[0, 0, 0], [10, 0, 11]] }];
  await actions.drawing.importFile(new File([JSON.stringify({ unit: "mm", shapes })], "drawing.json"));
  expect(names()).toEqual(["near"]);
  expect(store.get().drawn.lines.present[0]!.points.every(([, , z]) => Math.abs(z) < 1e-3)).toBe(true);
  expect(store.get().problems.drawing).toBe("1 line read; moved onto the skin by up to 6 mm; left out, more than 10 mm off this scan: far.");
});

test.each([
  [{ patient: "P-9" }, "P-9"],
  [{ patient: "P-9", scan_sha256: "ff" }, "P-9"],
  [{ scan_sha256: "ff" }, null],
  [{ patient: "P-9", scans: [{ id: "s", sha256: "ff" }] }, "P-9"],
])("another patient's drawing is asked about before anything of it is taken: %o", async (whose, theirs) => {
  const { actions, store, names } = await drawing();
  const file = (): File => new File([JSON.stringify({ unit: "mm", shapes: [{ name: "a", points: [[0, 0, 0], [10, 0, 0]] }], ...whose })], "drawing.json");
  await actions.drawing.importFile(file());
  expect(store.get().drawn.another).toMatchObject({ theirs });
  expect(names()).toEqual([]);
  actions.drawing.leaveAnother();
  expect([names(), store.get().drawn.another]).toEqual([[], null]);
  await actions.drawing.importFile(file());
  actions.drawing.takeAnother();
  expect([names(), store.get().drawn.another]).toEqual([["a"], null]);
});

test("one's own drawing is taken at once, by its code or its scan", async () => {
  const { actions, store, names } = await drawing();
  const { patient_code, sha256 } = store.get().scan!.info;
  const shapes = [{ name: "a", points: [[0, 0, 0], [10, 0, 0]] }];
  for (const whose of [{ patient: patient_code, scan_sha256: "ff" }, { patient: "P-9", scan_sha256: sha256 }]) await actions.drawing.importFile(new File([JSON.stringify({ unit: "mm", shapes, ...whose })], "d.json"));
  expect(names()).toEqual(["a", "a 2"]);
  expect(JSON.parse(toText(store.get().drawn.lines.present, { patient: patient_code, scans: [sha256] }))).toMatchObject({ patient: patient_code, scan_sha256: sha256 });
});

test("an imported drawing of another body is refused, nothing is changed", async () => {
  const { actions, store, names } = await drawing();
  const file = (points: Vector[]): File => new File([JSON.stringify({ unit: "mm", shapes: [{ name: "a", points }] })], "drawing.json");
  for (const off of [900, 12]) {
    await actions.drawing.importFile(file([[0, 0, off], [10, 0, off]]));
    expect(store.get().problems.drawing).toContain(`${off} mm off this scan`);
  }
  expect(names()).toEqual([]);
  await actions.drawing.importFile(file([[0, 0, 0], [10, 0, 0]]));
  expect(names()).toEqual(["a"]);
  expect(store.get().problems.drawing).toBeUndefined();
});
