// Two stances: the linked camera's pose, the page that changes over, the drawing that is carried, the table of measures.
import { Euler, Matrix4, Quaternion, Vector3 } from "three";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fitLinks, page, scanInfo } from "../fakes";
import { ApiError, type Client } from "../../src/api/client";
import { openDoubt } from "../../src/checks/doubts";
import type { Fit, Measure, Patient, PlannedShape, PlanOnScan, Vector } from "../../src/api/types";
import { INK } from "../../src/drawing/lines/lines";
import { laidOnScan } from "../../src/drawing/state";
import type { FitState } from "../../src/fit/state";
import { linkedPose, torsoFromFrame, torsoFromLandmarks } from "../../src/stances/cameras";
import { carriedNote } from "../../src/stances/carry";
import { measuredDoubts, measuresTable, saidOf } from "../../src/stances/measures/measuresTable";
import { stanceNames, workspaceOf } from "../../src/stances/state";
import { daysOf, thumbsOf } from "../../src/stances/thumbs";

const rigid = (x: number, y: number, z: number, at: readonly [number, number, number]): Matrix4 =>
  new Matrix4().compose(new Vector3(...at), new Quaternion().setFromEuler(new Euler(x, y, z)), new Vector3(1, 1, 1));

const TORSO: Record<string, Vector> = {
  suprasternal_notch: [0, 420, 80],
  xiphoid: [0, 250, 100],
  umbilicus: [0, 60, 90],
  nipple_L: [100, 270, 120],
  nipple_R: [-100, 270, 120],
};

const moved = (by: Matrix4): Record<string, Vector> =>
  Object.fromEntries(Object.entries(TORSO).map(([name, at]) => [name, new Vector3(...at).multiplyScalar(1e-3).applyMatrix4(by).multiplyScalar(1e3).toArray()]));

test("the torso's frame goes with the body: patient's left, up and front, the breastbone as origin", () => {
  const still = torsoFromLandmarks(TORSO)!;
  const by = rigid(0.4, -1.1, 2.0, [0.3, -0.2, 0.7]);
  const there = torsoFromLandmarks(moved(by))!;
  new Matrix4().multiplyMatrices(by, still).elements.forEach((value, i) => expect(there.elements[i]).toBeCloseTo(value, 9));
  expect(new Vector3().setFromMatrixPosition(still).distanceTo(new Vector3(0, 0.335, 0.09))).toBeLessThan(1e-12);
  expect(torsoFromLandmarks({ nipple_L: TORSO.nipple_L! })).toBeNull();
});

test("the linked camera sees the other torso as the first sees its own", () => {
  const by = rigid(-1.3, 0.2, 0.5, [0.1, 0.9, -0.4]); // the second scan has other axes
  const [a, b] = [torsoFromLandmarks(TORSO)!, torsoFromLandmarks(moved(by))!];
  const [worldA, worldB] = [rigid(0, 0.1, 0, [0, -0.3, 0]), rigid(0.7, 0, -0.2, [0.2, 0, 0])];
  const pose = { eye: new Vector3(0.6, 0.4, 1.9), target: new Vector3(0.02, 0.1, 0) };
  const linked = linkedPose(pose, { world: worldA, torso: a }, { world: worldB, torso: b });
  expect(linked.eye.distanceTo(linked.target)).toBeCloseTo(pose.eye.distanceTo(pose.target), 9);
  const seen = (eye: Vector3, world: Matrix4, at: Vector): number => eye.distanceTo(new Vector3(...at).multiplyScalar(1e-3).applyMatrix4(world));
  for (const name of Object.keys(TORSO)) expect(seen(linked.eye, worldB, moved(by)[name]!)).toBeCloseTo(seen(pose.eye, worldA, TORSO[name]!), 9);
  const back = linkedPose(linked, { world: worldB, torso: b }, { world: worldA, torso: a });
  expect(back.eye.distanceTo(pose.eye)).toBeLessThan(1e-9);
});

