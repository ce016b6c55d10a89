// Another patient, the browser's Back, deleting: nothing goes without a word.
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { withScan } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { LandmarkFile, Patient } from "../../src/api/types";
import { lineAlong } from "../../src/drawing/lines/edits";
import { isRefused, unsavedOf } from "../../src/app/leaving";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const settle = (): Promise<unknown> => vi.advanceTimersByTimeAsync(0);

test("what still waits is saved before the patient is put away, and then nobody is asked", async () => {
  const { store, client, actions } = await withScan();
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  expect(unsavedOf(store.get())).toEqual(["landmarks"]);
  await actions.scan.leave();
  expect(client.saveLandmarks).toHaveBeenCalledWith(expect.objectContaining({ id: "s1" }), expect.objectContaining({ landmarks: { nipple_L: [1, 2, 3] } }), null);
  expect(store.get()).toMatchObject({ scan: null, leaving: null });
});

test("what the service would not take is asked about: staying keeps it, going on does not, saving again goes on when it worked", async () => {
  const saveLandmarks = vi.fn().mockRejectedValue(new ApiError("The disk is full.", 507));
  const { store, actions } = await withScan({ saveLandmarks });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  void actions.scan.leave();
  await settle();
  expect(store.get()).toMatchObject({ leaving: ["landmarks"], scan: { info: { id: "s1" } } });
  expect(isRefused(store.get()), "a closed tab would lose them: the browser asks").toBe(true);
  actions.leaving.stay();
  await settle();
  expect(store.get()).toMatchObject({ leaving: null, scan: { info: { id: "s1" } }, picks: { present: { nipple_L: [1, 2, 3] } } });

  void actions.scan.open("s2", null);
  await settle();
  expect(store.get().scan?.info.id).toBe("s1");
  await actions.leaving.saveAgain();
  expect(store.get().leaving).toEqual(["landmarks"]);
  saveLandmarks.mockImplementation(async (_scan: unknown, file: unknown) => file);
  await actions.leaving.saveAgain();
  await settle();
  expect(store.get()).toMatchObject({ leaving: null, scan: { info: { id: "s2" } } });

  saveLandmarks.mockRejectedValue(new ApiError("The disk is full.", 507));
  actions.landmarks.want("nipple_R");
  actions.landmarks.place([1, 2, 3]);
  void actions.scan.leave();
  await settle();
  actions.leaving.leaveAnyhow();
  await settle();
  expect(store.get().scan).toBeNull();
});

test("a scan is deleted ten seconds after the answer, and can be taken back until then", async () => {
  const { store, client, actions } = await withScan();
  actions.deletion.ask(true);
  expect(store.get().isAskingToDelete).toBe(true);
  await actions.deletion.confirm();
  expect(store.get()).toMatchObject({ scan: null, isAskingToDelete: false, deletion: { scan: { id: "s1" } } });
  await vi.advanceTimersByTimeAsync(9000);
  expect(client.deleteScan).not.toHaveBeenCalled();
  await actions.deletion.undo();
  expect(store.get()).toMatchObject({ scan: { info: { id: "s1" } }, deletion: null });
  await vi.advanceTimersByTimeAsync(20_000);
  expect(client.deleteScan).not.toHaveBeenCalled();

  await actions.deletion.confirm();
  await vi.advanceTimersByTimeAsync(10_001);
  expect(client.deleteScan).toHaveBeenCalledExactlyOnceWith(expect.objectContaining({ id: "s1" }));
  expect(store.get().deletion).toBeNull();
});

test("leaving the page deletes at once; opening the scan again by any way does not delete it", async () => {
  const { store, client, actions } = await withScan();
  await actions.deletion.confirm();
  await actions.scan.open("s1", null);
  expect(store.get()).toMatchObject({ scan: { info: { id: "s1" } }, deletion: null });
  await actions.deletion.confirm();
  await actions.deletion.send();
  expect(client.deleteScan).toHaveBeenCalledTimes(1);
});

test("a deleted scan cannot be chosen as a second stance any more, and can when it was taken back", async () => {
  const scans = ["s1", "s2"].map((id) => ({ id, stance: "standing", created_at: "2026-11-25T09:00:00Z" }));
  const { store, actions } = await withScan({ patient: async () => ({ id: "p", code: "K7M-4QX", scans }) as unknown as Patient });
  await actions.stances.takeKnown("s2");
  const hers = async (): Promise<readonly string[]> => {
    actions.stances.dialog(true);
    await settle();
    return store.get().stances.scans.map(({ id }) => id);
  };
  expect(await hers()).toEqual(["s1", "s2"]);
  await actions.deletion.confirm();
  expect(await hers()).toEqual(["s1"]);
  await actions.scan.leave();
  await actions.deletion.undo();
  expect(await hers()).toEqual(["s1", "s2"]);
});

test("the other stance stays when one is deleted", async () => {
  const { store, client, actions } = await withScan();
  await actions.stances.takeKnown("s2");
  expect(store.get()).toMatchObject({ scan: { info: { id: "s2" } }, stances: { other: { scan: { info: { id: "s1" } } } } });
  await actions.deletion.confirm();
  expect(store.get()).toMatchObject({ scan: { info: { id: "s1" } }, stances: { other: null }, deletion: { scan: { id: "s2" } } });
  await actions.deletion.undo();
  expect(store.get(), "taken back it stands beside the other again").toMatchObject({ scan: { info: { id: "s1" } }, stances: { other: { scan: { info: { id: "s2" } } }, isSecond: false } });
  await actions.stances.swap();
  store.set({ isStarting: true }); // a landmark was dragged, and its fit is on its way
  await actions.deletion.confirm();
  expect(store.get()).toMatchObject({ scan: { info: { id: "s1" } }, stances: { other: null }, deletion: { scan: { id: "s2" } }, isStarting: false });
  await vi.advanceTimersByTimeAsync(10_001);
  expect(client.deleteScan).toHaveBeenCalledExactlyOnceWith(expect.objectContaining({ id: "s2" }));
});

test("what is on its way when the other stance is taken is saved there, and nobody is asked about it later", async () => {
  let come: () => void = () => undefined;
  const saveLandmarks = vi.fn((_scan: unknown, file: LandmarkFile) => new Promise<LandmarkFile>((done) => (come = () => done(file))));
  const { store, client, actions } = await withScan({ saveLandmarks });
  const save = client.savePlan.bind(client);
  client.savePlan = async (...asked) => {
    await new Promise((later) => setTimeout(later, 3000));
    return save(...asked);
  };
  actions.drawing.restore([{ ...lineAlong("mine", "#101010", [[0, 0, 0], [9, 0, 0]], false), id: "mine-mine" }]);
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await vi.advanceTimersByTimeAsync(1000);
  expect(unsavedOf(store.get())).toEqual(["landmarks", "lines"]);
  const taken = actions.stances.takeKnown("s2");
  come();
  await vi.advanceTimersByTimeAsync(5000);
  await taken;
  expect(store.get().stances.other).toMatchObject({ scan: { info: { id: "s1" } }, saving: "saved", drawn: { saving: "saved" } });
  expect(unsavedOf(store.get())).toEqual([]);
});

test("a service that cannot delete says so", async () => {
  const deleteScan = vi.fn().mockRejectedValue(new ApiError("Some files are left.", 500));
  const { store, actions } = await withScan({ deleteScan });
  await actions.deletion.confirm();
  await actions.deletion.send();
  expect(store.get().problems.page).toBe("Some files are left.");
});
