// Lines that were drawn on the skin before the scan: found in its colours, accepted by one click, and carried to the other
// stance.  From the inked standing scan and the supine one to the ink on the supine skin in at most six clicks.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import { hook, test, untilFitted } from "./page";
import { findPython, helper } from "./service";

const state = (page: Page) => page.evaluate(() => window.__breastrig!.state());

let folder: string;
test.beforeAll(() => {
  folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  const { path, env } = helper("inked_example.py");
  execFileSync(findPython(), [path, process.env.BREASTRIG_E2E_EXAMPLES!, folder], { env, stdio: "inherit" });
});
test.afterAll(() => rmSync(folder, { recursive: true, force: true }));

test("an inked standing scan and a supine scan: the ink is on the supine skin in six clicks", async ({ page, base, troubles }, info) => {
  let clicks = 0;
  const choose = async (file: string, click: () => Promise<void>): Promise<void> => {
    const chooser = page.waitForEvent("filechooser");
    await click();
    clicks += 1;
    await (await chooser).setFiles(file);
  };
  const press = async (id: string): Promise<void> => {
    await page.locator(id).click();
    clicks += 1;
  };
  await page.goto(base);
  await choose(join(folder, "standing.zip"), () => page.locator("label:has(#scan-file)").click());
  await hook.ready(page);
  const found = page.getByRole("region", { name: "Lines found on the skin" });
  await expect(found.locator(".ink-lines li").first()).toBeVisible();
  const count = await found.locator(".ink-lines li").count();
  expect(count).toBeGreaterThan(2);
  await expect(found.locator(".ink-lines li .length").first()).toHaveText(/^\d+ mm$/);

  await test.step("lines are renamed, joined and dropped one by one; this is beside the shortest way", async () => {
    const name = found.getByRole("textbox").first();
    await name.fill("Midline");
    await name.press("Enter");
    await expect(found.getByRole("button", { name: "Accept Midline", exact: true })).toBeVisible();
    await expect(name).toHaveValue("Midline");
    await page.screenshot({ path: info.outputPath("found.png") });
  });

  await press("#accept-ink");
  await expect.poll(async () => (await state(page)).drawn.lines.present.length).toBe(count);
  await expect.poll(async () => (await state(page)).drawn.saving).toBe("saved");
  await press("#ink-other-stance");
  await choose(join(process.env.BREASTRIG_E2E_EXAMPLES!, "supine", "scan.ply"), () => page.locator("label:has(#second-scan-file)").click());
  await press("#fit-both");
  await untilFitted(page);
  await expect.poll(async () => (await state(page)).drawn.onScan?.carried.shapes.length ?? 0).toBe(count);
  expect(clicks).toBeLessThanOrEqual(6);

  const { drawn, fit, stances } = await state(page);
  expect(fit?.result?.stance).toBe("supine");
  expect(stances.other?.drawn.lines.present.map(({ name }) => name)).toContain("Midline");
  const carried = drawn.onScan!.carried.shapes;
  expect(carried.every(({ kind }) => kind === "line")).toBe(true);
  expect(carried.map(({ name }) => name)).toContain("Midline");
  // With its band: each point says how sure it is.
  expect(carried.every(({ error_mm }) => error_mm?.every((mm) => mm !== null && mm > 0))).toBe(true);
  await page.screenshot({ path: info.outputPath("carried.png") });
  expect(troubles).toEqual([]);
});
