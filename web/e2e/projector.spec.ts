// The second screen: opened from a fit, brought to true scale with a bank card, and through a made projector whose place is found
// from clicks; what is drawn is what the plan says.
import { expect, type Page } from "@playwright/test";
import type { Vector } from "../src/api/types";
import { cross, dot } from "../src/viewer/frame";
import { seriousFindings, smallTargets } from "./audit";
import { hook, test, trueLandmarks, untilFitted } from "./page";

/** How many pixels of the picture are not black. */
const drawn = (page: Page): Promise<number> =>
  page.evaluate(() => {
    const { width, height } = document.querySelector<HTMLCanvasElement>(".projector-picture")!;
    const pixels = document.querySelector<HTMLCanvasElement>(".projector-picture")!.getContext("2d")!.getImageData(0, 0, width, height).data;
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) if (pixels[i]! + pixels[i + 1]! + pixels[i + 2]! > 200) count += 1;
    return count;
  });

test("the plan at true scale and through a projector", async ({ page, base, troubles, context }) => {
  await page.goto(base);
  await page.getByRole("button", { name: /standing/i }).click();
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.keyboard.press("3");
  await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).first().click();
  await untilFitted(page);
  const frame = await page.evaluate(() => window.__breastrig!.state().scan!.info.frame);
  await page.getByRole("button", { name: "Export" }).click();
  const opening = context.waitForEvent("page");
  await page.getByRole("link", { name: /Show on a second screen/ }).click();
  const screen = await opening;
  await screen.setViewportSize({ width: 1440, height: 900 });
  await expect(screen.getByText("Experimental. Not for guiding an operation.").first()).toBeVisible();
  const done = screen.getByRole("button", { name: "The bar is as wide as the card" });
  await expect(done).toBeVisible();

  await test.step("without a plan it says what to do, without its tools too, and shows the plan once there is one", async () => {
    const said = screen.getByText("Nothing is planned on this scan yet: draw on it in the other tab, and it appears here.");
    await expect(said).toBeVisible();
    await screen.keyboard.press("h");
    await expect(screen.locator(".projector-tools")).toBeHidden();
    await expect(said).toBeVisible();
    await page.keyboard.press("4");
    await page.locator(".pattern summary").click();
    await page.locator(".pattern select").first().selectOption("lumpectomy");
    await expect(screen.getByText("press H for the tools"), "the screen is not measured").toBeVisible();
    await screen.keyboard.press("h");
    await expect(screen.locator(".projector-empty")).toHaveText("");
  });

  await test.step("true scale", async () => {
    expect(await drawn(screen), "nothing before the screen is measured").toBe(0);
    await screen.getByRole("slider", { name: "Width of the bar" }).fill("342.5");
    expect((await screen.locator(".card-bar").boundingBox())!.width).toBeCloseTo(342.5, 1);
    await done.click();
    await expect(screen.getByText("This screen: 4.00 pixels are 1 mm.")).toBeVisible();
    expect((await screen.locator(".projector-ruler").boundingBox())!.width).toBeCloseTo((100 * 342.5) / 85.6, 1);
    await expect.poll(() => drawn(screen)).toBeGreaterThan(50);
    await screen.reload();
    await expect(screen.getByText("This screen: 4.00 pixels are 1 mm."), "the screen is remembered").toBeVisible();
    expect(await smallTargets(screen)).toEqual([]);
    expect(await seriousFindings(screen)).toEqual([]);
  });

  await test.step("a projector", async () => {
    await screen.getByRole("button", { name: "Projector" }).click();
    await screen.getByRole("button", { name: "These tools to the other side" }).click();
    const points = trueLandmarks();
    const middle = [0, 1, 2].map((k) => Object.values(points).reduce((sum, point) => sum + point[k]!, 0) / Object.keys(points).length) as Vector;
    const left = cross(frame.up, frame.front);
    const eye = [0, 1, 2].map((k) => middle[k]! + 1400 * frame.front[k]! + 300 * left[k]! + 100 * frame.up[k]!) as Vector;
    const unit = (v: Vector): Vector => v.map((value) => value / Math.hypot(...v)) as Vector;
    const away = unit(middle.map((value, k) => value - eye[k]!) as Vector);
    const right = unit(cross(away, frame.up));
    const down = cross(away, right);
    const seen = (point: Vector): [number, number] => {
      const off = point.map((value, k) => value - eye[k]!) as Vector;
      return [500 + (1900 * dot(off, right)) / dot(off, away), 450 + (1900 * dot(off, down)) / dot(off, away)];
    };
    for (const [i, name] of ["suprasternal_notch", "nipple_L", "nipple_R", "acromion_L", "acromion_R", "umbilicus", "xiphoid"].entries()) {
      await expect(screen.getByText(i < 5 ? `${6 - i} more places are needed.` : i === 5 ? "One more place is needed." : /^6 places, off by/)).toBeVisible();
      await screen.mouse.click(...seen(points[name]!));
    }
    // The fit's landmarks are some millimetres from the true ones, so the residual is small and not nothing.
    const residual = await screen.getByText(/^7 places, off by/).textContent();
    const [, pixels, mm] = /off by ([\d.]+) px, ([\d.]+) mm/.exec(residual!)!;
    expect(Number(mm)).toBeLessThan(5);
    expect(Number(pixels) / Number(mm)).toBeCloseTo(1900 / 1434, 0);
    expect(await drawn(screen)).toBeGreaterThan(50);
    await screen.reload(); // what was clicked is still there
    await screen.getByRole("button", { name: "Projector" }).click();
    await expect(screen.getByText(residual!, { exact: true })).toBeVisible();
    await expect.poll(() => drawn(screen)).toBeGreaterThan(50);
    await screen.keyboard.press("h");
    await expect(screen.locator(".projector-tools")).toBeHidden();
    await expect(screen.locator(".projector-mark"), "it still says what it is").toBeVisible();
  });
  expect(troubles).toEqual([]);
});
