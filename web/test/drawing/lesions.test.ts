import { expect, test } from "vitest";
import type { PlanItem } from "../../src/api/types";
import { lesionAt, readCenter } from "../../src/drawing/lesions/lesions";
import { planChanges } from "../../src/drawing/changes";
import { startDrawn, stepOf } from "../../src/drawing/state";
import { lesions as words } from "../../src/drawing/text";
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
  expect(stepTogether(ITEMS, step, withLesions(ITEMS, "a", [moved]), "a").lesions).toEqual([moved]);
  expect(stepTogether(ITEMS, { ...step, lesions: [] }, withLesions(ITEMS, "a", [moved]), "a").lesions).toEqual([]);
});

test("a step of undoing holds the lesions", () => {
  const drawn = startDrawn([], { note: "", depthMm: null, lesions: [LESION] });
  expect(stepOf({ drawing: "", drawn }).lesions).toEqual([LESION]);
});

test("what was carried says how far it may be off, or that this is not known", () => {
  const says = words.says(6, 22.6);
  expect(says).toBe("6\u00a0mm, 23\u00a0mm below the skin");
  expect(words.carried(says, 8.4)).toBe(`${says}, carried here: nine of ten lie within 8\u00a0mm`);
  expect(words.carried(says, null)).toContain("not known");
});
