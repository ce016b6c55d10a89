import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { page, scanInfo, withScan } from "../fakes";
import * as text from "../../src/scan/text";
import { ApiError } from "../../src/api/client";
import type { Meta, Scan } from "../../src/api/types";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const file = (name = "scan.ply"): File => new File(["ply"], name);

test("an upload brings the scan, and its progress is shown on the way", async () => {
  const phases: (string | undefined)[] = [];
  const { store, actions } = page({
    upload: async (_file, _units, _model, progress) => {
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
    upload: async (_file, _units, model = "") => ({ ...scanInfo("s2"), model }),
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
  for (const name of names) await actions.scan.drop([file(name)]);
  expect(sent).toEqual([...names, ...names]);
});

test("of several files let go the only scan is read, and it is said; where none or more might be it, none is", async () => {
  const sent: string[] = [];
  const { store, actions } = page({ upload: async ({ name }) => (sent.push(name), scanInfo("s2")) });
  await actions.scan.drop([file("skin.jpg"), file("body.OBJ"), file("body.mtl")]);
  expect(sent).toEqual(["body.OBJ"]);
  expect(store.get().problems.scan).toBe(text.errors.oneOf(3));
  await actions.scan.drop([file("a.nii.gz"), file("b.nii.gz")]);
  await actions.scan.drop([file("IM000001"), file("IM000002")]);
  expect(sent).toEqual(["body.OBJ"]);
  expect(store.get().problems.scan).toBe(text.errors.several(2));
});

test("a folder let go is no silent service", async () => {
  const upload = vi.fn();
  const { store, actions } = page({ upload });
  const folder = { name: "DICOM", slice: () => ({ arrayBuffer: () => Promise.reject(new Error("NotFoundError")) }) } as unknown as File;
  await actions.scan.drop([folder]);
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
