// What is drawn on the body for the measure that is pointed at.
import { afterEach, expect, test, vi } from "vitest";
import type { Measure, MeasuresFile } from "../../../src/api/types";
import { measuredLines } from "../../../src/stances/measures/measuredLines";
import { measureKey, measuresTable } from "../../../src/stances/measures/measuresTable";
import { withScan } from "../../fakes";

afterEach(() => void vi.unstubAllGlobals());

const row = (part: Partial<Measure>): Measure => ({ stance: "standing", measure: "notch_nipple", label: "Notch to nipple", kind: "along the skin", unit: "mm", said: { left: "201.3", right: "198.0" }, left: 201.26, right: 198, value: null, difference: 3.26, landmarks: "", method: "", left_low: null, left_high: null, right_low: null, right_high: null, value_low: null, value_high: null, paths: null, ...part });
const tape = row({ paths: { left: [[0, 0, 0], [1, 0, 0], [2, 1, 0]], right: [[0, 0, 0], [-1, 0, 0], [-2, 1, 0]], value: null } });
const file = (...measures: Measure[]): Pick<MeasuresFile, "measures" | "stances"> => ({ measures, stances: [] });

test("both sides with their lengths, for the row that is pointed at and for no other", () => {
  const other = row({ kind: "straight", paths: { left: [[0, 0, 0], [2, 1, 0]], right: null, value: null } });
  const lines = measuredLines(file(other, tape), "standing", measureKey(tape));
  expect(lines.map(({ side, says, isStraight }) => [side, says, isStraight])).toEqual([["left", "201.3\u00a0mm", false], ["right", "198.0\u00a0mm", false]]);
  expect(lines[0]!.points).toEqual([[0, 0, 0], [1, 0, 0], [2, 1, 0]]);
  expect(measuredLines(file(other, tape), "standing", measureKey(other))).toMatchObject([{ side: "left", isStraight: true }]);
  expect(measuredLines(file(other, tape), "standing", null)).toEqual([]);
});

test("a scan shows its own stance's lines; a change and a table of an older version have none", () => {
  const supine = row({ stance: "supine", paths: { left: [[5, 5, 5], [6, 6, 6], [7, 7, 7]], right: null, value: null } });
  const change = row({ stance: "supine - standing" });
  const key = measureKey(tape);
  expect(measuredLines(file(tape, supine, change), "supine", key)).toMatchObject([{ points: [[5, 5, 5], [6, 6, 6], [7, 7, 7]] }]);
  expect(measuredLines(file(tape, supine, change), "supine - standing", key)).toEqual([]);
  const { paths: _none, ...old } = tape;
  expect(measuredLines(file(old), "standing", key)).toEqual([]);
  expect(measuredLines(null, "standing", key)).toEqual([]);
});

test("a length stands half way along an open line, and in the middle of what a closed one goes around", () => {
  const loop = row({ kind: "volume", unit: "ml", paths: { left: [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [0, 0, 0]], right: null, value: [[0, 0, 0], [2, 2, 2]] } });
  const [closed, straight] = measuredLines(file(loop), "standing", measureKey(loop));
  expect(closed!.label[0]).toBeGreaterThan(1);
  expect(closed!.label[1]).toBeGreaterThan(1);
  expect(straight!.label).toEqual([1, 1, 1]);
  expect(measuredLines(file(tape), "standing", measureKey(tape))[0]!.label).toEqual([1, 0, 0]);
});

test("the parts of a ratio are shown without a length: it has none", () => {
  const ratio = row({ measure: "M3", kind: "ratio", unit: "1", left: null, right: null, value: 0.93, paths: { left: [[0, 0, 0], [1, 0, 0]], right: [[0, 0, 0], [-1, 0, 0]], value: null } });
  expect(measuredLines(file(ratio), "standing", measureKey(ratio)).map(({ says }) => says)).toEqual(["", ""]);
});

test("each line of the table has the key that its row is pointed at by, and closing the table lets go of it", async () => {
  const { store, actions } = await withScan();
  expect(measuresTable(file(tape)).lines.map(({ key }) => key)).toEqual([measureKey(tape)]);
  actions.stances.pointAt(measureKey(tape));
  expect(store.get().stances.measures.pointed).toBe("notch_nipple, along the skin");
  await actions.stances.measures(false);
  expect(store.get().stances.measures.pointed).toBeNull();
});
