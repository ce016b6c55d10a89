// The states of drawing and of two stances, light and dark, on a desk and on a tablet: nothing that axe-core calls serious, nothing
// too small to press, no control over another, nothing beside the screen.
import { expect, type Page } from "@playwright/test";
import { overlaps, seriousFindings, smallTargets } from "./audit";
import { addToPlan, example, hook, test, thumb, untilFitted, untilStill } from "./page";
import { inTheme } from "./states";

async function fitted(page: Page): Promise<void> {
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.keyboard.press("1");
  await page.getByRole("button", { name: /^Fit with \d+ landmarks$/ }).first().click();
  await untilFitted(page);
}

const STATES: readonly { name: string; reach: (page: Page) => Promise<void> }[] = [
  {
    name: "pen",
    reach: async (page) => {
      await page.keyboard.press("3");
      await page.keyboard.press("p");
      await untilStill(page);
      const box = (await page.locator("canvas.view").boundingBox())!;
      for (const [x, y] of [[0.45, 0.5], [0.5, 0.42], [0.55, 0.5]] as const) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
      await expect(page.getByRole("button", { name: "End the line" })).toBeVisible();
    },
  },
  {
    name: "points",
    reach: async (page) => {
      await page.keyboard.press("e");
      await page.getByRole("button", { name: "Next point" }).click();
      await expect(page.getByRole("button", { name: "Delete point" })).toBeEnabled();
    },
  },
  {
    name: "pattern",
    reach: async (page) => {
      await page.keyboard.press("Escape");
      await page.keyboard.press("t");
      await addToPlan(page, /Wise/);
      await addToPlan(page, /^Tumour by the clock/);
    },
  },
  {
    name: "second scan",
    reach: async (page) => {
      await page.keyboard.press("Escape");
      await page.locator("#add-scan").click();
      await expect(page.getByRole("dialog")).toBeVisible();
    },
  },
  {
    name: "side by side",
    reach: async (page) => {
      await page.getByRole("dialog").getByRole("button", { name: /patient, supine/i }).click();
      await expect(page.getByRole("dialog")).toHaveCount(0);
      await fitted(page);
      await page.keyboard.press("3");
      await expect(page.getByText(/Transferred lines are (one|two|three) fingers? wide/)).toBeVisible();
      await thumb(page, "standing").click();
      await expect.poll(() => page.evaluate(() => window.__breastrig!.other() !== null)).toBe(true);
      await untilStill(page);
    },
  },
  {
    name: "measures",
    reach: async (page) => {
      await page.keyboard.press("4");
      await page.locator("#measures").click();
      await page.getByRole("dialog").locator(".measure-name").first().click();
    },
  },
];

const DESK = { width: 1280, height: 720 };
const TABLET = { width: 834, height: 1112 };

test("drawing and two stances can be read and pressed by everybody", async ({ page, base, troubles }) => {
  await page.goto(base);
  await example(page);
  await fitted(page);
  for (const { name, reach } of STATES) {
    await test.step(name, async () => {
      await inTheme(page, "light");
      await reach(page);
      expect.soft(await seriousFindings(page), `${name}: axe-core`).toEqual([]);
      for (const [device, viewport] of [["tablet", TABLET], ["desk", DESK]] as const) {
        await page.setViewportSize(viewport);
        await untilStill(page); // handles follow the picture
        expect.soft(await smallTargets(page), `${name}, ${device}: smaller than 24 pixels`).toEqual([]);
        expect.soft(await overlaps(page), `${name}, ${device}: controls over one another`).toEqual([]);
      }
      await inTheme(page, "dark");
      expect.soft(await seriousFindings(page, { runOnly: ["color-contrast"] }), `${name}: contrast in the dark`).toEqual([]);
    });
  }
  expect(troubles).toEqual([]);
});
