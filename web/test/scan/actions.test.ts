import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { page, scanInfo, withScan } from "../fakes";
import * as text from "../../src/scan/text";
import { ApiError, type UploadFields } from "../../src/api/client";
import type { Meta, Question, Scan } from "../../src/api/types";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const file = (name = "scan.ply"): File => new File(["ply"], name);

test("an upload brings the scan, and its progress is shown on the way", async () => {
  const phases: (string | undefined)[] = [];
  const { store, actions } = page({
    upload: async (_file, _said, progress) => {
      progress(0.5);
      progress(1);
      return scanInfo("s2");
    },
  });
  store.subscribe((state) => phases.push(state.loading?.phase));
  await actions.scan.upload(file());
  expect(store.get().scan?.info.id).toBe("s2");
  expect(new Set(phases)).toEqual(new Set([undefined, "preparing", "sending"]));
  expect(store.get().loading).toBeNull();
});

test("a scan of another model brings what that model has; it is uploaded for the chosen one", async () => {
  const male = { landmarks: [], model: { name: "male" } } as unknown as Meta;
  const asked: (string | undefined)[] = [];
  const { store, actions } = page({
    meta: async (name) => {
      asked.push(name);
      return male;
    },
    upload: async (_file, { model = "" }) => ({ ...scanInfo("s2"), model }),
    scan: async (id) => ({ ...scanInfo(id), model: "male" }),
  });
  await actions.scan.open("s1", null);
  expect(store.get().meta).toBe(male);
  await actions.scan.upload(file());
  expect(store.get().scan?.info.model).toBe("male");
  await actions.scan.chooseModel("torso");
  expect(asked).toEqual(["male", "torso"]);
});

test("a refused upload says why and leaves the scan before it, with its landmarks, where it was", async () => {
  const { store, actions } = await withScan({
    upload: () => Promise.reject(new ApiError("The file holds no triangles.", 422)),
  });
  actions.landmarks.want("nipple_L");
  actions.landmarks.place([1, 2, 3]);
  await actions.scan.upload(file());
  expect(store.get().problems.scan).toBe("The file holds no triangles.");
  expect(store.get().scan?.info.id).toBe("s1");
  expect(store.get().picks.present).toEqual({ nipple_L: [1, 2, 3] });
});

test("files of any name are sent: the service decides from their bytes", async () => {
  const sent: string[] = [];
  const { actions } = page({ upload: async ({ name }) => (sent.push(name), scanInfo("s2")) });
  const names = ["mri.nii.gz", "mri.nii", "seg.dcm", "IM000001", "1.2.840.113619.2.5", "scan.ply"];
  for (const name of names) await actions.scan.upload(file(name));
  for (const name of names) await actions.bring.files([file(name)]);
  expect(sent).toEqual([...names, ...names]);
});

test("a folder let go is no silent service", async () => {
  const upload = vi.fn();
  const { store, actions } = page({ upload });
  const folder = { name: "DICOM", slice: () => ({ arrayBuffer: () => Promise.reject(new Error("NotFoundError")) }) } as unknown as File;
  await actions.bring.files([folder]);
  expect(upload).not.toHaveBeenCalled();
  expect(store.get().problems.scan).toBe(text.errors.unreadable);
});

test("the scan asked for last wins over a slower, earlier one", async () => {
  let slow: (scan: Scan) => void = () => undefined;
  const { store, actions } = page({ upload: () => new Promise((done) => (slow = done)) });
  const first = actions.scan.upload(file());
  await actions.scan.open("s9", null);
  slow(scanInfo("late"));
  await first;
  expect(store.get().scan?.info.id).toBe("s9");
});

const question = { problem: "This file does not say which side is left", field: "frame", choices: [{ value: "RAS", text: "left" }, { value: "LAS", text: "right" }] } as unknown as Question;

