import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { page, scanInfo, withScan } from "../fakes";
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

test("a file of another kind is not even sent", async () => {
  const upload = vi.fn();
  const { store, actions } = page({ upload });
  await actions.scan.upload(file("holiday.jpg"));
  expect(upload).not.toHaveBeenCalled();
  expect(store.get().problems.scan).toContain("holiday.jpg");
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
