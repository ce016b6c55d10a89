import { afterEach, expect, test, vi } from "vitest";
import { FakeEventSource, page } from "../fakes";
import { ApiError } from "../../src/api/client";
import type { DrawingFile, PlanOnScan } from "../../src/api/types";
import { listedLines } from "../../src/share/visitor/PlanList";
import { passSecretOn, takeSecret } from "../../src/share/visitor/secret";
import { closeLink, openLink, visitOf } from "../../src/share/visitor/visit";

afterEach(() => void vi.unstubAllGlobals());

async function fitted(...rest: Parameters<typeof page>) {
  const made = page(...rest);
  await made.actions.scan.open("s1", null);
  await made.actions.fit.start();
  FakeEventSource.last!.say("done", { result: { surface_distance_mm: { mean: 1 }, scan: { unit: "m" }, landmarks: {} } });
  return made;
}

test("a link is made as asked, its address is shown until the dialog closes, and the list follows", async () => {
  const makeShare = vi.fn(async () => ({ id: "a", url: "/s#secret" }));
  const shares = vi.fn().mockResolvedValueOnce({ shares: [] }).mockResolvedValue({ shares: [{ id: "a", revoked_at: null }] });
  const { store, actions } = await fitted({ makeShare, shares } as never);
  await actions.share.open();
  expect(store.get().share).toMatchObject({ isOpen: true, list: [] });
  await actions.share.make({ expires_in_days: 30, scan: "plain", passcode: "4711" });
  expect(makeShare).toHaveBeenCalledWith("/api/fits/f1/shares", { expires_in_days: 30, scan: "plain", passcode: "4711" });
  expect(store.get().share).toMatchObject({ made: { url: "/s#secret" }, list: [{ id: "a" }], isBusy: false });
  actions.share.close();
  expect(store.get().share.made).toBeNull();
});

test("a revoked link's address is not offered for copying any more; another one's still is", async () => {
  const makeShare = vi.fn(async () => ({ id: "a", url: "/s#secret" }));
  const revokeShare = vi.fn(async () => undefined);
  const list = (...revoked: string[]) => ({ shares: ["a", "b"].map((id) => ({ id, revoked_at: revoked.includes(id) ? "2026-01-01T00:00:00Z" : null })) });
  const shares = vi.fn().mockResolvedValueOnce(list()).mockResolvedValueOnce(list()).mockResolvedValueOnce(list("b")).mockResolvedValue(list("a", "b"));
  const { store, actions } = await fitted({ makeShare, revokeShare, shares } as never);
  await actions.share.open();
  await actions.share.make({});
  await actions.share.revoke("/api/fits/f1/shares/b");
  expect(store.get().share.made).toEqual({ id: "a", url: "/s#secret" });
  await actions.share.revoke("/api/fits/f1/shares/a");
  expect(store.get().share.made).toBeNull();
});

test("a refused link says why in the dialog, which can be used again", async () => {
  const makeShare = vi.fn().mockRejectedValueOnce(new ApiError("A passcode has at least 4 characters.", 422));
  const { store, actions } = await fitted({ makeShare, shares: async () => ({ shares: [] }) } as never);
  await actions.share.open();
  await actions.share.make({ passcode: "1" });
  expect(store.get()).toMatchObject({ problems: { share: "A passcode has at least 4 characters." }, share: { isBusy: false, made: null } });
});

test("showing the present state asks the service and reads the list again", async () => {
  const refreshShare = vi.fn(async () => ({}));
  const shares = vi.fn(async () => ({ shares: [] }));
  const { store, actions } = await fitted({ refreshShare, shares } as never);
  await actions.share.open();
  await actions.share.refresh("/api/fits/f1/shares/a/refresh");
  expect(refreshShare).toHaveBeenCalledWith("/api/fits/f1/shares/a/refresh");
  expect(shares).toHaveBeenCalledTimes(2);
  expect(store.get().announcement).toBe("The link shows the present state.");
});

