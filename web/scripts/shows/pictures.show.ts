// The pictures of README and docs: the page on the example patient.  page.webp moves: the fit settles, a pattern is drawn, the
// other stance stands beside it.  page.png, tablet.png and lesion.png are stills.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page, test } from "@playwright/test";
import { addToPlan, hook, planItem, trueLandmarks, untilFitted, untilStill } from "../../e2e/page";
import { findPython, REPOSITORY, startService } from "../../e2e/service";

const SCREEN = { width: 1280, height: 720 };
const TABLET = { width: 820, height: 1180 };
const [STEP_MS, REST_MS] = [160, 1400];
const TURN = { steps: 8, pixels: 10 }; // there and back

async function fit(page: Page): Promise<void> {
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).click();
  await untilFitted(page);
}

/** In the left breast, on both stances. */
async function lookAtLesion(page: Page): Promise<void> {
  const { nipple_L: nipple, midclavicle_L: collarbone, xiphoid } = trueLandmarks();
  const center = nipple!.map((value, i) => 0.6 * value + 0.2 * collarbone![i]! + 0.2 * xiphoid![i]!);
  await page.locator(".other-view").click();
  await page.keyboard.press("3");
  await addToPlan(page, /^Lesion in an image/);
  const lesions = page.locator(".item-details");
  await lesions.getByLabel("Name").fill("MRI 1");
  await lesions.getByLabel("Centre").fill(center.map((mm) => mm.toFixed(1)).join(" "));
  await lesions.getByLabel("Radius").fill("10");
  await lesions.getByLabel("Radius").press("Tab");
  await lesions.getByRole("button", { name: "Add" }).click();
  await expect(page.locator(".lesion-slices")).toBeVisible();
  await planItem(page, "Wise").click();
  await page.getByLabel("Show Reduction (Wise pattern)").uncheck(); // its handles would hide the ball
  await planItem(page, "MRI 1").click();
  await page.locator(".lesion-view").scrollIntoViewIfNeeded();
  const view = (await page.locator(".stage canvas.view").boundingBox())!;
  await page.mouse.move(view.x + 0.58 * view.width, view.y + 0.48 * view.height);
  for (let turn = 0; turn < 4; turn += 1) await page.mouse.wheel(0, -300);
  await page.mouse.move(2, 2);
  await expect.poll(() => page.evaluate(() => window.__breastrig!.state().stances.other!.drawn.onScan?.plan.lesions.length)).toBe(1);
}

test("pictures", async ({ browser }) => {
  const folder = process.env.BREASTRIG_SHOW_FOLDER!;
  const frames = mkdtempSync(join(tmpdir(), "breastrig-frames-"));
  mkdirSync(folder, { recursive: true });
  const service = await startService({ BREASTRIG_E2E_EXAMPLES: join(REPOSITORY, "model_assets/example") }); // as fine as it is
  const page = await (await browser.newContext({ viewport: SCREEN, reducedMotion: "reduce" })).newPage();
  const taken: { readonly file: string; readonly ms: number }[] = [];
  const frame = async (ms: number): Promise<void> => {
    const file = join(frames, `${String(taken.length).padStart(3, "0")}.png`);
    await untilStill(page);
    await page.screenshot({ path: file });
    taken.push({ file, ms });
  };

  await page.goto(service.base);
  await page.getByRole("button", { name: /standing/i }).click();
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.mouse.move(2, 2);
  await frame(REST_MS);
  await fit(page);
  const slider = page.locator("#iteration");
  const last = Number(await slider.getAttribute("max"));
  for (let shown = 0; shown < last; shown += 1) {
    await slider.fill(String(shown));
    await frame(STEP_MS);
  }
  await slider.fill(String(last));
  await frame(REST_MS);

  await page.keyboard.press("3");
  await addToPlan(page, /Wise/);
  await expect(page.locator(".handle").first()).toBeVisible();
  await page.mouse.move(2, 2);
  await frame(REST_MS);
  await page.screenshot({ path: join(folder, "page.png") });

  await page.locator("#add-stance").click();
  await page.getByRole("dialog", { name: "Add the other stance" }).getByRole("button", { name: /patient, supine/i }).click();
  await expect(page.getByRole("dialog")).toHaveCount(0);
  await hook.ready(page);
  await fit(page);
  await expect(page.getByText("Carried from standing")).toBeAttached();
  await page.locator("#compare").click();
  await page.mouse.move(2, 2);
  await frame(REST_MS);
  const box = (await page.locator(".stage canvas.view").boundingBox())!;
  let x = box.x + box.width / 2;
  const y = box.y + 70;
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (const way of [1, -1]) {
    for (let step = 0; step < TURN.steps; step += 1) {
      x += way * TURN.pixels;
      await page.mouse.move(x, y);
      await frame(STEP_MS);
    }
  }
  await page.mouse.up();
  taken.push({ file: taken.at(-1)!.file, ms: REST_MS });

  await page.setViewportSize(TABLET);
  await page.emulateMedia({ colorScheme: "dark", reducedMotion: "reduce" });
  await untilStill(page);
  await page.screenshot({ path: join(folder, "tablet.png") });

  await page.setViewportSize(SCREEN);
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await lookAtLesion(page);
  await untilStill(page);
  await page.screenshot({ path: join(folder, "lesion.png") });
  writeFileSync(join(frames, "frames.json"), JSON.stringify(taken));
  execFileSync(findPython(), [join(import.meta.dirname, "moving_picture.py"), join(frames, "frames.json"), join(folder, "page.webp")], { stdio: "inherit" });
  await service.stop();
  rmSync(frames, { recursive: true });
});
