import { expect, test } from "vitest";
import type { PlanItem, PlanOnScan } from "../../src/api/types";
import { type LaidLesion, lesionAt, readCenter, saidDistances } from "../../src/drawing/lesions/lesions";
import { alongSlice, type LesionSlice } from "../../src/drawing/lesions/slices";
import { depthPicture, WIDE } from "../../src/drawing/lesions/depth";
import { lesionView as words } from "../../src/drawing/lesions/viewText";
import { planChanges } from "../../src/drawing/changes";
import { chosenRow, planRows } from "../../src/drawing/panel/items";
import { laidOnScan, startDrawn, stepOf } from "../../src/drawing/state";
import { lesionsOn, stepOn, stepTogether, withLesions, withStepOn } from "../../src/plan/items";

const LESION = { ...lesionAt("MRI 1", [1, 2, 3], 6), id: "m", scan: "a" };
const ITEMS: PlanItem[] = [LESION, { ...LESION, id: "n", scan: "b" }, { kind: "note", id: "w", scan: "a", text: "smaller" }];

test("a centre is read as people write it", () => {
  for (const written of ["12.5 -80 43", "12.5, -80, 43", "(12.5; -80; 43) mm", "12,5; -80; 43", "12.5\t-80\t43", "[12.5,-80,43]", "12,5 -80 43"]) expect(readCenter(written), written).toEqual([12.5, -80, 43]);
  expect(readCenter("1,2,3")).toEqual([1, 2, 3]);
  for (const written of ["", "1 2", "1 2 3 4", "a b c", "1e3 2 3x", "NaN 1 2"]) expect(readCenter(written), written).toBeNull();
});

test("lesions of one scan are put back, and what is the same is not written", () => {
  expect(lesionsOn(ITEMS, "a")).toEqual([LESION]);
  expect(withLesions(ITEMS, "a", [{ ...LESION }])).toBe(ITEMS);
  expect(withLesions(ITEMS, "a", [])).toEqual(ITEMS.slice(1));
  const before = stepOn(ITEMS, "a");
  expect(withStepOn(withLesions(ITEMS, "a", []), "a", before)).toHaveLength(3);
  expect(planChanges(before, { ...before, lesions: [] }, [])).toBe("lesions changed");
});

test("what somebody else has added is there, what was changed here stays", () => {
  const step = stepOn(ITEMS, "a");
  const moved = { ...LESION, center: [4, 5, 6] as [number, number, number] };
  expect(stepTogether(ITEMS, step, withLesions(ITEMS, "a", [moved]), "a").step.lesions).toEqual([moved]);
  expect(stepTogether(ITEMS, { ...step, lesions: [] }, withLesions(ITEMS, "a", [moved]), "a").step.lesions, "deleted here, changed there: it stays").toEqual([moved]);
});

test("a step of undoing holds the lesions", () => {
  const drawn = startDrawn([], { note: "", depthMm: null, lesions: [LESION] });
  expect(stepOf({ drawing: "", drawn }).lesions).toEqual([LESION]);
});

const LINES = [
  { kind: "skin", to: "skin", point: [0, 0, 0], mm: 12.4, low_mm: 7.6, high_mm: 17.3 },
  { kind: "line", to: "near", point: [0, 0, 0], mm: 20, low_mm: null, high_mm: null },
  { kind: "line", to: "cut_L", point: [0, 0, 0], mm: 30, low_mm: 25, high_mm: 35 },
];
const SLICE = { plane: "sagittal", right: [0, 0, -1], up: [0, 1, 0], outlines_mm: [] } as unknown as LesionSlice;

test("a distance is said with its band, and of all lines that to the chosen one, else to the nearest", () => {
  const laid = { distances: LINES } as unknown as LaidLesion;
  const said = (line: string | null) => saidDistances(laid, line).map((each) => `${words.to(each)}: ${words.banded(each)}`);
  expect(said("cut_L")).toEqual(["skin: 12\u00a0mm, 8 to 17", "To Cut, patient's left: 30\u00a0mm, 25 to 35"]);
  expect(said(null)[1]).toBe("To Near: 20\u00a0mm");
});

