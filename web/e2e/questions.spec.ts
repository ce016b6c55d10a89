// What a fit asks about picks: the row, its sentence and the mark on the body are amber where the pick was made; one answer
// settles it, is fitted at once, and comes back with the page.
import { expect, type Page } from "@playwright/test";
import type { LandmarkFile, Result, Vector } from "../src/api/types";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { fittedExample, hook, test, trueLandmarks, until, untilFitted } from "./page";
import { inTheme } from "./states";

const PICTURES = process.env.BREASTRIG_E2E_PICTURES; // a folder: for whoever wants to look

async function look(page: Page, name: string): Promise<void> {
  for (const theme of ["light", "dark"] as const) {
    await inTheme(page, theme);
    const colours = theme === "dark" ? { runOnly: ["color-contrast"] } : {}; // nothing else changes with the theme
    expect(await seriousFindings(page, colours), `${name}, ${theme}`).toEqual([]);
    expect(await overlaps(page), `${name}, ${theme}`).toEqual([]);
    expect(await smallTargets(page), `${name}, ${theme}`).toEqual([]);
    if (PICTURES) await page.screenshot({ path: `${PICTURES}/${name}-${theme}.png` });
  }
  await inTheme(page, "light");
}

const row = (page: Page, name: string) => page.locator(`.landmarks [data-landmark=${name}]`);
const pin = (page: Page, name: string) => page.locator(`.overlay:not(.other .overlay) .pin[data-landmark=${name}]`).first();
const question = (page: Page) => page.locator("#side-points .question:visible");

/** The example with landmarks that lie elsewhere, fitted. */
const fitted = (page: Page, base: string, landmarks: Record<string, Vector>) => fittedExample(page, base, { step: "points", landmarks });

/** Until the answer's own fit is on the screen. */
async function untilFittedAgain(page: Page, before: string): Promise<Result> {
  await until(page, (id) => {
    const { fit, isStarting } = window.__breastrig!.state();
    return fit && fit.id !== id && fit.state === "done" && !isStarting && (fit.drawing !== null || fit.drawingName === null);
  }, before);
  return page.evaluate(() => window.__breastrig!.state().fit!.result!);
}

const fitId = async (page: Page): Promise<string> => (await hook.fit(page))!.id;

