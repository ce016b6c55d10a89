import { expect, test, vi } from "vitest";
import type { Client } from "../../src/api/client";
import { ApiError } from "../../src/api/client";
import type { Scan, Vector } from "../../src/api/types";
import { sizeActions } from "../../src/landmarks/size/actions";
import type { Picks } from "../../src/landmarks/picks";
import { endsOf, initialRuler, inScan, isRuler, isSizeLast, isSizeNext, rulerKey, sentEnd, withEnd } from "../../src/landmarks/size/ruler";
import { initialSession, type Session } from "../../src/app/session";
import { createStore } from "../../src/store/store";
import { scanInfo, withScan } from "../fakes";

const picks: Picks = { nipple_L: [10, 0, 0], "mark:dot": [10, 30, 40] };

test("two clicks are its ends, in their order; either may be a landmark or mark instead", () => {
  const first = withEnd(initialRuler, rulerKey("from"), [0, 0, 0]);
  expect(first).toEqual({ ruler: { from: [0, 0, 0], to: null }, active: rulerKey("to") });
  expect(withEnd(first, rulerKey("to"), [3, 4, 0])).toEqual({ ruler: { from: [0, 0, 0], to: [3, 4, 0] }, active: null });
  expect(withEnd({ ruler: { from: null, to: "nipple_L" } }, rulerKey("from"), [0, 0, 0]).active).toBeNull();
  expect([isRuler(rulerKey("from")), isRuler("nipple_L")]).toEqual([true, false]);
});

test("its length in the scan follows the landmarks, and is unknown while an end is", () => {
  expect(inScan({ from: "nipple_L", to: "mark:dot" }, picks)).toBe(50);
  expect(inScan({ from: "nipple_L", to: [10, 0, 7] }, picks)).toBe(7);
  expect(inScan({ from: "nipple_L", to: "nipple_R" }, picks)).toBeNull();
  expect(inScan({ from: "nipple_L", to: null }, picks)).toBeNull();
  expect([sentEnd("mark:dot"), sentEnd("nipple_L"), sentEnd([1, 2, 3])]).toEqual(["dot", "nipple_L", [1, 2, 3]]);
});

test("what waits is saved before, and the scan is read again and fitted after; a refusal changes nothing and is said", async () => {
  const info = { id: "s" } as Scan;
  const done: string[] = [];
  const store = createStore<Session>({ ...initialSession, scan: { info } as Session["scan"], ruler: { from: "nipple_L", to: [1, 2, 3] } });
  const putLength = vi.fn(() => (done.push("put"), Promise.resolve(info)));
  const client = { putLength, scan: () => Promise.resolve(info), deleteLength: () => Promise.reject(new ApiError("A fit of this scan waits or runs.", 409)) } as unknown as Client;
  const actions = sizeActions(store, client, {
    flush: () => Promise.resolve(done.push("flush")),
    cancel: () => Promise.resolve(),
    reopen: () => Promise.resolve(done.push("reopen") > 0),
    begin: () => void done.push("begin"),
  });
  await actions.apply(214);
  expect(done).toEqual(["flush", "put", "reopen", "begin"]);
  expect(putLength).toHaveBeenCalledWith(info, { from: "nipple_L", to: [1, 2, 3], length_mm: 214 });
  await actions.remove();
  expect(done.slice(4)).toEqual(["flush"]);
  expect(store.get().problems.size).toBe("A fit of this scan waits or runs.");
  await actions.look();
  expect(done.slice(5), "it has the size that is shown").toEqual([]);
  Object.assign(client, { scan: () => Promise.resolve({ ...info, scale: { factor: 1.03 } }) });
  await actions.look();
  expect(done.slice(5)).toEqual(["reopen"]);
  expect(store.get().problems.size).toContain("another size elsewhere");
  actions.measure();
  expect(store.get()).toMatchObject({ active: rulerKey("from"), ruler: { from: null, to: null } });
  actions.measure();
  expect(store.get().active).toBeNull();
});

test("sizes are gone back to and forth, by name where the ends still stand there, after what was placed since", async () => {
  let scale: Scan["scale"];
  const info = async (id: string): Promise<Scan> => ({ ...scanInfo(id), ...(scale ? { scale } : {}) });
  const client = {
    scan: info,
    landmarks: async () => ({ schema: "breastrig/landmarks@1" as const, unit: "mm" as const, landmarks: { nipple_L: [100 * (scale?.factor ?? 1), 0, 0] as Vector }, marks: {}, ...(scale ? { scale: scale.factor } : {}) }),
    putLength: vi.fn(async ({ id }: Scan, { length_mm: mm }: Parameters<Client["putLength"]>[1]) => {
      const factor = mm / 100;
      scale = { factor, between: ["nipple_L", "another"], mm, measured_mm: 100, ends: [[100 * factor, 0, 0], [0, 0, 0]] };
      return info(id);
    }),
    deleteLength: vi.fn(async ({ id }: Scan) => ((scale = undefined), info(id))),
  };
  const { actions, store } = await withScan(client);
  const factor = (): number => store.get().scan!.info.scale?.factor ?? 1;
  store.set({ ruler: { from: "nipple_L", to: [0, 0, 0] } });
  await actions.size.apply(110);
  await actions.size.remove();
  expect(factor()).toBe(1);
  actions.landmarks.move("nipple_L", [7, 0, 0]);
  actions.body.undo();
  expect([factor(), store.get().picks.present.nipple_L], "first what was done last").toEqual([1, [100, 0, 0]]);
  actions.landmarks.restore({ nipple_L: [100, 0, 0] });
  await actions.landmarks.flush();
  await actions.scan.open("s1", null);
  await actions.size.undo();
  expect(client.putLength).toHaveBeenLastCalledWith(expect.anything(), { from: "nipple_L", to: [0, 0, 0], length_mm: 110 });
  expect([factor(), store.get().undone?.says]).toEqual([1.1, "Undone: the scan is scaled by 1.100."]);
  await actions.size.undo();
  expect([factor(), isSizeLast(store.get()), isSizeNext(store.get())]).toEqual([1, false, true]);
  await actions.size.redo();
  expect([factor(), store.get().undone?.says]).toEqual([1.1, "Redone: the scan is scaled by 1.100."]);
  const ends = endsOf(store.get().scan!.info.scale!, null, { nipple_L: [5, 0, 0] });
  expect(ends.map((end) => (end as Vector).map(Math.round)), "where it has gone elsewhere").toEqual([[100, 0, 0], [0, 0, 0]]);
});
