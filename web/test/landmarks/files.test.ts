import { expect, test } from "vitest";
import type { LandmarkDefinition } from "../../src/api/types";
import { readCertain, readLandmarks } from "../../src/landmarks/files/files";
import { toCsv, toJson, toMeshlab, toSlicer } from "../../src/landmarks/files/writing";
import type { Picks } from "../../src/landmarks/picks";

const names = ["suprasternal_notch", "nipple_L", "nipple_R", "umbilicus"];
const list = names.map((name) => ({ name, label: name, latin: "", definition: "", easy: true, mirror: name })) as LandmarkDefinition[];
const picks: Picks = { suprasternal_notch: [1, 300, 40], nipple_L: [95, 120.5, 130], nipple_R: [-98, 118, 128] };

test("landmark files come back as they were written", () => {
  expect(readLandmarks(toJson(picks, "m", []), "m", list)).toEqual(picks);
  const again = readLandmarks(toCsv(picks, "m"), "m", list);
  for (const [name, point] of Object.entries(picks)) point.forEach((mm, axis) => expect(again[name]![axis]).toBeCloseTo(mm, 4));
});

test("what is certain comes back from our own kind; other kinds have none", () => {
  expect(readCertain(toJson(picks, "m", ["nipple_R"]), picks)).toEqual(["nipple_R"]);
  expect(toJson(picks, "m", [])).not.toContain("certain");
  for (const text of [toJson(picks, "m", []), toCsv(picks, "m"), toMeshlab(picks, "m"), toSlicer(picks, "m")]) expect(readCertain(text, picks)).toEqual([]);
});

test.each([
  ['"nipple_L"', "must be a list of landmarks' names"],
  ["[1]", "must be a list of landmarks' names"],
  ["null", "must be a list of landmarks' names"],
  ['["umbilicus"]', "names “umbilicus”, which is not among the file's landmarks"],
])("what cannot be certain is said in a sentence: %s", (certain, sentence) => {
  expect(() => readCertain(`{"landmarks": {"nipple_L": [1, 2, 3]}, "certain": ${certain}}`, { nipple_L: [1, 2, 3] })).toThrow(sentence);
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
