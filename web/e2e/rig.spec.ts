// A rig's day in the browser: a forearm, made by data only, served with `--model`; its scan is brought, fitted, drawn on,
// measured, reported and shared.  The page shows what the rig has, and nothing of breasts or sides.
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect } from "@playwright/test";
import { hook, openShare, planItem, test, untilFitted } from "./page";
import { findPython, FOREARM, type Running, startService } from "./service";

const folder = mkdtempSync(join(tmpdir(), "breastrig-rig-"));
const PICTURES = process.env.BREASTRIG_E2E_PICTURES; // a folder: for whoever wants to look
let service: Running;
test.use({ base: async ({}, use) => use(service.base) });
test.beforeAll(async () => {
  execFileSync(findPython(), [FOREARM, folder]);
  const side = join(folder, "forearm.json"); // the page has to pose such a rig itself
  writeFileSync(side, readFileSync(side, "utf-8").replace('"up":', '"skinning": "dual_quaternion",\n "up":'));
  service = await startService({}, ["--no-token", "--model", join(folder, "forearm.glb")]);
});
test.afterAll(async () => {
  await service.stop();
  rmSync(folder, { recursive: true });
});

test("a forearm is fitted, drawn on, measured, reported and shared", async ({ page, base, troubles, browser }) => {
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(join(folder, "scan.ply"));
  await hook.ready(page);
  await expect(page.locator("[popovertarget=model-word]")).toBeHidden(); // there is but this one
  const doubt = page.locator(".doubt-card"); // its size is far from that of most scans
  await expect(doubt).toContainText("less than scans usually show");
  await expect(doubt).not.toContainText("torso");
  await doubt.getByRole("button", { name: "Yes, the size is right" }).click();

  await test.step("its own landmarks are asked for", async () => {
    await page.keyboard.press("2");
    await expect(page.locator(".landmark .label-text")).toHaveText(["Elbow crease", "Tip of the radius", "Tip of the ulna", "Wrist crease", "Knuckle of the middle finger"]);
    await page.locator("#landmark-file").setInputFiles(join(folder, "landmarks.json"));
    await expect.poll(() => hook.pickCount(page)).toBe(5);
  });

  await test.step("fitted, and not judged by what is known of another rig", async () => {
    await page.keyboard.press("1");
    await page.getByRole("button", { name: "Fit with 5 landmarks" }).click();
    await untilFitted(page);
    await expect(page.locator(".numbers .verdict")).toContainText("Not calibrated for this rig");
    expect(await page.evaluate(() => document.body.innerText)).not.toMatch(/\bbreasts?\b|nipple/i);
  });

  await test.step("its drawing lies on the skin", async () => {
    await page.keyboard.press("3");
    await page.getByRole("button", { name: "+ Add" }).click();
    await expect(page.locator("#add-menu .menu-item:visible > span:first-of-type"), "no tumour by the clock").toHaveText(["Incision", "Line", "Circle on the skin", "Lesion in an image", "Note", "Lines of a file"]);
    const before = await hook.picture(page);
    await page.locator("#add-menu").getByRole("button", { name: "Incision" }).click();
    await expect(planItem(page, "Incision")).toHaveCount(1);
    await expect.poll(async () => (await hook.picture(page)).checksum).not.toBe(before.checksum);
    if (PICTURES) await page.screenshot({ path: `${PICTURES}/drawn.png` });
  });

  await test.step("its lengths are measured, and the report is there", async () => {
    await page.keyboard.press("4");
    await page.locator("#measures").click();
    const dialog = page.getByRole("dialog", { name: "Measures" });
    await expect(dialog.locator("tbody tr[data-measure=radius]")).toHaveCount(2);
    await expect(dialog.locator("tbody tr[data-measure=radius]").first()).toContainText(/Length of the radius.*23\d/);
    if (PICTURES) await page.screenshot({ path: `${PICTURES}/measures.png` });
    const report = await page.request.get(base + (await dialog.locator("#report-both").getAttribute("href"))!);
    expect((await report.body()).subarray(0, 5).toString()).toBe("%PDF-");
    await page.keyboard.press("Escape");
    await expect(dialog).toBeHidden();
  });

  await test.step("and a colleague is shown it by a link", async () => {
    await openShare(page);
    const dialog = page.getByRole("dialog", { name: "Share this result" });
    await dialog.getByRole("button", { name: "Make a link" }).click();
    await expect(dialog.getByLabel("Address of the link")).not.toHaveValue("");
    const colleague = await (await browser.newContext()).newPage();
    await colleague.goto(await dialog.getByLabel("Address of the link").inputValue());
    await expect(colleague.getByText("fitted.glb")).toBeVisible();
    await expect(colleague.locator("[data-line=palmar]")).toHaveCount(1);
    if (PICTURES) await colleague.screenshot({ path: `${PICTURES}/shared.png` });
  });
  expect(troubles).toEqual([]);
});
