import { expect, test } from "vitest";
import type { FitState } from "../../src/fit/state";
import { fileOf } from "../../src/landmarks/keeper";
import { askedOfMarks, freeMark, listedMarks, nextBeside } from "../../src/landmarks/marks/marks";
import { frameFromPicks, nextMissing, onWrongSide, type Picks, picksOf, placesOf, renamed, sideOf } from "../../src/landmarks/picks";
import { pickCount } from "../../src/landmarks/state";
import { picksSaid } from "../../src/landmarks/text";
import { marksBeside } from "../../src/stances/marksBeside";
import { initialStances, type StancesSlice, type Workspace } from "../../src/stances/state";
import { startHistory } from "../../src/store/history";

const file = { landmarks: { nipple_L: [1, 2, 3] as [number, number, number] }, marks: { mole: [0.1, 0.2, 0.3] as [number, number, number] }, unit: "mm" };
const picks: Picks = { nipple_L: [1, 2, 3], "mark:mole": [0.1, 0.2, 0.3] };

test("marks of a file are picks beside its landmarks, and go back into the file under their own names", () => {
  expect(picksOf(file)).toEqual(picks);
  expect(placesOf(picks)).toEqual({ landmarks: file.landmarks, marks: file.marks });
  expect(fileOf({ picks, certain: ["nipple_L"] })).toEqual({ schema: "breastrig/landmarks@1", ...file, certain: ["nipple_L"] });
  expect(picksOf({ landmarks: {}, marks: { mole: [0.1, 0.2, 0.3] }, unit: "m" })).toEqual({ "mark:mole": [100, 200, 300] });
});

test("a mark is no landmark: it is not counted, wanted, exchanged or asked for the body's sides, whatever it is called", () => {
  const named: Picks = { "mark:mole_L": [-50, 0, 0], "mark:mole_R": [50, 0, 0], "mark:umbilicus": [0, 0, 0], "mark:xiphoid": [0, 200, 0] };
  expect(pickCount({ picks: startHistory(named) })).toBe(0);
  expect(sideOf("mark:mole_L")).toBe("middle");
  expect(onWrongSide(named, { up: [0, 1, 0], front: [0, 0, 1] }).size).toBe(0);
  expect(frameFromPicks(named)).toBeNull();
  expect(nextMissing([], named, new Set())).toBeNull();
  expect(picksSaid({}, { "mark:mole": [1, 2, 3] }, [])).toBe("placed mark \u201cmole\u201d");
  expect(picksSaid({}, named, []), "points: a landmark or a mark").toBe("placed 4 points");
});

test("what is asked about a mark is said by its name, as long as it is on the scan", () => {
  const plan = { marks: [{ asked: [{ name: "mole", says: "Is it the same place?" }, { name: "gone", says: "And this?" }] }] };
  const fit = { result: { marks_asked: [{ names: ["dot"], reason: "It lies off the skin." }] } } as never;
  const asked = askedOfMarks({ fit, drawn: { onScan: { plan } } }, { ...picks, "mark:dot": [0, 0, 0] });
  expect([...asked]).toEqual([["mark:mole", "Is it the same place?"], ["mark:dot", "It lies off the skin."]]);
  expect(askedOfMarks({ fit: null, drawn: { onScan: null } }, picks).size).toBe(0);
});

test("a new mark is called as none is on either scan; a renamed one keeps its place in the list", () => {
  expect(freeMark([])).toBe("mark:mark 1");
  expect(freeMark(["mark:mark 1", "mark:mark 3", "nipple_L"])).toBe("mark:mark 2");
  expect(Object.entries(renamed({ "mark:a": [1, 1, 1], "mark:b": [2, 2, 2] }, "mark:a", "mark:mole"))).toEqual([["mark:mole", [1, 1, 1]], ["mark:b", [2, 2, 2]]]);
});

test("after a mark of the other scan its next one is wanted, round the end, until none is missing", () => {
  const beside = { "mark:a": null, "mark:b": null, "mark:c": null };
  expect(nextBeside(beside, { "mark:b": [0, 0, 0] }, "mark:b")).toBe("mark:c");
  expect(nextBeside(beside, { "mark:c": [0, 0, 0] }, "mark:c")).toBe("mark:a");
  expect(nextBeside(beside, { "mark:a": [0, 0, 0], "mark:b": [0, 0, 0], "mark:c": [0, 0, 0] }, "mark:c")).toBeNull();
  expect(listedMarks({ "mark:c": [0, 0, 0], nipple_L: [0, 0, 0], "mark:d": [0, 0, 0] }, beside)).toEqual(["mark:c", "mark:d", "mark:a", "mark:b"]);
});

test("a mark is expected at its point of the model's skin, as fitted here; nowhere without a fit of both", () => {
  const surface = { places: new Float32Array([0, 0, 0, 0.1, 0, 0, 0, 0.2, 0]), corners: new Uint16Array([0, 1, 2]) };
  const fit = { surface, result: { scan: { unit: "m" } } } as unknown as FitState;
  const marked = (marks: unknown): StancesSlice => {
    const other = { picks: startHistory({ ...picks, "mark:new": [9, 9, 9] as const }), fit: { result: { marks } } } as unknown as Workspace;
    return { stances: { ...initialStances, other } };
  };
  const known = { mole: { point: [0, 0, 0], off_scan_mm: 0, face: 0, barycentric: [0.25, 0.5, 0.25] } };
  const { "mark:mole": mole, ...rest } = marksBeside({ fit, ...marked(known) });
  expect(mole!.map((value) => Math.round(value * 1000) / 1000)).toEqual([50, 50, 0]);
  expect(rest).toEqual({ "mark:new": null });
  expect(marksBeside({ fit: null, ...marked(known) })).toEqual({ "mark:mole": null, "mark:new": null });
  expect(marksBeside({ fit, stances: initialStances })).toEqual({});
});
