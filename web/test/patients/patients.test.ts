// The list of patients: read, searched, renamed, ordered; a deletion waits ten seconds and can be taken back.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { page } from "../fakes";
import type { Patient } from "../../src/api/types";
import { addressOfPatient, fromHash } from "../../src/app/address";
import { daysUntil, deletedAt, sureness } from "../../src/patients/state";

const scan = (id: string, part: Partial<Patient["scans"][number]> = {}): Patient["scans"][number] => ({ id, stance: "standing", created_at: "2026-01-01T00:00:00Z", delete_at: null, kind: "surface", thumbnail: "", fit: null, ...part });
const patient = (id: string, part: Partial<Patient> = {}): Patient => ({ id, code: id, group: null, created_at: "2026-01-01T00:00:00Z", plan_version: 0, planned: { patterns: [], lines: 0, lesions: 0 }, scans: [scan(`${id}1`)], links: { self: "", plan: "" }, ...part });

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

function list(rows: readonly Patient[]) {
  const patients = vi.fn(async (...[address, search]: [string | null, string, string]) => ({ patients: address === null ? rows.filter(({ code }) => code.includes(search)) : [patient("later")], next: address === null ? "/api/patients?before=3" : null }));
  const deletePatient = vi.fn(async () => undefined);
  const renamePatient = vi.fn(async (id: string, code: string) => patient(id, { code }));
  const made = page({ patients, deletePatient, renamePatient });
  return { ...made, patients, deletePatient, renamePatient, ids: () => made.store.get().patients.rows.map(({ id }) => id) };
}

test("pages follow each other, and a search begins anew", async () => {
  const { actions, patients, ids } = list([patient("a"), patient("b")]);
  await actions.patients.read();
  await actions.patients.more();
  expect(ids()).toEqual(["a", "b", "later"]);
  actions.patients.search("x");
  actions.patients.search("b");
  await vi.advanceTimersByTimeAsync(300);
  expect(ids()).toEqual(["b"]);
  expect(patients).toHaveBeenCalledTimes(3);
});

test("a deletion is sent ten seconds later, once, and not when it was taken back", async () => {
  const { actions, store, deletePatient, ids } = list([patient("a"), patient("b")]);
  await actions.patients.read();
  actions.patients.remove("a");
  actions.patients.remove("b");
  await vi.advanceTimersByTimeAsync(5000);
  actions.patients.undo("a");
  expect(deletePatient).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(6000);
  expect(deletePatient.mock.calls).toEqual([["b"]]);
  expect(ids()).toEqual(["a"]);
  expect(store.get().patients.going).toEqual([]);
});

test("a code is the service's answer", async () => {
  const { actions, store, renamePatient } = list([patient("a")]);
  await actions.patients.read();
  await actions.patients.rename("a", "Ward 7");
  expect(renamePatient).toHaveBeenCalledWith("a", "Ward 7");
  expect(store.get().patients.rows[0]!.code).toBe("Ward 7");
});

test("the order is the service's, for there may be more patients than were read", async () => {
  const { actions, patients, ids } = list([patient("b"), patient("a")]);
  await actions.patients.read();
  await actions.patients.order("code");
  expect(patients.mock.calls.map((call) => call[2])).toEqual(["newest", "code"]);
  expect(ids()).toEqual(["b", "a"]);
});

test("a patient goes with the first of her scans", () => {
  const both = patient("p9", { scans: [scan("x", { delete_at: "2026-02-03T00:00:00Z" }), scan("y", { delete_at: "2026-02-01T00:00:00Z" })] });
  expect(deletedAt(both)).toBe("2026-02-01T00:00:00Z");
  expect(daysUntil("2026-02-01T00:00:00Z", new Date("2026-01-30T12:00:00Z"))).toBe(1);
  expect(daysUntil("2026-01-01T00:00:00Z", new Date("2026-01-30T12:00:00Z"))).toBe(0);
});

test("a patient's address opens both of her scans with the fits that are done", () => {
  const both = patient("a", { scans: [scan("s1", { fit: { id: "f1", state: "done", created_at: "", verdict: "good", line_error_mm: 8 } }), scan("s2", { fit: { id: "f2", state: "failed", created_at: "", verdict: null, line_error_mm: null } })] });
  expect(fromHash(addressOfPatient(both))).toMatchObject({ scan: "s1", fit: "f1", step: "body", other: { scan: "s2", fit: null }, isSecond: false });
  expect(fromHash(addressOfPatient(patient("b")))).toMatchObject({ scan: "b1", fit: null, other: null });
});

test("how many points are worth checking is asked of the fits that are to be checked, and said on the card", async () => {
  const fit = (id: string, verdict: "good" | "check", mm: number) => ({ id, state: "done" as const, created_at: "", verdict, line_error_mm: mm });
  const rows = [patient("a", { scans: [scan("a1", { fit: fit("sure", "good", 8) }), scan("a2", { stance: "supine", fit: fit("wide", "check", 24) })] }), patient("b", { scans: [scan("b1", { fit: fit("lost", "check", 15) })] })];
  const checksOf = vi.fn(async (id: string) => {
    if (id === "lost") throw new Error("no answer");
    return { worth_it: true, checks: [{}, {}] } as never;
  });
  const { store, actions } = page({ patients: async () => ({ patients: rows, next: null }), checksOf });
  await actions.patients.read();
  await vi.advanceTimersByTimeAsync(0);
  expect(checksOf.mock.calls).toEqual([["wide"], ["lost"]]);
  const { points } = store.get().patients;
  expect(rows.map((row) => sureness(row, points).says)).toEqual(["2 points to check on supine", "standing to be looked at"]);
});

test("once a patient is on the page, no fit of the list is asked about any more", async () => {
  const fit = (id: string) => patient(id, { scans: [scan(`${id}1`, { fit: { id, state: "done" as const, created_at: "", verdict: "check" as const, line_error_mm: 24 } })] });
  const checksOf = vi.fn(async (id: string) => {
    store.set({ scan: { info: { id } } as never });
    return { worth_it: true, checks: [] } as never;
  });
  const { store, actions } = page({ patients: async () => ({ patients: [fit("first"), fit("second")], next: null }), checksOf });
  await actions.patients.read();
  await vi.advanceTimersByTimeAsync(100);
  expect(checksOf.mock.calls).toEqual([["first"]]);
});