test("from above and below a body that leans otherwise stands on the picture as the first one does", () => {
  const [a, b] = [torsoFromLandmarks(TORSO)!, torsoFromLandmarks(moved(rigid(0.09, 0, 0.07, [0, 0, 0])))!];
  const same = { world: new Matrix4(), torso: a };
  for (const y of [2, -2]) {
    for (const z of [1e-6, 0.1]) {
      const pose = { eye: new Vector3(0, y, z), target: new Vector3() };
      const linked = linkedPose(pose, same, { world: new Matrix4(), torso: b });
      const gaze = linked.eye.clone().sub(linked.target);
      expect(gaze.length()).toBeCloseTo(pose.eye.length(), 9);
      const turned = (Math.atan2(gaze.x, gaze.z) * 180) / Math.PI; // of the picture
      expect(Math.abs(turned), `${y} ${z}`).toBeLessThan(8); // the body's own turn is 4 degrees
    }
  }
});

test("bodies that stand upright by their frames alone share one pose", () => {
  const frame = { up: [0, 0, 1] as Vector, front: [0, -1, 0] as Vector };
  const torso = torsoFromFrame(frame, [0.1, 0.2, 0.3]);
  const world = torso.clone().invert();
  const pose = { eye: new Vector3(0, 0.1, 2), target: new Vector3() };
  const linked = linkedPose(pose, { world, torso }, { world: new Matrix4(), torso: new Matrix4() });
  expect(linked.eye.distanceTo(pose.eye)).toBeLessThan(1e-12);
});

const row = (stance: string, part: Partial<Measure>): Measure => ({
  stance, measure: "notch to nipple", label: "Notch to nipple", kind: "along the skin", unit: "mm", left: null, left_low: null, left_high: null, right: null, right_low: null,
  right_high: null, difference: null, value: null, value_low: null, value_high: null, landmarks: "", method: "geodesic", ...part,
});

const MEASURES = [
  row("standing", { said: { left: "201.3" }, left: 201.26, right: 198.04, difference: 3.22, landmarks: "notch (picked)" }),
  row("standing", { measure: "symmetry", kind: "ratio", unit: "1", value: 0.956, said: { value: "0.96" } }),
  row("standing", { kind: "straight", left: 180, right: 181, difference: -1 }),
  row("supine", { said: { left: "188.5" }, left: 188.5, right: 189.5, difference: -1, landmarks: "notch (model's)" }),
  row("supine - standing", { said: { left: "-12.8 ±3" }, left: -12.76, right: -8.54, difference: -4.22 }),
];

test("the table has one line for each measure, the stances beside each other, and gaps where there is none", () => {
  const stances = [{ name: "standing" }, { name: "supine" }] as never;
  const { groups, lines } = measuresTable({ measures: MEASURES, stances });
  expect(groups).toEqual(["standing", "supine", "supine - standing"]);
  expect(lines.map(({ measure }) => measure)).toEqual(["notch to nipple", "symmetry", "notch to nipple"]);
  expect(lines[0]!.cells.map((cell) => saidOf(cell, "left"))).toEqual(["201.3", "188.5", "\u221212.8\u00a0±3"]);
  expect(lines[1]!.cells.map((cell) => saidOf(cell, "value"))).toEqual(["0.96", "–", "–"]);
  expect(lines[0]!.landmarks).toEqual([{ stance: "standing", words: "notch (picked)" }, { stance: "supine", words: "notch (model's)" }]);
});

test("of what the scan does not show the reason is that of the row", () => {
  const unseen = row("standing", { left: 290, method: "by the model; the scan shows 0 % of the right breast", not_seen: "right" });
  const [line] = measuresTable({ measures: [unseen], stances: [{ name: "standing" }] as never }).lines;
  expect(line!.method).toContain("0 % of the right breast");
});

test("measures of a fit that is not good say so before any number, each with its stance", () => {
  const of = (name: string, level: "good" | "check" | "unusable") => ({ name, verdict: { level, reasons: level === "good" ? [] : [`Because of ${name}.`] } });
  const doubts = measuredDoubts({ stances: [of("standing", "unusable"), of("supine", "good"), of("supine B", "check"), { name: "old" }] as never });
  expect(doubts).toEqual([expect.stringMatching(/^Standing: .+\. Because of standing\.$/), expect.stringMatching(/^Supine B: .+\. Because of supine B\.$/)]);
});

