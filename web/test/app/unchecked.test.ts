// What is said beside the printed pages before they are printed, and where each leads.
import { expect, test } from "vitest";
import { uncheckedOf } from "../../src/app/handover/unchecked";
import { initialSession, type Session } from "../../src/app/session";
import { startDrawn } from "../../src/drawing/state";
import { startHistory } from "../../src/store/history";

const picks = { notch: [0, 0, 0] } as const;
const scan = { file: null, info: { id: "s0", stance: { proposed: "standing" } }, frame: { up: [0, 1, 0], front: [0, 0, 1] } };
const fit = (more: object = {}) => ({ id: "f", state: "done", picks, certain: [], result: { stance: "standing", ...more } });
const session = (more: object): Session => ({ ...initialSession, step: "handover", scan, picks: startHistory(picks), fit: fit(), ...more }) as unknown as Session;
const said = (state: Session) => uncheckedOf(state).map(({ says, way, isOther }) => [says, way, isOther]);

test("a stance that is ready says so, and leads nowhere", () => {
  expect(said(session({}))).toEqual([["Standing: ready", null, false]]);
});

test("a fit that the report calls to be checked is not ready here, though no point is worth a check", () => {
  const state = session({ fit: fit({ verdict: { level: "check", reasons: ["Lines may be far off."] }, line_error_mm: 14 }) });
  expect(uncheckedOf(state)).toMatchObject([{ says: expect.stringMatching(/^Standing: lines are .*doubts and notes/) as string, way: null, isReady: false }]);
});

test("open questions, what cannot be drawn, and a lesion over which no skin is seen each have a way there", () => {
  const onScan = { plan: { lesions: [{ name: "MRI 1", seen: false }, { name: "MRI 2", seen: true }], missing: [{ item: "p", reason: "No room on the left: limbs of 80 mm reach the fold. Choose shorter limbs." }] } };
  const state = session({ fit: fit({ landmarks_unusual: [{ names: ["notch"], reason: "notch is unusual." }] }), drawn: { ...startDrawn(), onScan } });
  expect(said(state)).toEqual([
    ["Standing: 1 point not checked", "check", false],
    ["Standing: No room on the left: limbs of 80 mm reach the fold.", "plan", false],
    ["Standing: no skin is seen over MRI 1", "plan", false],
  ]);
});

test("the other stance is said too: not fitted, or predicted and not scanned", () => {
  const other = (more: object) => ({ ...initialSession.stances, other: { scan: { ...scan, info: { ...scan.info, id: "s1" } }, picks: startHistory({}), certain: {}, proposals: null, skipped: new Set(), saving: "saved", stance: "supine", drawing: "", drawn: startDrawn(), fit: null, ...more } });
  expect(said(session({ stances: other({}) }))[1]).toEqual(["Supine: the model is not fitted", "points", true]);
  expect(said(session({ stances: other({ fit: { ...fit(), predictedFrom: "f", result: { stance: "supine" } } }) }))[1]).toEqual([expect.stringMatching(/^Supine.*: predicted, not scanned$/), "scan", true]);
});
