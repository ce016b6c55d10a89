// Who may see what, in a real browser: its cookies, origins and policies are not those of a test client.
import { expect, type Page, test } from "@playwright/test";
import { seriousFindings, smallTargets } from "./audit";
import { example, hook, look, more, openShare, until, untilFitted } from "./page";
import { Owner } from "./shared";

const owner = new Owner();

async function signIn(page: Page): Promise<void> {
  await page.getByLabel("Access token").fill(owner.token);
  await page.getByRole("button", { name: "Sign in" }).click();
}

test("a person signs in with the token, and out again", async ({ page }) => {
  await page.goto(owner.base);
  for (const colorScheme of ["light", "dark"] as const) {
    await page.emulateMedia({ colorScheme });
    expect(await seriousFindings(page), `${colorScheme}: axe-core`).toEqual([]);
    expect(await smallTargets(page)).toEqual([]);
  }
  await page.getByLabel("Access token").fill("wrong");
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("alert")).toContainText("This is not the token.");
  await signIn(page);
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible(); // the examples came from the API
  expect(await page.evaluate(() => document.cookie)).toBe("");
  await page.goto(`${owner.base}/sign-in`);
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.goto(owner.base);
  await expect(page.getByLabel("Access token")).toBeVisible();
});

test("a visitor opens a shared result with its passcode, sees nothing else, and is out when it is revoked", async ({ page }) => {
  const { scan, fit } = await owner.fitted("standing");
  const share = await owner.share(fit, { passcode: "4711 please" });
  await page.goto(owner.base + share.url);
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
  for (const path of [scan.self!, scan.mesh!, fit.self!, fit.result!]) expect(await status(path)).toBe(401);
  await owner.ask(share.links.self, "DELETE");
  expect(await status(`/api/shared/${share.id}/result.json`)).toBe(410);
});

test("a link is made in the dialog, opened, counted and revoked; the page signs out", async ({ page, browser }) => {
  await page.goto(owner.base);
  await signIn(page);
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
  await page.evaluate(() => {
    for (const storage of [sessionStorage, localStorage]) storage.setItem("left", "something");
  });
  await more(page, "Sign out");
  await expect(page.getByLabel("Access token")).toBeVisible();
  expect(await page.evaluate(() => [sessionStorage.getItem("left"), localStorage.getItem("left")]), "nothing of patients stays").toEqual([null, null]);
  expect((await page.context().cookies()).map(({ name }) => name)).toEqual([]);
});

test("when the session has ended the sign-in page comes, and afterwards scan and unsaved landmarks are there again", async ({ page, context }) => {
  await page.goto(owner.base);
  await signIn(page);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");
  await expect(page.locator("[data-proposed]").first()).toBeAttached();
  await context.clearCookies();
  await page.getByRole("button", { name: /^Confirm the proposed nipple, patient's left/ }).click();
  await signIn(page);
  await hook.ready(page);
  await expect.poll(() => hook.pickCount(page)).toBe(1);
  await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
});
