// Who may see what, in a real browser: its cookies, origins and policies are not those of a test client.
import { expect, test } from "@playwright/test";
import { type Running, startService } from "./service";

const TOKEN = "a-token-of-more-than-sixteen-characters";
let service: Running;

test.beforeAll(async () => {
  service = await startService({ BREASTRIG_TOKEN: TOKEN });
});
test.afterAll(() => service.stop());

async function ask<Body>(path: string, method = "GET", body?: object): Promise<Body> {
  const headers = { Authorization: `Bearer ${TOKEN}`, "Content-Type": "application/json" };
  const answer = await fetch(service.base + path, { method, headers, ...(body ? { body: JSON.stringify(body) } : {}) });
  expect(answer.ok).toBe(true);
  return (answer.status === 204 ? null : await answer.json()) as Body;
}

test("a person signs in with the token, and out again", async ({ page }) => {
  await page.goto(service.base);
  await page.getByLabel("Access token").fill("wrong");
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("alert")).toContainText("This is not the token.");
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("button", { name: /standing/i })).toBeVisible(); // the examples came from the API
  expect(await page.evaluate(() => document.cookie)).toBe("");
  await page.goto(`${service.base}/sign-in`);
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.goto(service.base);
  await expect(page.getByLabel("Access token")).toBeVisible();
});

test("a visitor opens a shared result with its passcode, sees nothing else, and is out when it is revoked", async ({ page }) => {
  type Links = { links: Record<string, string> };
  const scan = await ask<Links & { id: string }>("/api/examples/standing", "POST");
  const fit = await ask<Links>("/api/fits", "POST", { scan: scan.id });
  await expect.poll(async () => (await ask<{ state: string }>(fit.links.self!)).state).toBe("done");
  const share = await ask<Links & { url: string }>(fit.links.shares!, "POST", { passcode: "4711 please" });
  await page.goto(service.base + share.url);
  await page.getByLabel("Passcode").fill("4711");
  await page.getByRole("button", { name: "Open" }).click();
  await expect(page.getByRole("alert")).toContainText("not the link's passcode");
  await page.getByLabel("Passcode").fill("4711 please");
  await page.getByRole("button", { name: "Open" }).click();
  await expect(page.getByText("fitted.glb")).toBeVisible();
  await expect(page.getByLabel("Passcode")).toBeHidden();
  await expect(page.getByText("scan.glb")).toHaveCount(0);
  const status = (path: string): Promise<number> => page.evaluate(async (address) => (await fetch(address)).status, path);
  expect(await status("/api/shared/result.json")).toBe(200);
  expect(await status("/api/shared/mesh.glb")).toBe(403);
  for (const path of [scan.links.self!, scan.links.mesh!, fit.links.self!, fit.links.result!]) expect(await status(path)).toBe(401);
  await ask(share.links.self!, "DELETE");
  expect(await status("/api/shared/result.json")).toBe(410);
});