const shape = (part: Partial<PlannedShape>): PlannedShape => ({ name: "Line 1", closed: false, color: INK, points: [[0, 0, 0]], bridged: [false], item: "a", kind: "line", carried: true, ...part });
const CARRIED: PlanOnScan = {
  schema: "breastrig/drawing@1", name: "plan", unit: "mm", notice: "", notes: [], lesions: [], missing: [], version: 1, whole: true, fit: "f2", carried_from: [{ scan: "standing", fit: "f1" }],
  shapes: [
    shape({ points: [[0, 0, 0], [1, 0, 0], [2, 0, 0]], bridged: [false, false, true], error_mm: [4, null, 9], line_error_mm: 5 }),
    shape({ name: "tumour_L", item: "t", kind: "tumour", error_mm: [5], line_error_mm: 3.6 }),
    shape({ name: "wise_R", item: "p", kind: "pattern", carried: false, error_mm: [80] }),
  ],
};

test("the note says how far off what was carried may be, and how much lies over holes", () => {
  const onScan = laidOnScan("standing", [], CARRIED);
  expect(carriedNote(onScan.carried)).toEqual({ points: 4, bridged: 1, error: 5 });
  expect(carriedNote({ shapes: [] })).toEqual({ points: 0, bridged: 0, error: null });
  expect(onScan.patterns.shapes.map(({ name }) => name)).toEqual(["wise_R"]);
});

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const done = (id: string): FitState => ({
  id, links: fitLinks(id), state: "done", started: null, iterations: [], shown: -1, playing: false, result: null, drawing: null, drawingName: null,
  surface: { places: new Float32Array(9), corners: new Uint16Array(3) }, distances: null, reason: null, isConnected: true, picks: null, certain: [], before: null,
});
const LINE = { name: "Line 1", closed: false, color: INK, points: [[0, 0, 0], [2, 0, 0]] as Vector[], corners: [0, 1] };

async function two() {
  const planOnFit = vi.fn<Client["planOnFit"]>(async () => CARRIED);
  const moveScan = vi.fn<Client["moveScan"]>();
  const patient = vi.fn<Client["patient"]>(async (id) => ({ id, code: "K7M-4QX", scans: [] }) as unknown as Patient);
  const made = page({ planOnFit, moveScan, patient, importExample: async (name: string) => scanInfo(name), fit: async (id: string) => ({ id, links: fitLinks(id), drawing: null, state: "done" }) as unknown as Fit });
  const { store, actions } = made;
  await actions.scan.takeExample("standing");
  store.set((state) => ({ fit: done("f1"), drawn: { ...state.drawn, lines: { past: [], present: [LINE], future: [] } } }));
  await actions.drawing.saveNow();
  await actions.stances.takeExample("supine");
  return { ...made, planOnFit, moveScan, patient };
}

test("the second scan gets the page, the first waits with all that is its own", async () => {
  const { store } = await two();
  const state = store.get();
  expect(state.scan!.info.id).toBe("supine");
  expect(state.fit).toBeNull();
  expect(state.drawn.lines.present).toEqual([]);
  expect(state.stances.other!.scan!.info.id).toBe("standing");
  expect(state.stances.other!.fit!.id).toBe("f1");
  expect(state.stances).toMatchObject({ isSecond: true, isAdding: false });
  expect(stanceNames(state)).toEqual(["standing 2", "standing 1"]);
});

test("changing over and back is where one was", async () => {
  const { store, actions } = await two();
  const before = workspaceOf(store.get());
  await actions.stances.swap();
  expect(store.get().scan!.info.id).toBe("standing");
  expect(store.get().drawn.lines.present).toEqual([LINE]);
  expect(store.get().stances.isSecond).toBe(false);
  await actions.stances.swap();
  expect(workspaceOf(store.get())).toEqual(before);
});

test("from the address the stance that waits comes back with its lines, its note and the depth of its tumour", async () => {
  const items = [
    { kind: "line", id: "a", scan: "supine", name: "Line 1", points: [[0, 0, 0], [9, 0, 0]] },
    { kind: "tumour", id: "t", scan: "supine", side: "L", clock: 3, distance_mm: 30, radius_mm: 10, depth_mm: 25 },
    { kind: "note", id: "n", scan: "supine", text: "smaller" },
  ];
  const { store, actions } = page({ plan: async () => ({ version: 1, whole: true, scans: [], items }) as never });
  await actions.scan.open("standing", null);
  await actions.stances.restore("supine", null, null, { isSecond: false, isComparing: false });
  const { drawn, drawing } = store.get().stances.other!;
  expect(drawn.lines.present.map(({ id }) => id)).toEqual(["a"]);
  expect(drawn).toMatchObject({ note: "smaller", depthMm: 25 });
  expect(drawing).toBe("tumour:side=L,clock=3,distance_mm=30,radius_mm=10");
  expect(store.get().overlay).toBe("scan");
});

