// How long the page stands still while a scan of a million triangles is opened, shaded, and a part of it hidden: the longest
// tasks of the main thread, as the browser counts them (from 50 ms on).
import { type Page, test } from "@playwright/test";
import { hook } from "../../e2e/page";
import { bodyOf } from "./body";

const TRIANGLES = Number(process.env.BREASTRIG_SHOW_TRIANGLES ?? 1_000_000);

async function longTasks(page: Page, what: string, during: () => Promise<void>): Promise<void> {
  await page.evaluate(() => {
    const tasks: number[] = [];
    const observer = new PerformanceObserver((list) => tasks.push(...list.getEntries().map(({ duration }) => duration)));
    observer.observe({ type: "longtask" });
    Object.assign(window, { tasks, observer });
  });
  const begun = performance.now();
  await during();
  await page.waitForTimeout(500);
  const tasks = await page.evaluate(() => {
    const { tasks, observer } = window as unknown as { tasks: number[]; observer: PerformanceObserver };
    observer.disconnect();
    return tasks.sort((a, b) => b - a).map((ms) => Math.round(ms));
  });
  console.log(`${what}: ${((performance.now() - begun) / 1000).toFixed(1)} s in all, tasks over 50 ms: ${tasks.slice(0, 8).join(", ") || "none"}`);
}

test(`${TRIANGLES} triangles`, async ({ page }) => {
  await page.goto(process.env.BREASTRIG_E2E_BASE!);
  const file = { name: "scan.ply", mimeType: "application/octet-stream", buffer: bodyOf(TRIANGLES) };
  await longTasks(page, "until the scan is drawn and the worker has answered", async () => {
    await page.locator("#scan-file").setInputFiles(file);
    await hook.ready(page);
  });
  console.log(`drawn: ${await page.evaluate(() => window.__breastrig!.state().scan!.info.triangles)} triangles`);
  await longTasks(page, "folds off and on again", async () => {
    await page.locator("#relief").click();
    await page.waitForTimeout(300);
    await page.locator("#relief").click();
  });
  const box = (await page.locator("main canvas.view").boundingBox())!;
  await page.locator("#lasso").click();
  await longTasks(page, "a part hidden by the lasso, until it is gone", async () => {
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.3 * box.height);
    await page.mouse.down();
    for (const [x, y] of [[0.48, 0.3], [0.48, 0.7], [0.3, 0.7], [0.3, 0.3]] as const) await page.mouse.move(box.x + x * box.width, box.y + y * box.height, { steps: 6 });
    await page.mouse.up();
    await page.waitForFunction(() => !window.__breastrig!.isReady());
    await hook.ready(page);
  });
  await longTasks(page, "shown again", async () => {
    await page.keyboard.press("z");
    await page.waitForTimeout(1000);
    await hook.ready(page);
  });
});