test("a pick far off is asked about where it was made, and is calm once it is taken out", async ({ page, base, troubles }) => {
  const right = trueLandmarks();
  const [x, y, z] = right.xiphoid!;
  await fitted(page, base, { xiphoid: [x + 50, y, z] });
  await expect(page.locator("p.visually-hidden[role=status]")).toContainText("Please check: ");
  await page.getByRole("button", { name: /^Check 1 point/ }).click();
  await expect(page.locator(".check-card")).toContainText("Lower end of the breastbone");
  await expect(page.locator(".check-card").getByRole("button", { name: "Keep it" })).toBeFocused();
  await page.keyboard.press("Escape");
  await page.keyboard.press("2");

  await test.step("amber with a sign and a sentence, in the list and on the body", async () => {
    await expect(row(page, "xiphoid")).toHaveClass(/is-asked/);
    await expect(row(page, "xiphoid")).toContainText("placed, to be checked");
    await expect(row(page, "xiphoid").locator(".icon-alert")).toBeVisible();
    await expect(row(page, "xiphoid").locator(".icon-check").first(), "no tick on what is doubted").toBeHidden();
    await expect(page.locator(".landmark.is-asked")).toHaveCount(1);
    await expect(question(page)).toHaveCount(1);
    await expect(question(page)).toContainText("Lower end of the breastbone");
    await expect(pin(page, "xiphoid")).toHaveClass(/is-asked/);
    await expect(page.locator("#next")).toHaveText(/^Check 1 point/);
    await look(page, "asked");
  });

  await test.step("taken out by keys: fitted without it, the row is calm, the focus stays in the list", async () => {
    const before = await fitId(page);
    await question(page).getByRole("button", { name: /^Take it out: lower end/ }).press("Enter");
    await expect(row(page, "xiphoid").locator(".landmark-name")).toBeFocused();
    const result = await untilFittedAgain(page, before);
    expect(Object.keys(result.landmarks_picked)).not.toContain("xiphoid");
    await expect(question(page)).toHaveCount(0);
    await expect(page.locator(".landmark.is-asked")).toHaveCount(0);
    expect(await page.evaluate(() => window.__breastrig!.state().step)).toBe("points");
  });

  await test.step("undone it is asked about again; kept it is calm, and marked", async () => {
    let before = await fitId(page);
    await page.getByRole("button", { name: /^Undo/ }).click();
    await untilFittedAgain(page, before);
    await expect(question(page)).toHaveCount(1);
    before = await fitId(page);
    await question(page).getByRole("button", { name: /^Keep it: lower end/ }).click();
    const result = await untilFittedAgain(page, before);
    expect([...result.landmarks_not_followed!, ...result.landmarks_unusual!].flatMap(({ names }) => names)).not.toContain("xiphoid");
    await expect(question(page)).toHaveCount(0);
    await expect(row(page, "xiphoid").locator(".kept:not(.agreed)")).toBeVisible();
    await expect(page.locator(".top-bar .saved")).toHaveText("Saved");
  });

  await test.step("the mark comes back with the page, and can be taken away: then it is asked again", async () => {
    const { scan } = await page.evaluate(() => ({ scan: window.__breastrig!.state().scan!.info }));
    const kept = (await (await page.request.get(base + scan.links.landmarks)).json()) as LandmarkFile;
    expect(kept.certain).toEqual(["xiphoid"]);
    await page.reload();
    await hook.ready(page);
    await untilFitted(page);
    await page.keyboard.press("2");
    await expect(row(page, "xiphoid").locator(".kept:not(.agreed)")).toBeVisible();
    await expect(question(page)).toHaveCount(0);
    const before = await fitId(page);
    await row(page, "xiphoid").locator(".kept:not(.agreed)").click();
    await untilFittedAgain(page, before);
    await expect(question(page)).toHaveCount(1);
    await page.reload();
    await hook.ready(page);
    await untilFitted(page);
    await page.keyboard.press("2");
    await expect(question(page)).toHaveCount(1);
    await expect(row(page, "xiphoid")).toHaveClass(/is-asked/);
  });
  expect(troubles).toEqual([]);
});

test("exchanged nipples are repaired by one answer", async ({ page, base, troubles }) => {
  const right = trueLandmarks();
  await fitted(page, base, { nipple_L: right.nipple_R!, nipple_R: right.nipple_L! });
  await expect(question(page)).toHaveCount(1);
  for (const name of ["nipple_L", "nipple_R"]) await expect(row(page, name)).toHaveClass(/is-asked/);
  const before = await fitId(page);
  await question(page).getByRole("button", { name: /^Exchange left and right/ }).click();
  const result = await untilFittedAgain(page, before);
  expect(result.landmarks_not_followed).toEqual([]);
  for (const name of ["nipple_L", "nipple_R"]) expect(await hook.pick(page, name)).toEqual(right[name]);
  await expect(question(page)).toHaveCount(0);
  await expect(page.locator(".landmark.is-asked")).toHaveCount(0);

  await test.step("where the result knows it, each landmark has the radius that holds its true place", async () => {
    const radii = { nipple_L: 3.25, umbilicus: 12.5 };
    await page.route("**/api/fits/*/events*", async (route) => {
      const answer = await route.fetch();
      const known = JSON.stringify(radii);
      await route.fulfill({ response: answer, body: (await answer.text()).replace(/("landmark_uncertainty_mm": ?\{[^}]*\}, ?)?"landmarks_picked"/, `"landmark_uncertainty_mm":${known},"landmarks_picked"`) });
    });
    await page.reload();
    await hook.ready(page);
    await untilFitted(page);
    await page.keyboard.press("1");
    await page.locator(".numbers details:not(.solver) summary").click();
    const each = page.locator(".numbers details:not(.solver)");
    await expect(each.locator("[data-landmark=nipple_L] dd")).toHaveText(/^\d+\.\d\s±\u00a03 mm$/);
    await expect(each.locator("[data-landmark=umbilicus] dd")).toHaveText(/^\d+\.\d\s±\u00a01[23] mm$/);
    await expect(each.locator("[data-landmark=xiphoid] dd")).toHaveText(/^\d+\.\d mm$/);
    await each.scrollIntoViewIfNeeded();
    await look(page, "radii");
  });
  expect(troubles).toEqual([]);
});
