// Who may see what, in a real browser: its cookies, origins and policies are not those of a test client.
import { expect, test } from "@playwright/test";
import { seriousFindings, smallTargets } from "./audit";
import { example, hook, look, more, openShare, until, untilFitted } from "./page";
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
  for (const colorScheme of ["light", "dark"] as const) {
    await page.emulateMedia({ colorScheme });
    expect(await seriousFindings(page), `${colorScheme}: axe-core`).toEqual([]);
    expect(await smallTargets(page)).toEqual([]);
  }
  await page.getByLabel("Access token").fill("wrong");
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("alert")).toContainText("This is not the token.");
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible(); // the examples came from the API
  expect(await page.evaluate(() => document.cookie)).toBe("");
  await page.goto(`${service.base}/sign-in`);
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.goto(service.base);
  await expect(page.getByLabel("Access token")).toBeVisible();
});

test("a visitor opens a shared result with its passcode, sees nothing else, and is out when it is revoked", async ({ page }) => {
  interface Links {
    links: Record<string, string>;
  }
  const scan = await ask<Links & { id: string }>("/api/examples/standing", "POST");
  const fit = await ask<Links>("/api/fits", "POST", { scan: scan.id });
  await expect.poll(async () => (await ask<{ state: string }>(fit.links.self!)).state).toBe("done");
  const share = await ask<Links & { id: string; url: string }>(fit.links.shares!, "POST", { passcode: "4711 please" });
  await page.goto(service.base + share.url);
  await page.getByLabel("Passcode").fill("4711");
  await page.getByRole("button", { name: "Open" }).click();
  await expect(page.getByRole("alert")).toContainText("not the link's passcode");
  await page.getByLabel("Passcode").fill("4711 please");
  await page.getByRole("button", { name: "Open" }).click();
  await expect(page.getByText("fitted.glb")).toBeVisible();
  await expect(page.getByLabel("Passcode")).toBeHidden();
  await expect(page.getByText("scan.glb")).toHaveCount(0);
  await until(page, () => window.__breastrig?.state().fit != null);
  expect((await hook.picture(page)).colours, "the model is drawn without the scan").toBeGreaterThan(100);
  const status = (path: string): Promise<number> => page.evaluate(async (address) => (await fetch(address)).status, path);
  expect(await status(`/api/shared/${share.id}/result.json`)).toBe(200);
  expect(await status(`/api/shared/${share.id}/mesh.glb`)).toBe(403);
  for (const path of [scan.links.self!, scan.links.mesh!, fit.links.self!, fit.links.result!]) expect(await status(path)).toBe(401);
  await ask(share.links.self!, "DELETE");
  expect(await status(`/api/shared/${share.id}/result.json`)).toBe(410);
});

test("a link is made in the dialog, opened, counted and revoked; the page signs out", async ({ page, browser }) => {
  await page.goto(service.base);
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
  await example(page);
  await hook.ready(page);
  await untilFitted(page);
  await openShare(page);
  const dialog = page.getByRole("dialog", { name: "Share this result" });
  await expect(dialog.getByText("None yet.")).toBeVisible();
  await dialog.getByLabel("It shows").selectOption("plain");
  await dialog.getByLabel("It ends after").selectOption("30");
  await dialog.getByLabel(/^Passcode/).fill("4711 please");
  await dialog.getByRole("button", { name: "Make a link" }).click();
  const address = dialog.getByLabel("Address of the link");
  await expect(address).toHaveValue(/\/s#[\w-]{32}$/);
  await expect(dialog.getByText("Never opened")).toBeVisible();

  const visitor = await (await browser.newContext()).newPage();
  await visitor.goto(await address.inputValue());
  await visitor.getByLabel("Passcode").fill("4711 please");
  await visitor.getByRole("button", { name: "Open" }).click();
  await expect(visitor.getByText("fitted.glb")).toBeVisible();
  await hook.ready(visitor);
  expect((await hook.picture(visitor)).colours, "a lit body has many shades").toBeGreaterThan(100);
  const both = await hook.picture(visitor);
  await look(visitor, "Model");
  const model = await hook.picture(visitor);
  expect(model.checksum).not.toBe(both.checksum);
  await look(visitor, "Distances");
  await expect(visitor.locator(".colour-bar")).toBeVisible();
  expect((await hook.picture(visitor)).checksum).not.toBe(model.checksum);
  const sure = await page.locator(".stage .sureness").textContent();
  await expect(visitor.locator(".stage .sureness")).toHaveText(sure!);
  await expect(visitor.getByRole("button", { name: /Fit|Place|Share/ })).toHaveCount(0);

  await page.keyboard.press("Escape");
  await expect(dialog).toBeHidden();
  await openShare(page);
  await expect(dialog.getByText(/^Opened 1 time, last on/)).toBeVisible();
  await expect(address).toBeHidden();
  await dialog.getByRole("button", { name: "Revoke" }).click();
  await expect(dialog.getByText(/^Revoked on/)).toBeVisible();
  await visitor.reload();
  await expect(visitor.getByRole("alert")).toContainText("expired or was revoked");
  await visitor.context().close();

  await page.keyboard.press("Escape");
  await more(page, "Sign out");
  await expect(page.getByLabel("Access token")).toBeVisible();
});

test("when the session has ended the sign-in page comes, and afterwards scan and unsaved landmarks are there again", async ({ page, context }) => {
  await page.goto(service.base);
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");
  await expect(page.locator("[data-proposed]").first()).toBeAttached();
  await context.clearCookies();
  await page.getByRole("button", { name: /^Confirm the proposed nipple, patient's left/ }).click();
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
  await hook.ready(page);
  await expect.poll(() => hook.pickCount(page)).toBe(1);
  await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
});