test("side by side from the address shows the skin of both, as when it is chosen", async () => {
  const { store, actions } = page();
  await actions.scan.open("standing", null);
  await actions.stances.restore("supine", null, null, { isSecond: true, isComparing: true });
  expect(store.get()).toMatchObject({ overlay: "scan", stances: { isComparing: true, isSecond: true } });
});

test("a scan that cannot be had leaves the page as it was and says why", async () => {
  const { store, actions } = page({ importExample: async (name: string) => { if (name === "gone") throw new Error("no"); return scanInfo(name); } });
  await actions.scan.takeExample("standing");
  actions.stances.dialog(true);
  await actions.stances.takeExample("gone");
  expect(store.get().scan!.info.id).toBe("standing");
  expect(store.get().stances).toMatchObject({ other: null, isBringing: false, isAdding: true });
  expect(store.get().problems.stances).toContain("no");
});

test("both scans are of one patient, and what was planned on the first is not made anew on the second", async () => {
  const { store, moveScan, patient } = await two();
  expect(moveScan).toHaveBeenCalledWith("supine", "of-standing");
  expect(new Set(patient.mock.calls.map(([id]) => id)), "its own patient is gone by then").toEqual(new Set(["of-standing"]));
  expect(store.get().scan!.info).toMatchObject({ id: "supine", patient: "of-standing", patient_code: "code of standing", links: { plan: "/api/patients/of-standing/plan" } });
  expect(store.get().drawing).toBe("");
  expect(store.get().stances.other!.drawing).toBe("");
});

test("the whole plan is laid on the other scan when both fits are done, and follows what is drawn afterwards", async () => {
  const { store, planOnFit, actions } = await two();
  await vi.advanceTimersByTimeAsync(2000);
  expect(planOnFit).not.toHaveBeenCalled();
  store.set({ fit: done("f2") });
  await vi.advanceTimersByTimeAsync(2000);
  expect(planOnFit.mock.calls).toEqual([["/api/fits/f2/plan.json"], ["/api/fits/f1/plan.json"]]); // whether both are of one patient
  expect(store.get().drawn.onScan!.carried.shapes.map(({ name }) => name)).toEqual(["Line 1", "tumour_L"]);
  expect(store.get().stances.other!.drawn.onScan).toBeNull(); // its own drawing came with its fit
  store.set((state) => ({ drawn: { ...state.drawn, lines: { past: [], present: [{ ...LINE, name: "Line 9" }], future: [] } } }));
  await actions.drawing.saveNow();
  await vi.advanceTimersByTimeAsync(2000);
  expect(planOnFit.mock.calls.slice(2).map(([link]) => link)).toEqual(["/api/fits/f2/plan.json", "/api/fits/f1/plan.json"]);
  expect(store.get().stances.other!.drawn.onScan!.from).toBe("standing 2");
  await vi.advanceTimersByTimeAsync(5000);
  expect(planOnFit).toHaveBeenCalledTimes(4);
});

test("a fit that runs while its scan waits comes to its end there", async () => {
  let state = "running";
  const result = { landmarks: {}, scan: { unit: "m" } };
  const { store, actions } = page({
    importExample: async (name: string) => scanInfo(name),
    fit: async (id: string) => ({ id, links: fitLinks(id), drawing: null, state }) as unknown as Fit,
    allEvents: async () => [{ id: 1, event: { kind: "iterated", iteration: 0 } }] as never,
    result: async () => result as never,
  });
  await actions.scan.takeExample("standing");
  store.set({ fit: { ...done("f1"), state: "running", surface: null } });
  await actions.stances.takeExample("supine");
  const fit = () => store.get().stances.other!.fit!;
  await vi.advanceTimersByTimeAsync(2500);
  expect(fit().state).toBe("running");
  state = "done";
  await vi.advanceTimersByTimeAsync(1500);
  await vi.waitFor(() => expect(fit()).toMatchObject({ state: "done", result, shown: 0 })); // the reader of surfaces comes in its own time
  expect(fit().surface).not.toBeNull();
});