test("unlocking asks the service and reads the list again", async () => {
  const unlockShare = vi.fn(async () => ({}));
  const shares = vi.fn(async () => ({ shares: [] }));
  const { store, actions } = await fitted({ unlockShare, shares } as never);
  await actions.share.open();
  await actions.share.unlock("/api/fits/f1/shares/a/unlock");
  expect(unlockShare).toHaveBeenCalledWith("/api/fits/f1/shares/a/unlock");
  expect(shares).toHaveBeenCalledTimes(2);
  expect(store.get().announcement).toBe("The link takes passcodes again.");
});

test("a secret in the address is passed on once, by a navigation to an address without it", () => {
  const replace = vi.fn();
  const tab = { name: "", location: { hash: "#s3cret", replace } };
  expect(passSecretOn(tab)).toBe(true);
  expect(replace).toHaveBeenCalledWith("/s");
  expect(takeSecret(tab)).toBe("s3cret");
  expect([tab.name, takeSecret(tab)]).toEqual(["", ""]);
  expect(passSecretOn({ name: "", location: { hash: "", replace } })).toBe(false);
  expect(replace).toHaveBeenCalledTimes(1);
  expect(takeSecret({ name: "somebody else's" })).toBe("");
});

test("a page asks for its own share only, and takes its address when it has opened a link", async () => {
  const asked: [string, RequestInit][] = [];
  vi.stubGlobal("fetch", async (path: string, request: RequestInit) => (asked.push([path, request]), new Response(JSON.stringify({ id: "A", links: { close: "/api/shared/A/close" } }))));
  const replaceState = vi.fn();
  const past = { replaceState } as unknown as History;
  await openLink(visitOf("", "/s/A"), "", past);
  expect(asked.map(([path]) => path)).toEqual(["/api/shared/A"]);
  expect(replaceState).not.toHaveBeenCalled();
  const shared = await openLink(visitOf("s3cret", "/s"), "4711 please", past);
  expect(asked[1]).toMatchObject(["/api/shared/open", { method: "POST", body: JSON.stringify({ token: "s3cret", passcode: "4711 please" }) }]);
  expect(replaceState).toHaveBeenCalledWith(null, "", "/s/A");
  await closeLink(shared);
  expect(asked[2]).toMatchObject(["/api/shared/A/close", { method: "POST" }]);
});

test("closing what has ended already is no error, everything else is", async () => {
  const shared = { links: { close: "/api/shared/A/close" } } as never;
  vi.stubGlobal("fetch", async () => new Response(JSON.stringify({ detail: "not open" }), { status: 401 }));
  await closeLink(shared);
  vi.stubGlobal("fetch", async () => new Response(JSON.stringify({ detail: "no disk" }), { status: 503 }));
  await expect(closeLink(shared)).rejects.toThrow("no disk");
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

test("a visitor reads of each line how sure its place is, whether it was carried, and how deep a tumour lies", () => {
  const shape = (name: string, more: object) => ({ name, closed: false, color: "#101010", points: [], bridged: [], ...more });
  const shapes = [shape("a", { error_mm: [2, null, 12], line_error_mm: 7.6, carried: true, depth_mm: 20 }), shape("b", { error_mm: [null], line_error_mm: null, carried: false, depth_mm: null }), shape("c", { error_mm: [4.2], line_error_mm: 3, carried: false })];
  const plan = { shapes: shapes.slice(0, 3) } as unknown as PlanOnScan;
  const drawing = { shapes: [...shapes, shape("from the fit", {})] } as unknown as DrawingFile;
  expect(listedLines(drawing, plan).map(({ name, about }) => [name, about])).toEqual([
    ["a", "carried from another scan, ±\u00a08\u00a0mm, 20\u00a0mm below the skin"],
    ["b", ""],
    ["c", "±\u00a03\u00a0mm"],
    ["from the fit", ""],
  ]);
  expect(listedLines(null, plan)).toEqual([]);
});
