import { expect, test, vi } from "vitest";
import { ApiError, type Client } from "../../src/api/client";
import type { Fit } from "../../src/api/types";
import { nextStep } from "../../src/app/nextStep";
import type { FitState } from "../../src/fit/state";
import { isPredicted, otherState, stanceNames, unscanned } from "../../src/stances/state";
import { FakeEventSource, fitLinks, page } from "../fakes";

const done = (id: string): FitState => ({
  id, links: fitLinks(id), state: "done", started: null, iterations: [], shown: -1, playing: false, result: null, drawing: null, drawingName: null,
  surface: null, distances: null, reason: null, isConnected: true, picks: null, certain: [], before: null,
});

/** A scan with its fit f1; a prediction of it is called after fit and stance, and says by itself what it is. */
async function fitted(more: Partial<Client> = {}) {
  const predict = vi.fn<Client["predict"]>(async (link, { stance }) => {
    const id = `${link.split("/")[3]}-${stance}`;
    return { id, links: fitLinks(id) };
  });
  const fit = async (id: string): Promise<Fit> => ({ id, links: fitLinks(id), drawing: null, state: "done", predicted_from: id.split("-")[0] }) as unknown as Fit;
  const result = async (link: string) => ({ stance: link.includes("prone") ? "prone" : "supine", predicted: true, landmarks: {}, scan: { unit: "m" }, verdict: { level: "check", reasons: [] } }) as never;
  const made = page({ predict, fit, result, allEvents: async () => [], ...more });
  await made.actions.scan.open("standing", null);
  made.store.set({ fit: done("f1") });
  return { ...made, predict };
}

test("a predicted body stands beside the scan, is called so, and nobody works on it", async () => {
  const { store, actions, client } = await fitted();
  expect(unscanned(store.get())).toEqual(["supine", "prone"]);
  await actions.stances.predict("supine");
  expect(store.get().stances.predicting).toBe("supine");
  FakeEventSource.last!.say("done", {});
  await vi.waitFor(() => expect(store.get().stances.other).not.toBeNull());
  const state = store.get();
  expect(state.stances).toMatchObject({ predicting: null, isAdding: false, isSecond: false, isComparing: true });
  expect(isPredicted(state.stances.other!)).toBe(true);
  expect(state.stances.other).toMatchObject({ scan: { info: { id: "standing" }, mesh: null }, fit: { id: "f1-supine", distances: null } });
  expect(stanceNames(state)).toEqual(["standing", "supine, predicted"]);
  expect(otherState(state)!.overlay, "no scan is to be seen").toBe("model");
  expect(unscanned(state)).toEqual(["supine", "prone"]);
  await actions.stances.swap();
  expect(store.get().fit!.id).toBe("f1");
  await vi.waitFor(() => expect(store.get().stances.other!.drawn.onScan?.plan.fit).toBe(fitLinks("f1-supine").plan));
  expect(nextStep({ ...store.get(), drawing: "reduction", step: "handover" }).kind).toBe("report");

  await actions.stances.restore("standing", "f1-prone", null, { isSecond: false, isComparing: true });
  expect(stanceNames(store.get()), "from the address").toEqual(["standing", "prone, predicted"]);
  expect(client.cancel).not.toHaveBeenCalled();
});

test("another fit of the scan is predicted anew", async () => {
  const { store, actions, predict } = await fitted();
  await actions.stances.predict("prone");
  FakeEventSource.last!.say("done", {});
  await vi.waitFor(() => expect(store.get().stances.other).not.toBeNull());
  store.set({ fit: done("f2") });
  await vi.waitFor(() => expect(predict).toHaveBeenLastCalledWith(fitLinks("f2").predictions, { stance: "prone" }));
  FakeEventSource.last!.say("done", {});
  await vi.waitFor(() => expect(store.get().stances.other!.fit!.id).toBe("f2-prone"));
});

test("what cannot be predicted is said where it was asked for", async () => {
  const { store, actions } = await fitted({ predict: async () => Promise.reject(new ApiError("What gravity does to toy is not known.", 422)) });
  await actions.stances.predict("supine");
  expect(store.get().problems.stances).toBe("What gravity does to toy is not known.");
  expect(store.get().stances).toMatchObject({ predicting: null, other: null });
  const { store: other, actions: asked } = await fitted();
  await asked.stances.predict("supine");
  FakeEventSource.last!.say("failed", { reason: "It broke." });
  expect(other.get().problems.stances).toBe("It broke.");
});
