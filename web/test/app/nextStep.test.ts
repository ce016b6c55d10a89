import { expect, test } from "vitest";
import type { LandmarkDefinition } from "../../src/api/types";
import { openDoubt } from "../../src/checks/doubts";
import { nextStep } from "../../src/app/nextStep";
import { initialSession, type Session } from "../../src/app/session";
import { startDrawn } from "../../src/drawing/state";
import { outdated } from "../../src/fit/outdated";
import type { Picks } from "../../src/landmarks/picks";
import { workspaceOf } from "../../src/stances/state";
import { record, startHistory } from "../../src/store/history";

const landmarks = ["notch", "nipple_L", "nipple_R", "umbilicus"].map((name) => ({ name }) as LandmarkDefinition);
const some: Picks = { notch: [0, 0, 0], nipple_L: [1, 0, 0], nipple_R: [-1, 0, 0] };
const withScan = { ...initialSession, checks: { ...initialSession.checks, of: { f0: null } }, meta: { landmarks }, scan: { file: null, info: { id: "s0" }, frame: { up: [0, 1, 0], front: [0, 0, 1] } } } as unknown as Session;
const fitted = (picks: Picks | null, state = "done") => ({ id: "f0", state, picks, certain: [] }) as unknown as Session["fit"];

test("without a scan, and while a fit runs, no step is the next", () => {
  expect(nextStep(initialSession).kind).toBe("none");
  expect(nextStep({ ...withScan, isStarting: true }).kind).toBe("none");
  expect(nextStep({ ...withScan, fit: fitted(null, "running") }).kind).toBe("none");
});

test("a fresh scan asks for the first landmark", () => {
  expect(nextStep({ ...withScan, step: "points" })).toEqual({ kind: "place", landmark: "notch", isArmed: false });
});

test("a size that may be wrong is asked about first, once for each scan", () => {
  const own = { ...withScan, scan: { file: {}, info: { id: "s1", size_doubt: "The body would be 53 m tall." } } } as unknown as Session;
  expect([openDoubt(own), nextStep(own)]).toEqual(["size", { kind: "none" }]);
  expect(nextStep({ ...own, confirmed: "s1" }).kind).toBe("fit");
  expect(openDoubt({ ...own, confirmed: "another" })).toBe("size");
});

test("while placing, the wanted landmark is the step", () => {
  const state: Session = { ...withScan, step: "points", active: "nipple_R" };
  expect(nextStep(state)).toEqual({ kind: "place", landmark: "nipple_R", isArmed: true });
});

test("when all are placed or skipped, the fit is next", () => {
  const state: Session = { ...withScan, step: "points", picks: startHistory(some), skipped: new Set(["umbilicus"]) };
  expect(nextStep(state)).toEqual({ kind: "fit", again: false, landmarks: 3 });
});

test("a finished fit offers the pen, until a landmark is changed", () => {
  const state: Session = { ...withScan, step: "body", picks: startHistory(some), fit: fitted(some) };
  expect(nextStep(state)).toEqual({ kind: "plan" });
  const changed = { ...state, picks: record(state.picks, { ...some, umbilicus: [0, -1, 0] as [number, number, number] }) };
  expect(nextStep(changed)).toEqual({ kind: "fit", again: true, landmarks: 4 });
});

test("what a fit asks about comes before its result, until it is answered", () => {
  const asks = { ...fitted(some), result: { landmarks_unusual: [{ names: ["notch"], reason: "notch is unusual." }] } } as unknown as Session["fit"];
  const state: Session = { ...withScan, step: "body", picks: startHistory(some), fit: asks };
  expect(nextStep(state)).toEqual({ kind: "check", count: 1, on: null });
  expect(nextStep({ ...state, step: "points", skipped: new Set(["umbilicus"]) }).kind).toBe("check");
  expect(nextStep({ ...state, step: "plan" }).kind, "while it pays").toBe("check");
  expect(nextStep({ ...state, step: "handover" }).kind).not.toBe("check");
  expect(nextStep({ ...state, certain: { notch: [0, 0, 0] } }), "kept, and not yet fitted so").toEqual({ kind: "fit", again: true, landmarks: 3 });
});

test("until the service has said what is worth checking, nothing is the next step", () => {
  const state: Session = { ...withScan, step: "body", picks: startHistory(some), fit: fitted(some) };
  expect(nextStep({ ...state, checks: initialSession.checks })).toEqual({ kind: "none" });
});

test("a failed fit offers another try", () => {
  expect(nextStep({ ...withScan, step: "body", fit: fitted(some, "failed"), picks: startHistory(some) })).toMatchObject({ kind: "fit", again: true });
});

const asked = { stance: "auto", preset: "default", refine: true } as const;
const finished = (more: Partial<Session> = {}): Session => ({ ...withScan, ...asked, step: "body", picks: startHistory(some), fit: { ...fitted(some)!, asked, iterations: [], result: { stance: "standing" } } as unknown as Session["fit"], ...more });

test("as soon as other settings are asked for than the fit was made with, the next step is to fit again", () => {
  expect(nextStep(finished()).kind).toBe("plan");
  for (const other of [{ stance: "supine" }, { preset: "paper" }, { refine: false }] satisfies Partial<Session>[]) {
    expect(nextStep(finished(other)), JSON.stringify(other)).toEqual({ kind: "fit", again: true, landmarks: 3 });
  }
  expect(nextStep(finished({ drawing: "reduction" })).kind, "a pattern is drawn on the body that is there: nothing is fitted again").toBe("plan");
  const asks = { ...finished().fit!, result: { stance: "standing", landmarks_unusual: [{ names: ["notch"], reason: "notch is unusual." }] } } as unknown as Session["fit"];
  expect(nextStep(finished({ fit: asks })).kind).toBe("check");
  expect(nextStep(finished({ fit: asks, preset: "paper" })).kind, "also while picks are asked about").toBe("fit");
  const file = { ...some, nipple_L: [9, 0, 0] as [number, number, number] };
  expect(nextStep(finished({ fit: asks, picks: startHistory(file) })), "and where a file has brought other landmarks").toEqual({ kind: "fit", again: true, landmarks: 3 });
  expect(nextStep(finished({ stance: "standing" })).kind, "which is what the fit decided by itself").toBe("plan");
});