test("a fit that is deleted elsewhere while its scan waits is said once, and not asked after any more", async () => {
  const fit = vi.fn().mockRejectedValue(new ApiError("There is no such fit.", 404));
  const { store, actions } = page({ importExample: async (name: string) => scanInfo(name), fit });
  await actions.scan.takeExample("standing");
  store.set({ fit: { ...done("f1"), state: "running", surface: null } });
  await actions.stances.takeExample("supine");
  await vi.advanceTimersByTimeAsync(1500);
  expect(store.get()).toMatchObject({ problems: { stances: "There is no such fit." }, stances: { other: { fit: null } } });
  await vi.advanceTimersByTimeAsync(5000);
  expect(fit).toHaveBeenCalledTimes(1);
});

test("a tap on the strip shows a scan, a second one another beside it; one that waits is worked on, the one in work is put away", async () => {
  const scans = (["prone", "supine", "standing"] as const).map((stance) => ({ id: stance, stance, created_at: "2026-11-25T09:00:00Z", thumbnail: "", fit: null }));
  const { store, actions } = page({ patient: async (id: string) => ({ id, code: "K7M-4QX", scans }) as unknown as Patient });
  const shown = () => Object.fromEntries(thumbsOf(store.get()).map(({ id, pane }) => [id, pane]));
  const tap = async (id: string): Promise<void> => {
    await actions.stances.tap(id);
    await vi.advanceTimersByTimeAsync(0);
  };
  await actions.scan.open("standing", null);
  await vi.advanceTimersByTimeAsync(0);
  expect(shown()).toEqual({ standing: 1, supine: null, prone: null });
  await tap("standing");
  expect(shown(), "one is always seen").toEqual({ standing: 1, supine: null, prone: null });
  await tap("supine");
  expect(shown()).toEqual({ standing: 1, supine: 2, prone: null });
  await tap("prone");
  expect(shown(), "the one that is not in work gives way").toEqual({ standing: 1, supine: null, prone: 2 });
  await tap("prone");
  expect(store.get().scan!.info.id, "in work, where it stands").toBe("prone");
  expect(shown()).toEqual({ standing: 1, supine: null, prone: 2 });
  await actions.stances.work();
  expect(store.get().scan!.info.id, "a tap on its pane does the same").toBe("standing");
  await tap("standing");
  expect(shown(), "put away, the other one is in work").toEqual({ standing: null, supine: null, prone: 1 });
  expect(store.get().scan!.info.id).toBe("prone");
});

test("days of the strip: the newest first, in each the same order", () => {
  const thumb = (id: string, at: string) => ({ id, at, stance: "standing" as const, isImage: false, isPredicted: false, picture: "", pane: null, fit: null, day: null, visit: "" });
  const days = daysOf([thumb("a", "2026-03-12T09:00:00Z"), thumb("b", "2026-11-27T09:00:00Z"), thumb("c", "2026-03-12T10:00:00Z")]);
  expect(days.map(([, thumbs]) => thumbs.map(({ id }) => id))).toEqual([["b"], ["a", "c"]]);
});

test("what was planned on a fitted scan that is not on the page is laid on the one that is", async () => {
  const items = [{ kind: "lesion", id: "a", scan: "prone", name: "L1", center: [0, 0, 0], radius_mm: 5 }];
  const scans = [{ id: "standing", stance: "standing", fit: null }, { id: "prone", stance: "prone", fit: { id: "f9", state: "done" } }];
  const planOnFit = vi.fn<Client["planOnFit"]>(async () => CARRIED);
  const { store, actions } = page({ planOnFit, plan: async () => ({ version: 1, whole: true, scans: [], items }) as never, patient: async (id: string) => ({ id, scans }) as unknown as Patient });
  await actions.scan.open("standing", null);
  store.set({ fit: done("f1") });
  await vi.advanceTimersByTimeAsync(2000);
  expect(planOnFit).toHaveBeenCalledTimes(1);
  expect(store.get().drawn.onScan).toMatchObject({ from: "", carried: { shapes: [{ name: "Line 1" }, { name: "tumour_L" }] } });
});

