// The first minute: files of one patient dropped together become one patient, each scan is fitted by itself and seen to
// settle, and each word of the sentence corrects itself.
import { join } from "node:path";
import { expect } from "@playwright/test";
import { seriousFindings } from "./audit";
import { drop, hook, SCAN_FILE, test, thumb, until, untilFitted } from "./page";

test.use({ fitsAtOnce: true, contextOptions: { reducedMotion: "no-preference" } }); // as most people have it

const EXAMPLE = join(process.env.BREASTRIG_E2E_EXAMPLES ?? "", "standing"); // which other tests fit with its landmarks as well
const SUPINE = SCAN_FILE.replace("standing", "supine");

const { state } = hook;

test("two scans and their landmarks are dropped together: one patient, each fitted by itself, beside each other", async ({ page, base, troubles }) => {
  await page.goto(base);
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  expect(await seriousFindings(page)).toEqual([]);
  await drop(page, [{ name: "lying.ply", path: SUPINE }, { name: "standing.ply", path: SCAN_FILE }, { name: "skin.jpg", path: SCAN_FILE }]);
  await expect(page.locator(".thumb .thumb-name")).toHaveText([/^Standing/, /^Supine/]);
  await expect(page.getByRole("alert").filter({ hasText: "1 file was not taken" })).toBeVisible();
  await expect(thumb(page, "supine")).toHaveAttribute("aria-pressed", "true");
  await expect(thumb(page, "standing")).toHaveAttribute("aria-pressed", "true");
  await untilFitted(page);
  await until(page, () => window.__breastrig!.state().stances.other?.fit?.state === "done");
  const { scan, fit, stances } = await state(page);
  expect([scan!.info.patient, fit!.state, stances.other!.scan!.info.patient]).toEqual([scan!.info.patient, "done", scan!.info.patient]);
  expect(await hook.pickCount(page), "nobody has placed a landmark").toBe(0);
  await expect(page.locator("#next")).toHaveText(/^(Draw the plan|Check )/);

  await test.step("nothing changes place: tapped away and back", async () => {
    const places = async () => {
      const both = (["standing", "supine"] as const).map((each) => thumb(page, each));
      for (const each of both) await expect(each).toBeVisible();
      return Promise.all(both.map(async (each) => (await each.boundingBox())?.y));
    };
    const before = await places();
    await thumb(page, "standing").click();
    expect((await state(page)).scan!.info.stance.proposed, "in work now").toBe("standing");
    await expect(page.locator(".other-stage")).toBeVisible();
    expect(await places()).toEqual(before);
    await thumb(page, "standing").click();
    await expect(thumb(page, "standing")).toHaveAttribute("aria-pressed", "false");
    await expect(page.locator(".other-stage")).toBeHidden();
    await thumb(page, "standing").click();
    await expect(page.locator(".other-stage")).toBeVisible();
    expect(await places()).toEqual(before);
  });
  expect(troubles).toEqual([]);
});

test("a scan that comes is fitted by itself and seen to settle; each word of the sentence corrects itself", async ({ page, base, troubles }) => {
  await page.addInitScript(() => {
    const seen: { shown: number; at: number }[] = [];
    Object.assign(window, { seen });
    setInterval(() => {
      const fit = window.__breastrig?.state().fit;
      if (fit && fit.shown >= 0 && fit.shown !== seen.at(-1)?.shown) seen.push({ shown: fit.shown, at: performance.now() });
    }, 20);
  });
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await untilFitted(page);
  const settled = await page.evaluate(() => (window as unknown as { seen: { shown: number; at: number }[] }).seen);
  expect(settled.length, "steps that were seen").toBeGreaterThan(4);
  expect(settled.at(-1)!.at - settled[0]!.at, "milliseconds").toBeGreaterThan(500);
  const sentence = page.locator(".sentence");
  await expect(sentence).toHaveText(/^Standing\s?,\s?a woman\?\s?,\s?\d\d\scm tall\s?,\s?facing you$/, { useInnerText: true });
  const first = (await hook.fit(page))!.id;

  await test.step("lying, not standing: the fit that knows it is made at once", async () => {
    await sentence.getByRole("button", { name: "Standing" }).click();
    await page.locator("#stance-word").getByRole("button", { name: "Supine" }).click();
    await expect(sentence).toHaveText(/^Supine\s?,\s?a woman\?\s?,\s?\d\d\scm long\s?,\s?face up$/, { useInnerText: true });
    await expect.poll(async () => (await hook.fit(page))!.id).not.toBe(first);
    await untilFitted(page);
    expect((await state(page)).fit!.result!.stance).toBe("supine");
  });

  await test.step("in feet: the file is read again, and the size that looks wrong is asked about before anything is fitted", async () => {
    await sentence.getByRole("button", { name: /cm long/ }).click();
    const before = (await state(page)).scan!.info.id;
    await page.locator("#size-word").getByRole("button", { name: /^Feet/ }).click();
    await expect.poll(async () => (await state(page)).scan?.info.id).not.toBe(before);
    await hook.ready(page);
    const { scan, fit } = await state(page);
    expect(scan!.info.size_doubt).not.toBe("");
    expect(fit).toBeNull();
    const doubt = page.locator(".doubt-card");
    await expect(doubt).toContainText(scan!.info.size_doubt!);
    await expect(doubt.getByRole("heading", { name: "Is the size right?" })).toBeFocused();
    await expect(page.locator("#next")).toBeHidden();
    expect(await seriousFindings(page)).toEqual([]);
    await doubt.getByRole("button", { name: /^Metres: \d\d\scm$/ }).click();
    await expect.poll(async () => (await state(page)).scan?.info.unit).toBe("m");
    await untilFitted(page);
    await expect(doubt).toBeHidden();
  });

  await test.step("the picture is turned, and says by whom", async () => {
    await sentence.getByRole("button", { name: /facing you|face up/ }).click();
    await page.getByRole("button", { name: "Turn about its long axis" }).click();
    await page.keyboard.press("Escape");
    await expect(sentence).toContainText("turned by you");
  });
  expect(troubles).toEqual([]);
});

test("landmarks that are dropped with one scan are placed on it, and the fit knows them", async ({ page, base }) => {
  await page.goto(base);
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  await drop(page, [{ name: "scan.ply", path: join(EXAMPLE, "scan.ply") }, { name: "picks.json", path: join(EXAMPLE, "landmarks.json") }]);
  await hook.ready(page);
  await expect.poll(() => hook.pickCount(page)).toBe(12);
  await untilFitted(page);
  expect(Object.keys((await state(page)).fit!.result!.landmark_distance_mm.each)).toHaveLength(12);
});