test("when all landmarks were undone the fit belongs to landmarks that are gone, and another one is offered", () => {
  const state = finished({ picks: { past: [], present: {}, future: [some] } });
  expect(outdated(state)).toBe("gone");
  expect(nextStep({ ...state, step: "body" })).toEqual({ kind: "fit", again: true, landmarks: 0 });
  expect(outdated(finished({ picks: startHistory({ ...some }) })), "the same places are the same landmarks").toBeNull();
});

test("after a good fit a surgeon draws, brings the other stance, changes over to it, and takes the report", () => {
  const line = { name: "Line 1", closed: false, color: "#101010", points: [], corners: [] };
  const drawn = finished({ step: "plan", drawn: startDrawn([line]) });
  expect(nextStep({ ...drawn, step: "body" })).toEqual({ kind: "plan" });
  expect(nextStep(finished({ step: "plan", drawn: { ...startDrawn(), tool: "pen" } }))).toEqual({ kind: "draw", isArmed: true });
  expect(nextStep(drawn)).toEqual({ kind: "add", stance: "supine" });
  const there = [{ id: "there", stance: "supine" }] as unknown as typeof drawn.stances.scans;
  expect(nextStep({ ...drawn, stances: { ...drawn.stances, scans: there } }), "a lying scan stands in the strip already").toEqual({ kind: "print" });
  const other = { ...workspaceOf(drawn), stance: "supine", drawn: startDrawn(), fit: null } as const;
  expect(nextStep({ ...drawn, stances: { ...drawn.stances, other } })).toEqual({ kind: "change over", to: "supine" });
  const both = { ...other, fit: { ...drawn.fit!, result: { ...drawn.fit!.result!, stance: "supine" } } } as typeof other & { fit: NonNullable<Session["fit"]> };
  expect(nextStep({ ...drawn, stances: { ...drawn.stances, other: both } })).toEqual({ kind: "print" });
  const unsure = { ...other, fit: { ...drawn.fit!, result: { ...drawn.fit!.result!, stance: "supine", stance_asked: true } } } as unknown as NonNullable<Session["stances"]["other"]>;
  expect(nextStep({ ...drawn, stances: { ...drawn.stances, other: unsure } }), "what the other scan asks comes before printing").toEqual({ kind: "check", count: 1, on: "supine" });
  for (const [fit, kind] of [["f0", "wait"], ["another", "print"]] as const) {
    const awaited = { ...drawn.checks, awaited: new Set([fit]) };
    expect(nextStep({ ...drawn, checks: awaited, stances: { ...drawn.stances, scans: there } }).kind, "not before the checks of this plan are known").toBe(kind);
    const beside = { ...other, fit: { ...drawn.fit!, id: fit } };
    expect(nextStep({ ...drawn, checks: awaited, stances: { ...drawn.stances, other: beside } }).kind, "of either scan").toBe("wait");
  }
  expect(nextStep({ ...drawn, step: "handover" })).toEqual({ kind: "report" });
});

test("lines found on the skin are looked at before others are drawn, also when they are on the scan that is left", () => {
  const line = (name: string, kind = "line") => ({ name, ids: [name], kind, points: [] });
  const found = { s0: { state: "found", lines: [line("a"), line("b"), line("c", "cross")], kept: [] } } as unknown as Session["ink"];
  const open = finished({ ink: found, drawn: { ...startDrawn(), decided: {} } });
  expect(nextStep(open), "crosses are no lines").toEqual({ kind: "ink", count: 2, on: null });
  expect(nextStep({ ...open, step: "plan" }), "there they are in sight").toEqual({ kind: "draw", isArmed: false });
  expect(nextStep({ ...open, drawn: { ...open.drawn, decided: { a: "accepted" } } })).toEqual({ kind: "ink", count: 1, on: null });
  expect(nextStep({ ...open, drawn: { ...open.drawn, decided: { a: "accepted", b: "dropped" } } }).kind).toBe("plan");
  expect(nextStep({ ...open, drawn: startDrawn() }).kind, "what was decided before is not known yet").toBe("plan");
  const supine = { ...finished(), ink: found, scan: { ...open.scan!, info: { ...open.scan!.info, id: "s1" } }, fit: { ...open.fit!, result: { ...open.fit!.result!, stance: "supine" as const } } };
  for (const step of ["plan", "body"] as const) {
    expect(nextStep({ ...supine, step, stances: { ...supine.stances, other: workspaceOf(open) } })).toEqual({ kind: "ink", count: 2, on: "standing" });
  }
  const both = { ...supine, ink: { ...found, s1: found.s0 }, drawn: open.drawn, stances: { ...supine.stances, other: workspaceOf(open) } } as Session;
  expect(nextStep({ ...both, step: "plan" }).kind, "nobody is sent to and fro").toBe("draw");
});

test("nobody is sent on to draw on a fit that is not usable", () => {
  const bad = finished();
  const verdict = { level: "unusable", reasons: ["The model lies across the scan."] };
  expect(nextStep({ ...bad, fit: { ...bad.fit!, result: { ...bad.fit!.result!, verdict } } as Session["fit"] })).toEqual({ kind: "correct" });
});