test("only the patient's own scans are offered, and others by their code, typed whole", async () => {
  const scan = (id: string) => ({ id, stance: "supine", created_at: "2026-11-25T09:00:00Z" });
  const people = [
    { id: "of-s1", code: "K7M-4QX", scans: [scan("s1"), scan("s2")] },
    { id: "p2", code: "Ward 7", scans: [scan("s3")] },
    { id: "p3", code: "Ward 77", scans: [scan("s4")] },
  ] as unknown as Patient[];
  const patients = vi.fn<Client["patients"]>(async (_address, search) => ({ patients: people.filter(({ code }) => code.toLowerCase().includes(search.toLowerCase())), next: null }));
  const { store, actions } = page({ patient: async (id: string) => people.find((each) => each.id === id)!, patients });
  await actions.scan.open("s1", null);
  actions.stances.dialog(true);
  await vi.advanceTimersByTimeAsync(0);
  expect(store.get().stances.scans.map(({ id }) => id)).toEqual(["s1", "s2"]);
  await actions.stances.name(" ward 7 ");
  expect(store.get().stances.named?.scans.map(({ id }) => id)).toEqual(["s3"]);
  await actions.stances.name("war");
  expect(store.get().stances.named).toBeNull();
  expect(store.get().problems.stances).toContain("“war”");
  await actions.stances.name("K7M-4QX");
  expect(store.get().stances.named, "it is the same patient").toBeNull();
});

test("one click fits both scans, each asked for once, with what belongs to it", async () => {
  const startFit = vi.fn(async ({ scan }: { scan: string }) => Promise.resolve({ id: `fit-of-${scan}`, links: fitLinks(`fit-of-${scan}`) }));
  const fit = async (id: string): Promise<Fit> => Promise.resolve({ id, links: fitLinks(id), state: "running", drawing: null } as unknown as Fit);
  const { store, actions } = page({ startFit, fit, allEvents: async () => Promise.resolve([]) });
  await actions.scan.open("s1", null);
  await actions.stances.fitBoth(); // alone there is nothing to do
  expect(startFit).not.toHaveBeenCalled();
  await actions.stances.takeKnown("s2");
  await actions.stances.fitBoth();
  expect(startFit.mock.calls.map(([request]) => request.scan)).toEqual(["s1", "s2"]);
  expect(store.get().stances.other?.fit).toMatchObject({ id: "fit-of-s1", state: "running" });
  expect(store.get().fit).toMatchObject({ id: "fit-of-s2", state: "running" });
  await actions.stances.fitBoth();
  expect(startFit).toHaveBeenCalledTimes(2);
});

test("who cannot say whether both scans are one patient's goes on with nothing carried, is not asked at each change, and answers later", async () => {
  const { store, planOnFit, moveScan, actions } = await two();
  moveScan.mockClear();
  const other = (link: string): string => (link.includes("f2") ? "standing" : "supine");
  planOnFit.mockImplementation(async (link) => ({ ...CARRIED, shapes: [], asked: moveScan.mock.calls.length > 0 ? [] : [{ scan: other(link), says: "The bodies differ." }] }));
  store.set({ fit: done("f2") });
  await vi.advanceTimersByTimeAsync(2000);
  expect(store.get().stances.asked).toHaveLength(2); // once from each scan
  expect(openDoubt(store.get())).toBe("patient");
  actions.stances.leaveUnanswered();
  store.set((state) => ({ drawn: { ...state.drawn, lines: { past: [], present: [{ ...LINE, name: "Line 9" }], future: [] } } }));
  await actions.drawing.saveNow();
  await vi.advanceTimersByTimeAsync(2000);
  expect(planOnFit.mock.calls.length, "the plan was laid again").toBeGreaterThan(2);
  expect([openDoubt(store.get()), store.get().stances.unanswered.length, moveScan.mock.calls.length]).toEqual([null, 2, 0]);
  expect(store.get().announcement).toMatch(/^Nothing is carried/);
  actions.stances.askAgain();
  expect(openDoubt(store.get())).toBe("patient");
  await actions.stances.samePatient(true);
  await vi.advanceTimersByTimeAsync(2000);
  expect(store.get().stances).toMatchObject({ asked: [], unanswered: [] });
  expect(moveScan).toHaveBeenCalledOnce();
});
