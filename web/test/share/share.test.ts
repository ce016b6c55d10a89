import { afterEach, expect, test, vi } from "vitest";
import { FakeEventSource, page } from "../fakes";
import { ApiError } from "../../src/api/client";

afterEach(() => void vi.unstubAllGlobals());

async function fitted(...rest: Parameters<typeof page>) {
  const made = page(...rest);
  await made.actions.scan.open("s1", null);
  await made.actions.fit.start();
  FakeEventSource.last!.say("done", { result: { surface_distance_mm: { mean: 1 }, scan: { unit: "m" }, landmarks: {} } });
  return made;
}

test("a link is made as asked, its address is shown until the dialog closes, and the list follows", async () => {
  const makeShare = vi.fn(async () => ({ url: "/s#secret" }));
  const shares = vi.fn().mockResolvedValueOnce({ shares: [] }).mockResolvedValue({ shares: [{ id: "a" }] });
  const { store, actions } = await fitted({ makeShare, shares } as never);
  await actions.share.open();
  expect(store.get().share).toMatchObject({ isOpen: true, list: [] });
  await actions.share.make({ expires_in_days: 30, scan: "plain", passcode: "4711" });
  expect(makeShare).toHaveBeenCalledWith("/api/fits/f1/shares", { expires_in_days: 30, scan: "plain", passcode: "4711" });
  expect(store.get().share).toMatchObject({ made: "/s#secret", list: [{ id: "a" }], isBusy: false });
  actions.share.close();
  expect(store.get().share.made).toBeNull();
});

test("a refused link says why in the dialog, which can be used again", async () => {
  const makeShare = vi.fn().mockRejectedValueOnce(new ApiError("A passcode has at least 4 characters.", 422));
  const { store, actions } = await fitted({ makeShare, shares: async () => ({ shares: [] }) } as never);
  await actions.share.open();
  await actions.share.make({ passcode: "1" });
  expect(store.get()).toMatchObject({ problems: { share: "A passcode has at least 4 characters." }, share: { isBusy: false, made: null } });
});

test("revoking asks the service and reads the list again", async () => {
  const revokeShare = vi.fn(async () => undefined);
  const shares = vi.fn(async () => ({ shares: [] }));
  const { actions } = await fitted({ revokeShare, shares } as never);
  await actions.share.open();
  await actions.share.revoke("/api/fits/f1/shares/a");
  expect(revokeShare).toHaveBeenCalledWith("/api/fits/f1/shares/a");
  expect(shares).toHaveBeenCalledTimes(2);
});
