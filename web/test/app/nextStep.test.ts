import { expect, test } from "vitest";
import type { LandmarkDefinition } from "../../src/api/types";
import { nextStep } from "../../src/app/nextStep";
import { initialSession, type Session } from "../../src/app/session";
import type { Picks } from "../../src/landmarks/picks";
import { record, startHistory } from "../../src/store/history";

const landmarks = ["notch", "nipple_L", "nipple_R", "umbilicus"].map((name) => ({ name }) as LandmarkDefinition);
const some: Picks = { notch: [0, 0, 0], nipple_L: [1, 0, 0], nipple_R: [-1, 0, 0] };
const withScan = { ...initialSession, meta: { landmarks }, scan: { file: null, frame: { up: [0, 1, 0], front: [0, 0, 1] } } } as unknown as Session;
const fitted = (picks: Picks | null, state = "done") => ({ state, picks, certain: [] }) as unknown as Session["fit"];

test("without a scan, and while a fit runs, no step is the next", () => {
  expect(nextStep(initialSession).kind).toBe("none");
  expect(nextStep({ ...withScan, isStarting: true }).kind).toBe("none");
  expect(nextStep({ ...withScan, fit: fitted(null, "running") }).kind).toBe("none");
});

test("a fresh scan asks for the first landmark", () => {
  expect(nextStep(withScan)).toEqual({ kind: "place", landmark: "notch", isArmed: false });
});

test("a scan of one's own is looked at first: size and direction; once for each, and never after landmarks were placed", () => {
  const own = { ...withScan, scan: { file: {}, info: { id: "s1" } } } as unknown as Session;
  expect(nextStep(own)).toEqual({ kind: "confirm scan" });
  expect(nextStep({ ...own, confirmed: "s1" }).kind).toBe("place");
  expect(nextStep({ ...own, confirmed: "another" }).kind).toBe("confirm scan");
  expect(nextStep({ ...own, picks: startHistory(some) }).kind).toBe("fit");
  expect(nextStep({ ...own, step: "fit" }).kind).toBe("fit");
});

test("while placing, the wanted landmark is the step", () => {
  const state: Session = { ...withScan, step: "landmarks", active: "nipple_R" };
  expect(nextStep(state)).toEqual({ kind: "place", landmark: "nipple_R", isArmed: true });
});

test("when all are placed or skipped, the fit is next", () => {
  const state: Session = { ...withScan, step: "landmarks", picks: startHistory(some), skipped: new Set(["umbilicus"]) };
  expect(nextStep(state)).toEqual({ kind: "fit", again: false, landmarks: 3 });
});

test("a finished fit offers its result, until a landmark is changed", () => {
  const state: Session = { ...withScan, step: "result", picks: startHistory(some), fit: fitted(some) };
  expect(nextStep(state)).toEqual({ kind: "save" });
  const changed = { ...state, picks: record(state.picks, { ...some, umbilicus: [0, -1, 0] as [number, number, number] }) };
  expect(nextStep(changed)).toEqual({ kind: "fit", again: true, landmarks: 4 });
});

test("what a fit asks about comes before its result, until it is answered", () => {
  const asks = { ...fitted(some), result: { landmarks_unusual: [{ names: ["notch"], reason: "notch is unusual." }] } } as unknown as Session["fit"];
  const state: Session = { ...withScan, step: "result", picks: startHistory(some), fit: asks };
  expect(nextStep(state)).toEqual({ kind: "check", count: 1 });
  expect(nextStep({ ...state, step: "landmarks", skipped: new Set(["umbilicus"]) }).kind).toBe("check");
  expect(nextStep({ ...state, step: "drawing" }).kind).toBe("save");
  expect(nextStep({ ...state, certain: { notch: [0, 0, 0] } }), "kept, and not yet fitted so").toEqual({ kind: "fit", again: true, landmarks: 3 });
});

test("a failed fit offers another try", () => {
  expect(nextStep({ ...withScan, step: "fit", fit: fitted(some, "failed"), picks: startHistory(some) })).toMatchObject({ kind: "fit", again: true });
});