test("its place says how far it may be off, or that this is not known", () => {
  expect(words.placed({ carried: false, error_mm: 0 })).toBe("as given");
  expect(words.placed({ carried: true, error_mm: 8.4 })).toBe("carried, ±\u00a08\u00a0mm");
  expect(words.placed({ carried: true, error_mm: null })).toContain("not known");
});

test("places of the scan along the service's slice", () => {
  expect(alongSlice([1, 2, 3], [1, 7, -1], SLICE)).toEqual([4, 5]);
});

const depthOf = (depth: number, more: object[] = []) => depthPicture({ depth_mm: depth, radius_mm: 4, distances: [{ ...LINES[0]!, mm: Math.abs(depth), low_mm: Math.abs(depth) - 5, high_mm: Math.abs(depth) + 5 }, ...more] as unknown as LaidLesion["distances"] });

test("on the depth ruler the skin is to the left, then the lesion in its band, then the chest wall, all in one scale", () => {
  const { skin, at, band, wall, wallBand } = depthOf(20, [{ kind: "chest_wall", to: "chest_wall", mm: 30, low_mm: 20, high_mm: 40 }]);
  const mm = (at - skin) / 20;
  expect([band![0], band![1], wall, wallBand![0], wallBand![1]].map((x) => (x! - skin) / mm).map(Math.round)).toEqual([15, 25, 50, 40, 60]);
  expect(wallBand![1]).toBeLessThan(WIDE);
});

test("a chest wall that the image shows is said to be from it, any other to be estimated", () => {
  const chest = { kind: "chest_wall", to: "chest_wall", mm: 30, low_mm: 26, high_mm: 34 };
  for (const [more, says, to] of [[{ seen: true }, "chest wall, from the image", "To the chest wall of the image"], [{}, "chest wall, estimated", "To the chest wall"]] as const) {
    expect(words.wall(depthOf(20, [{ ...chest, ...more }]).isWallSeen)).toBe(says);
    expect(words.to({ ...chest, ...more })).toBe(to);
  }
});

test("a lesion outside the skin is drawn before it, and its words stay in the picture", () => {
  const { skin, at, band, words: said } = depthOf(-6);
  expect(at).toBeLessThan(skin);
  expect(band![0]).toBeLessThan(at);
  expect(said).toBeGreaterThan(50);
  expect(words.depth(-6, LINES[0]!).whole).toBe("12\u00a0mm outside the skin (90\u00a0%: 8–17\u00a0mm)");
});

test("where the depth's band is not known none is drawn", () => {
  const { band } = depthPicture({ depth_mm: 3, radius_mm: 4, distances: [{ ...LINES[0]!, low_mm: null, high_mm: null }] as unknown as LaidLesion["distances"] });
  expect(band).toBeNull();
  expect(words.depth(3, { mm: 3, low_mm: null, high_mm: null }).whole).toBe("3\u00a0mm below the skin");
});

test("each lesion stands in the plan: while it is carried, then with its depth and how sure its place is", () => {
  const state = { meta: null, models: {}, fit: null, drawing: "", lesion: null, item: null, drawn: startDrawn([], { note: "", depthMm: null, lesions: [LESION] }), scan: null, stances: { isCarrying: true, other: null, scans: [], asked: [] } };
  const said = (of: Parameters<typeof planRows>[0]) => planRows(of).map(({ label, says, hint }) => [label, says, hint]);
  expect(said(state)).toEqual([["MRI 1", "being carried here …", ""]]);
  const laid = (lesions: object[]) => ({ ...state, drawn: { ...state.drawn, onScan: laidOnScan("supine", [], { unit: "mm", shapes: [], lesions } as unknown as PlanOnScan) }, stances: { isCarrying: false, other: null, scans: [], asked: [] } });
  const both = laid([{ id: "m", name: "MRI 1", carried: false, error_mm: 0, depth_mm: 27.2 }, { id: "o", name: "MRI 2", carried: true, error_mm: 9.2, depth_mm: 9 }]);
  expect(said(both)).toEqual([
    ["MRI 1", "27\u00a0mm deep", "as given"],
    ["MRI 2", "9\u00a0mm deep", "±\u00a09\u00a0mm, carried here"],
  ]);
  expect(chosenRow(planRows(both), both), "no pattern: nothing is chosen by itself").toBeNull();
  expect(chosenRow(planRows(both), { ...both, lesion: "o" })?.label).toBe("MRI 2");
});
