// The plan's list, and what its columns say of numbers that the body did not let be as asked.
import { expect, test } from "vitest";
import type { PatternParameter, PlanOnScan } from "../../src/api/types";
import { columnsOf, drawnNumber, reasonsOf } from "../../src/drawing/panel/drawnNumbers";
import { chosenRow, planRows, planScans } from "../../src/drawing/panel/items";
import { laidOnScan, type LiveHandle, startDrawn } from "../../src/drawing/state";
import { lineAlong } from "../../src/drawing/lines/edits";

const parameter = (name: string, more: Partial<PatternParameter> = {}): PatternParameter => ({ name, label: name, about: "", unit: "mm", default: null, needed: false, min: 0, max: 100, choices: null, ...more });
const SIDE = parameter("side", { unit: "", default: "both", choices: ["both", "L", "R"] });
const AREOLA = parameter("areola_mm", { label: "New areola", default: 42 });
const LIMB = parameter("limb_mm", { label: "Vertical limbs" });
const ABOVE = parameter("nipple_above_fold_mm", { label: "New nipple above the fold", default: 0 });
const ALL = [SIDE, AREOLA, LIMB, ABOVE];

const handle = (side: "L" | "R", measured: Record<string, number>): LiveHandle => ({ name: `limb_${side}`, side, label: "", at_mm: [0, 0, 0], grows: [0, 0, 0], numbers: [{ parameter: "limb_mm", label: "", unit: "mm", value: 1, min: null, max: null }], id: `values/limb_${side}`, part: "values", measured });
const HANDLES = [handle("R", { areola_mm: 42.3, limb_mm: 33.2, nipple_above_fold_mm: 38 }), handle("L", { areola_mm: 40.4, limb_mm: 50.2, nipple_above_fold_mm: 0.3 })];

test("a pattern has a column for each of its sides, the patient's right first; before a side is said there is one", () => {
  expect(columnsOf({}, ALL)).toEqual(["R", "L"]);
  expect(columnsOf({ side: "L" }, ALL)).toEqual(["L"]);
  expect(columnsOf({}, [{ ...SIDE, default: null }])).toEqual([null]);
});

test("a field says what is drawn on its side; dashed where that is not what was asked for", () => {
  const at = (of: PatternParameter, side: "L" | "R", values = {}) => drawnNumber(of, values, "values", side, HANDLES);
  expect(at(AREOLA, "R"), "within what a hand holds: as asked").toEqual({ value: 42, drawn: 42, isForced: false });
  expect(at(AREOLA, "L")).toEqual({ value: 40, drawn: 40, isForced: true });
  expect(at(LIMB, "R"), "chosen by itself, and shorter than usual").toEqual({ value: null, drawn: 33, isForced: true });
  expect(at(LIMB, "L")).toEqual({ value: null, drawn: 50, isForced: false });
  expect(at(ABOVE, "R")).toEqual({ value: 38, drawn: 38, isForced: true });
  expect(drawnNumber(AREOLA, {}, "values", "R", []), "before it is drawn").toEqual({ value: 42, drawn: null, isForced: false });
  expect(drawnNumber(AREOLA, {}, "tumour", "R", HANDLES).drawn, "another part's handles say nothing").toBeNull();
});

test("each dashed number has its reason, one sentence", () => {
  expect(reasonsOf(ALL, {}, "values", HANDLES)).toEqual([
    "New areola: 42\u00a0mm asked, drawn otherwise on this skin.",
    "Limbs are shortened to stay clear of the fold.",
    "The nipple is already above the fold, and this pattern never lowers it.",
  ]);
  expect(reasonsOf(ALL, { limb_mm: "33", areola_mm: "40.4", nipple_above_fold_mm: "0", side: "L" }, "values", HANDLES)).toEqual(["Vertical limbs: 33\u00a0mm asked, drawn otherwise on this skin."]);
  expect(reasonsOf(ALL, {}, "values", [])).toEqual([]);
  const apart = { areola_mm_left: "40", areola_mm_right: "38", limb_mm_left: "50", limb_mm_right: "33" };
  expect(reasonsOf(ALL, apart, "values", HANDLES)[0], "each side against its own number").toBe("New areola: 38\u00a0mm asked, drawn otherwise on this skin.");
  expect(drawnNumber(AREOLA, apart, "values", "L", HANDLES)).toEqual({ value: 40, drawn: 40, isForced: false });
});

