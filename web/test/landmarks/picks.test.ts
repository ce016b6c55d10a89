import { expect, test } from "vitest";
import type { Frame, LandmarkDefinition } from "../../src/api/types";
import { readLandmarks, toCsv, toJson } from "../../src/landmarks/files";
import { toMeshlab, toSlicer } from "../../src/landmarks/otherFormats";
import { frameFromPicks, nextMissing, onWrongSide, type Picks, sideOf, withoutPick, withPick } from "../../src/landmarks/picks";
import { leftOf } from "../../src/viewer/frame";

const names = ["suprasternal_notch", "nipple_L", "nipple_R", "umbilicus"];
const list = names.map((name) => ({ name, label: name, latin: "", definition: "", easy: true, mirror: name })) as LandmarkDefinition[];
const upright: Frame = { up: [0, 1, 0], front: [0, 0, 1] };
const picks: Picks = { suprasternal_notch: [1, 300, 40], nipple_L: [95, 120.5, 130], nipple_R: [-98, 118, 128] };

test("the side of a landmark is in its name", () => {
  expect(["nipple_L", "nipple_R", "umbilicus"].map(sideOf)).toEqual(["left", "right", "middle"]);
});

test("picks are changed without touching the ones before", () => {
  const more = withPick(picks, "umbilicus", [0, -100, 90]);
  expect(Object.keys(more)).toEqual(names);
  expect(withoutPick(more, "umbilicus")).toEqual(picks);
  expect("umbilicus" in picks).toBe(false);
});

test("the next landmark is the first open one after the last, round the end of the list", () => {
  expect(nextMissing(list, {}, new Set())).toBe("suprasternal_notch");
  expect(nextMissing(list, picks, new Set())).toBe("umbilicus");
  expect(nextMissing(list, { umbilicus: [0, 0, 0] }, new Set(["suprasternal_notch"]), "umbilicus")).toBe("nipple_L");
  expect(nextMissing(list, picks, new Set(["umbilicus"]))).toBeNull();
});

test("swapped sides are noticed from each pair, also on a body that stands askew", () => {
  const swapped = { ...picks, nipple_L: picks.nipple_R!, nipple_R: picks.nipple_L! };
  const askew: Frame = { up: [0.6, 0.8, 0], front: [0, 0, 1] };
  expect([...onWrongSide(picks, upright)]).toEqual([]);
  expect([...onWrongSide(picks, askew)]).toEqual([]);
  expect([...onWrongSide(swapped, upright)].sort()).toEqual(["nipple_L", "nipple_R"]);
  expect([...onWrongSide({ nipple_L: [-50, 0, 0] }, upright)]).toEqual([]); // alone it says nothing
});

test("a pair and two points of the midline say how the body stands; fewer say nothing", () => {
  const askew: Picks = { nipple_L: [0, 100, 0], nipple_R: [0, -100, 0], umbilicus: [200, 5, -60], suprasternal_notch: [-150, 0, 0] };
  const frame = frameFromPicks(askew)!;
  expect(leftOf(frame)[1]).toBeCloseTo(1, 12);
  expect(frame.up[0]).toBeLessThan(-0.9);
  expect(frameFromPicks(withoutPick(askew, "nipple_L"))).toBeNull();
  expect(frameFromPicks(withoutPick(askew, "umbilicus"))).toBeNull();
  expect(frameFromPicks({})).toBeNull();
});

test("landmark files come back as they were written", () => {
  expect(readLandmarks(toJson(picks), "m", list)).toEqual(picks);
  const again = readLandmarks(toCsv(picks, "m"), "m", list);
  for (const [name, point] of Object.entries(picks)) point.forEach((mm, axis) => expect(again[name]![axis]).toBeCloseTo(mm, 4));
});

test("MeshLab's picked points come back, and a point that was not picked is none", () => {
  const text = toMeshlab(picks, "m");
  const again = readLandmarks(text, "m", list);
  expect(Object.keys(again)).toEqual(Object.keys(picks));
  for (const [name, point] of Object.entries(picks)) point.forEach((mm, axis) => expect(again[name]![axis]).toBeCloseTo(mm, 4));
  const template = text.replace('active="1"', 'active="0"');
  expect(Object.keys(readLandmarks(template, "m", list)).length).toBe(Object.keys(picks).length - 1);
});

test("3D Slicer's markups come back, in a file that names its format", () => {
  const text = toSlicer(picks, "m");
  expect((JSON.parse(text) as Record<string, string>)["@schema"]).toMatch(/markups-schema-v1\.0\.3\.json#$/);
  const again = readLandmarks(text, "m", list);
  expect(Object.keys(again)).toEqual(Object.keys(picks));
  for (const [name, point] of Object.entries(picks)) point.forEach((mm, axis) => expect(again[name]![axis]).toBeCloseTo(mm, 4));
});

test("3D Slicer's markups are read in the scan's unit, from either frame, without what was not placed", () => {
  const point = (label: string, position: number[], positionStatus = "defined") => ({ label, position, positionStatus });
  const file = (coordinateSystem: string) =>
    JSON.stringify({ markups: [{ coordinateSystem, coordinateUnits: "mm", controlPoints: [point("nipple_L", [0.1, 0.2, 0.3]), point("nipple_R", [0, 0, 0], "undefined")] }] });
  expect(readLandmarks(file("LPS"), "m", list)).toEqual({ nipple_L: [100, 200, 300] });
  expect(readLandmarks(file("RAS"), "m", list)).toEqual({ nipple_L: [-100, -200, 300] });
});

test("a JSON file without unit is in the scan's unit", () => {
  const text = JSON.stringify({ landmarks: { nipple_L: [0.1, 0.2, 0.3] } });
  expect(readLandmarks(text, "m", list).nipple_L).toEqual([100, 200, 300]);
});

test.each([
  ["{ not json", "not valid JSON"],
  ['{"landmarks": {"nose": [1, 2, 3]}}', "“nose” is not a landmark"],
  ['{"landmarks": {"nipple_L": [1, null, 3]}}', "needs three numbers"],
  ['{"landmarks": {"nipple_L": [1, 2]}}', "needs three numbers"],
  ['{"unit": "feet", "landmarks": {}}', "“feet” is not known"],
  ['{"points": []}', "holds no “landmarks”"],
  ["name,x,y,z\nnipple_L,1,,3", "needs three numbers"],
  ["name,x,y,z\nnipple_L,1,2,3,4", "needs three numbers"],
  ['{"markups": [{"coordinateSystem": "XYZ", "controlPoints": []}]}', "neither LPS nor RAS"],
  ["<html></html>", "not a MeshLab file"],
  ["<PickedPoints><point x='1'/></PickedPoints>", "is not a landmark"],
  ["", "holds no landmarks"],
])("a bad landmark file (%s) is refused with one sentence", (text, sentence) => {
  expect(() => readLandmarks(text, "mm", list)).toThrow(sentence);
});
