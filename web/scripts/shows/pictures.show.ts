// The pictures of README and docs: the surgeon's tutorial step by step.  page.webp moves: the fit settles, then the steps.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Page, test } from "@playwright/test";
import type { Vector } from "../../src/api/types";
import { fittedExample, hook, look, openDetails, planItem, untilFitted, untilStill } from "../../e2e/page";
import { findPython, startService } from "../../e2e/service";
import { followTutorial, SHIPPED } from "../../e2e/tutorialSteps";

const SCREEN = { width: 1280, height: 720 };
const TABLET = { width: 820, height: 1180 };
const [STEP_MS, REST_MS] = [160, 1800];

test("pictures", async ({ browser }) => {
  test.slow();
  const folder = process.env.BREASTRIG_SHOW_FOLDER!;
  const frames = mkdtempSync(join(tmpdir(), "breastrig-frames-"));
  mkdirSync(folder, { recursive: true });
  const service = await startService(SHIPPED);
  const page = await (await browser.newContext({ viewport: SCREEN, reducedMotion: "reduce" })).newPage();
  let taken = 0;
  const frame = async (ms: number): Promise<{ file: string; ms: number }> => {
    const file = join(frames, `${String((taken += 1)).padStart(3, "0")}.png`);
    await page.mouse.move(640, 4);
    await untilStill(page);
    await page.screenshot({ path: file });
    return { file, ms };
  };
  const write = (name: string, shown: readonly { file: string; ms: number }[]): void => {
    const list = join(frames, "frames.json");
    writeFileSync(list, JSON.stringify(shown));
    execFileSync(findPython(), [join(import.meta.dirname, "moving_picture.py"), list, join(folder, `${name}.webp`)], { stdio: "inherit" });
  };

  const shown: { file: string; ms: number }[] = [];
  await followTutorial(page, service.base, async (step) => {
    if (step === "body") shown.push(...(await settling(page, frame)));
    const still = await frame(REST_MS);
    write(step, [still]);
    shown.push(still);
  });
  write("page", shown);

  await page.locator("#tab-plan").click();
  await page.getByRole("button", { name: /^Close the slices/ }).click();
  await planItem(page, "Wise").click();
  await page.setViewportSize(TABLET);
  await page.emulateMedia({ colorScheme: "dark", reducedMotion: "reduce" });
  write("tablet", [await frame(REST_MS)]);
  await service.stop();
  rmSync(frames, { recursive: true });
});

/** The how-to on marks and the true size: a scan with dots that have numbers, and a length that is about to be applied. */
test("marks and true size", async ({ browser }) => {
  const service = await startService(SHIPPED);
  const page = await (await browser.newContext({ viewport: SCREEN, reducedMotion: "reduce" })).newPage();
  await fittedExample(page, service.base, { step: "points" });
  const list = page.getByRole("region", { name: "Marks on the skin" });
  const [left, right, middle] = await Promise.all(["nipple_L", "nipple_R", "mid_sternum"].map(async (name) => (await hook.pick(page, name))!));
  const dots = [left!, right!].flatMap((nipple) => [0.35, 0.65].map((share) => nipple.map((value, axis) => value + share * (middle![axis]! - value)) as Vector));
  for (const [number, dot] of dots.entries()) {
    await list.getByRole("button", { name: "Add a mark" }).click();
    await untilStill(page);
    const { x, y } = await hook.project(page, dot);
    await page.mouse.click(x, y + 25);
    await list.getByLabel("Name of the mark mark 1").fill(String(number + 1));
    await page.keyboard.press("Enter");
  }
  await page.locator("#next").click();
  await untilFitted(page);
  await openDetails(page);
  const size = page.getByRole("region", { name: "True size" });
  await size.getByLabel("From").selectOption("suprasternal_notch");
  await size.getByLabel("To").selectOption("nipple_L");
  await size.getByLabel("On the patient").fill("26.1");
  await page.keyboard.press("Tab");
  await size.scrollIntoViewIfNeeded();
  await page.mouse.move(640, 4);
  await untilStill(page);
  const folder = mkdtempSync(join(tmpdir(), "breastrig-frames-"));
  const [file, shown] = [join(folder, "marks.png"), join(folder, "frames.json")];
  await page.screenshot({ path: file });
  writeFileSync(shown, JSON.stringify([{ file, ms: REST_MS }]));
  execFileSync(findPython(), [join(import.meta.dirname, "moving_picture.py"), shown, join(process.env.BREASTRIG_SHOW_FOLDER!, "marks.webp")], { stdio: "inherit" });
  await service.stop();
  rmSync(folder, { recursive: true });
});

/** One frame for each iterate of the fit. */
async function settling(page: Page, frame: (ms: number) => Promise<{ file: string; ms: number }>): Promise<{ file: string; ms: number }[]> {
  await look(page, "Both");
  await openDetails(page);
  const slider = page.locator("#iteration");
  const last = Number(await slider.getAttribute("max"));
  const seen = [];
  for (let shown = 0; shown <= last; shown += 1) {
    await slider.fill(String(shown));
    seen.push(await frame(STEP_MS));
  }
  await page.locator("#details > summary").click();
  await look(page, "Skin");
  await page.locator(".side-scroll").evaluate((side) => side.scrollTo(0, 0));
  return seen;
}