test("one row for a pattern with all its lines, saying on which sides it is; lines, notes and what was carried have theirs", () => {
  const shape = (name: string, more: object = {}) => ({ name, kind: "pattern", item: "p", carried: false, points: [], closed: false, color: "#101010", ...more });
  const plan = { unit: "mm", shapes: [shape("wise_L"), shape("areola_L"), shape("cut", { kind: "line", carried: true, item: "c", line_error_mm: 9.4 })], lesions: [] } as unknown as PlanOnScan;
  const line = { ...lineAlong("Line 1", "#101010", [[0, 0, 0], [30, 0, 0]], false), id: "one" };
  const drawn = { ...startDrawn([line], { note: "smaller", depthMm: null, lesions: [] }), onScan: laidOnScan("standing", [], plan), hidden: new Set(["own/Line 1"]) };
  const state = { meta: null, models: {}, fit: null, drawing: "reduction", lesion: null, item: null, drawn, scan: null, stances: { isCarrying: false, other: null, scans: [], asked: [] } };
  const rows = planRows(state);
  expect(rows.map(({ kind, label, says, hint, isHidden }) => [kind, label, says, hint, isHidden])).toEqual([
    ["pattern", "reduction", "left", "", false],
    ["line", "Line 1", "3.0\u00a0cm", "as given", true],
    ["carried", "cut", "from standing", "±\u00a09\u00a0mm, carried here", false],
    ["note", "smaller", "", "", false],
  ]);
  expect(chosenRow(rows, state)?.kind, "the pattern by itself").toBe("pattern");
  expect(chosenRow(rows, { ...state, drawn: { ...drawn, chosen: "Line 1" } })?.kind).toBe("line");
  expect(chosenRow(rows, { ...state, item: "note" })?.kind).toBe("note");
  expect(chosenRow(rows, { ...state, item: "" }), "put aside").toBeNull();
});

test("a pattern says on which scans it lies: those with a fit that can be used", () => {
  const kept = (id: string, stance: string, kind: string, state: string, verdict: string | null) => ({ id, stance, kind, fit: { state, verdict } });
  const scans = [kept("a", "standing", "surface", "failed", null), kept("b", "supine", "surface", "done", "check"), kept("c", "prone", "image", "done", "good"), kept("d", "standing", "surface", "done", "unusable"), { ...kept("e", "supine", "surface", "done", "good"), fit: null }];
  const fit = { state: "done", drawing: null, result: { verdict: { level: "good", reasons: [] }, model: { sha256: "" } } };
  const of = (stances: object = {}) => ({ scan: { info: { id: "a" } }, fit, stances: { isCarrying: false, other: null, scans, asked: [], ...stances } }) as unknown as Parameters<typeof planScans>[0];
  expect(planScans(of()), "of the scan in work the fit on the page counts").toEqual(["standing", "supine", "MRI"]);
  expect(planScans(of({ other: { scan: { info: { id: "b" } }, fit: { state: "running", result: null } } }))).toEqual(["standing", "MRI"]);
  expect(planScans(of({ asked: [{}] })), "whether they are one patient's is asked").toEqual([]);
  const shapes = ["wise_L", "wise_R"].map((name) => ({ name, kind: "pattern", item: "p", carried: false, points: [], closed: false, color: "#101010" }));
  const drawn = { ...startDrawn([], { note: "", depthMm: null, lesions: [] }), onScan: laidOnScan("supine", [], { unit: "mm", shapes, lesions: [] } as unknown as PlanOnScan) };
  const [row] = planRows({ ...of(), meta: null, models: {}, drawing: "reduction", lesion: null, item: null, drawn });
  expect(row!.says).toBe("both, on standing, supine and MRI");
});
