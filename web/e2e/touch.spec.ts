// A tablet: one finger turns, a tap places, a finger held still aims above its tip, two fingers zoom; nothing lies over
// anything else, lying or upright.
import { expect, type Page } from "@playwright/test";
import type { PatientPage } from "../src/api/types";
import { overlaps, smallTargets } from "./audit";
import { distance, example, type FingerEvent, hook, look, tap, tapAt, test, touch, trueLandmarks, until, untilFitted, untilStill } from "./page";

test.use({ hasTouch: true, viewport: { width: 1024, height: 768 } });

const ABOVE = 56; // pixels: as fingers.ts

/** Controls that cover each other, and how much wider the page is than the screen. */
async function mess(page: Page): Promise<string[]> {
  const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  return [...(await overlaps(page)), ...(await smallTargets(page)), ...(wider > 0 ? [`the page is ${wider} pixels wider than the screen`] : [])];
}

test("fingers turn, place, aim and zoom; both ways of holding a tablet have room for all", async ({ page, base, troubles, context }) => {
  const truth = trueLandmarks();
  const session = await context.newCDPSession(page);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.goto(base);
  expect(await mess(page)).toEqual([]);
  await example(page);
  await hook.ready(page);
  expect(await mess(page)).toEqual([]);
  await tap(page.getByRole("button", { name: "Set points myself" }));
  await expect(page.locator("[data-proposed]").first()).toBeAttached();

  await test.step("a tap places", async () => {
    await tap(page.locator(".landmarks [data-landmark=umbilicus] .landmark-name"));
    await untilStill(page); // the eye comes near
    const { x, y } = await hook.project(page, truth.umbilicus!);
    await tapAt(session, { x, y });
    await expect.poll(() => hook.pickCount(page)).toBe(1);
    expect(distance((await hook.pick(page, "umbilicus"))!, truth.umbilicus!)).toBeLessThan(4);
  });

  await test.step("a finger held still aims above its tip, with the loupe; lifting it places", async () => {
    await tap(page.locator(".landmarks [data-landmark=mid_sternum] .landmark-name"));
    await untilStill(page);
    const goal = await hook.project(page, truth.mid_sternum!);
    const finger = { x: goal.x - 20, y: goal.y + ABOVE + 12 };
    await touch(session, ["touchStart", [finger]]);
    await expect(page.locator(".crosshair")).toBeVisible();
    await expect(page.locator(".loupe")).toBeVisible();
    const before = await hook.picture(page);
    await touch(session, ["touchMove", [{ x: goal.x, y: goal.y + ABOVE }]]);
    expect((await hook.picture(page)).checksum, "aiming does not turn the body").toBe(before.checksum);
    await touch(session, ["touchEnd", []]);
    await expect.poll(() => hook.pickCount(page)).toBe(2);
    expect(distance((await hook.pick(page, "mid_sternum"))!, truth.mid_sternum!)).toBeLessThan(3);
    await expect(page.locator(".crosshair")).toBeHidden();
    expect(await hook.pickCount(page)).toBe(2);
  });

  await test.step("one finger turns while placing, two zoom, and neither places", async () => {
    const [a, b] = [truth.nipple_L!, truth.nipple_R!];
    const apart = async (): Promise<number> => Math.abs((await hook.project(page, a)).x - (await hook.project(page, b)).x);
    const box = (await page.locator("main canvas.view").boundingBox())!;
    const middle = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    await page.keyboard.press("f");
    await untilStill(page);
    const front = await apart();
    const along = [10, 40, 80, 120].map((step): FingerEvent => ["touchMove", [{ x: middle.x + step, y: middle.y }]]);
    await touch(session, ["touchStart", [middle]], ...along, ["touchEnd", []]);
    await untilStill(page);
    expect(await apart(), "turned away").toBeLessThan(0.95 * front);
    await page.keyboard.press("f");
    await untilStill(page);
    const pair = (half: number) => [{ x: middle.x - half, y: middle.y }, { x: middle.x + half, y: middle.y }];
    await touch(session, ["touchStart", pair(40)]);
    for (const half of [50, 65, 80]) await touch(session, ["touchMove", pair(half)]);
    await touch(session, ["touchEnd", []]);
    await untilStill(page);
    expect(await apart(), "twice as far apart, about twice as near").toBeGreaterThan(1.3 * front);
    expect(await hook.pickCount(page)).toBe(2);
    await page.keyboard.press("f");
  });

  await test.step("lying and upright, from the landmarks to the result", async () => {
    await expect(page.locator("[data-proposed]").first()).toBeAttached();
    expect(await mess(page)).toEqual([]);
    await tap(page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }));
    await untilFitted(page);
    await until(page, () => window.__breastrig?.state().fit?.distances);
    for (const viewport of [{ width: 1024, height: 768 }, { width: 768, height: 1024 }, { width: 390, height: 844 }, { width: 1280, height: 720 }]) {
      await page.setViewportSize(viewport);
      for (const overlay of ["Both", "Model"] as const) {
        await look(page, overlay);
        expect(await mess(page), `${viewport.width} x ${viewport.height}, ${overlay}`).toEqual([]);
      }
    }
  });

  await test.step("a telephone, and a window magnified to 200 %: the body is as wide as the screen and high enough to work on", async () => {
    for (const viewport of [{ width: 390, height: 844 }, { width: 640, height: 360 }]) {
      await page.setViewportSize(viewport);
      const stage = (await page.locator(".stage").first().boundingBox())!;
      expect(stage.width, `${viewport.width}`).toBe(viewport.width);
      expect(stage.height, `${viewport.height}`).toBeGreaterThan(300);
    }
  });
  await test.step("the patients, one of them with a card", async () => {
    await page.route(/\/api\/patients\?/, async (route) => { // each with as many pictures as a card shows, and a code as narrow as there is
      const answer = await route.fetch();
      const body = (await answer.json()) as PatientPage;
      await route.fulfill({ response: answer, json: { ...body, patients: body.patients.map((one) => ({ ...one, code: "III-III", scans: Array.from({ length: 4 }, () => one.scans[0]) })) } });
    });
    for (const viewport of [{ width: 390, height: 844 }, { width: 1024, height: 768 }]) {
      await page.setViewportSize(viewport);
      if (await page.locator(".patients").isHidden()) await tap(page.locator("button.logo"));
      await expect(page.locator(".patients li").first()).toBeVisible();
      expect(await mess(page), `${viewport.width}`).toEqual([]);
    }
  });
  expect(troubles).toEqual([]);
});
