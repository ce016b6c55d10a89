// The pictures of README and docs: the surgeon's tutorial step by step.  page.webp moves: the fit settles, then the steps.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Page, test } from "@playwright/test";
import { look, openDetails, planItem, untilStill } from "../../e2e/page";
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
