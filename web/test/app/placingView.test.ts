import { afterEach, expect, test, vi } from "vitest";
import { withScan } from "../fakes";

afterEach(() => void vi.unstubAllGlobals());

test("a wanted landmark and a tool in the hand show the scan alone; what was shown before comes back with the last of them", async () => {
  const { store, actions } = await withScan();
  actions.view.overlay("model");
  actions.landmarks.want("nipple_L");
  expect(store.get().overlay).toBe("scan");
  actions.landmarks.want("nipple_R");
  actions.landmarks.want(null);
  expect(store.get().overlay).toBe("model");
  actions.drawing.take("pen");
  expect(store.get().overlay).toBe("scan");
  actions.drawing.take("points");
  expect(store.get().overlay).toBe("scan");
  actions.page.goTo("body");
  expect(store.get().overlay).toBe("model");
});

test("from the pen to a landmark it stays so, and the last landmark brings it back", async () => {
  const { store, actions } = await withScan();
  actions.view.overlay("both");
  actions.drawing.take("pen");
  actions.landmarks.want("umbilicus");
  expect(store.get()).toMatchObject({ overlay: "scan", drawn: { tool: "none" } });
  for (let i = 0; i < 4; i += 1) actions.landmarks.place([i, 0, 0]);
  expect(store.get()).toMatchObject({ active: null, overlay: "both", overlayBefore: null });
});

test("what a person chooses while placing holds, then and afterwards", async () => {
  const { store, actions } = await withScan();
  actions.view.overlay("model");
  actions.landmarks.want("nipple_L");
  actions.view.overlay("both");
  expect(store.get().overlay).toBe("both");
  actions.landmarks.want(null);
  expect(store.get().overlay).toBe("both");
});

test("the model is seen on the scan while it settles; at rest the scan is seen alone, unless the person chose otherwise", async () => {
  const { store } = await withScan();
  const fit = (playing: boolean): void => store.set({ fit: { id: "f", state: "running", iterations: [], playing } as never });
  fit(true);
  expect(store.get().overlay).toBe("both");
  fit(false);
  expect(store.get()).toMatchObject({ overlay: "scan", overlayBefore: null });
  store.set({ overlay: "model" });
  fit(true);
  expect(store.get().overlay).toBe("model");
  store.set({ overlay: "scan" });
  expect(store.get().overlay).toBe("scan");
  fit(false);
  expect(store.get().overlay).toBe("scan");
});