/** A service that asks before it takes the file. */
function asking() {
  const said: UploadFields[] = [];
  const upload = vi.fn(async (_file: File, fields: UploadFields) => {
    said.push(fields);
    if (fields.frame === undefined) throw new ApiError("say which it is", 422, question);
    return scanInfo(`s${said.length}`);
  });
  return { said, upload };
}

test("which side is left is asked; the answer goes with the same file, and nothing is taken for granted", async () => {
  const { said, upload } = asking();
  const { store, actions } = page({ upload });
  const mri = file("mri.nii.gz");
  const going = actions.scan.upload(mri);
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  expect([said.length, store.get().scan]).toEqual([1, null]);
  actions.scan.answer("LAS");
  expect(await going).toBe(true);
  expect(said.map(({ frame }) => frame)).toEqual([undefined, "LAS"]);
  expect(upload.mock.calls.map(([sent]) => sent)).toEqual([mri, mri]);
  expect([store.get().asked, store.get().scan?.info.id]).toEqual([null, "s2"]);
});

test("a question that is called off uploads nothing, and what was open stays", async () => {
  const { said, upload } = asking();
  const { store, actions } = await withScan({ upload });
  const going = actions.scan.upload(file("mri.nii.gz"));
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  actions.scan.answer(null);
  expect(await going).toBe(false);
  expect([said.length, store.get().scan?.info.id, store.get().loading, store.get().asked, store.get().problems]).toEqual([1, "s1", null, null, {}]);
});

test("another scan that is opened meanwhile calls the question off", async () => {
  const { said, upload } = asking();
  const { store, actions } = page({ upload });
  const going = actions.scan.upload(file("mri.nii.gz"));
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  await actions.scan.open("s9", null);
  expect(await going).toBe(false);
  expect([said.length, store.get().scan?.info.id, store.get().asked]).toEqual([1, "s9", null]);
});

test("segments taken otherwise: the file is read again with all that was said, for the same patient, and the first upload goes", async () => {
  const { said, upload } = asking();
  const { store, client, actions } = page({ upload });
  const going = actions.scan.upload(file("mri.nii.gz"), "mm");
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  actions.scan.answer("RAS");
  await going;
  await actions.scan.takeSegments({ 2: "lesion" });
  expect(said.at(-1)).toEqual({ units: "mm", model: "torso", patient: "of-s2", again: "true", frame: "RAS", segments: { 2: "lesion" } });
  expect(vi.mocked(client.deleteScan).mock.calls.map(([scan]) => scan.id)).toEqual(["s2"]);
  await actions.scan.takeSegments({ 3: "unused" });
  expect(said.at(-1)?.segments).toEqual({ 2: "lesion", 3: "unused" });
  expect(store.get().scan?.info.id).toBe("s4");
});

test("segments that cannot be taken so leave the first upload where it is", async () => {
  const upload = vi.fn().mockResolvedValueOnce(scanInfo("s2")).mockRejectedValueOnce(new ApiError("Segment 2 can be no lesion.", 422));
  const { store, client, actions } = page({ upload });
  await actions.scan.upload(file("mri.nii.gz"));
  await actions.scan.takeSegments({ 2: "lesion" });
  expect(client.deleteScan).not.toHaveBeenCalled();
  expect([store.get().scan?.info.id, store.get().problems.scan]).toEqual(["s2", "Segment 2 can be no lesion."]);
});

test("whose model is right is kept at the service; where it cannot be, the page says so and asks again", async () => {
  const { store, client, actions } = await withScan();
  await actions.scan.confirmModel();
  expect(store.get().scan!.info.model_said).toBe(true);
  expect(client.sayModel).toHaveBeenCalledWith(expect.objectContaining({ id: "s1", model: "torso" }));
  client.sayModel = async () => Promise.reject(new ApiError("The service cannot be reached.", 0));
  await actions.scan.confirmModel();
  expect(store.get()).toMatchObject({ scan: { info: { model_said: false } }, problems: { scan: "The service cannot be reached." } });
});
