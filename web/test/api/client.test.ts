import { afterEach, expect, test, vi } from "vitest";
import { client } from "../../src/api/client";
import { scanInfo } from "../fakes";

afterEach(() => void vi.unstubAllGlobals());

test("the meshes of the last two scans stay in memory, until something is deleted", async () => {
  const fetched = vi.fn(async (path: string) => new Response(path));
  vi.stubGlobal("fetch", fetched);
  const asked = (): string[] => fetched.mock.calls.splice(0).map(([path]) => path.split("/")[3]!);
  const [a, b, c] = [scanInfo("a"), scanInfo("b"), scanInfo("c")];
  const first = await client.mesh(a);
  expect(await client.mesh(a), "the same bytes, by which the page knows what it has found in them").toBe(first);
  await Promise.all([client.mesh(b), client.mesh(a), client.mesh(b)]);
  expect(asked()).toEqual(["a", "b"]);
  await client.mesh(c);
  await client.mesh(b);
  expect(asked()).toEqual(["c"]);
  await client.mesh(a);
  expect(asked()).toEqual(["a"]);
  await client.deletePatient("somebody");
  asked();
  await client.mesh(a);
  expect(asked()).toEqual(["a"]);
});

test("a mesh that did not arrive is asked for again", async () => {
  const fetched = vi.fn().mockRejectedValueOnce(new TypeError("offline")).mockResolvedValue(new Response(new Uint8Array([1])));
  vi.stubGlobal("fetch", fetched);
  await expect(client.mesh(scanInfo("d"))).rejects.toThrow();
  expect((await client.mesh(scanInfo("d"))).byteLength).toBe(1);
});
