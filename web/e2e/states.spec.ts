// Every state of the page, light and dark: nothing that axe-core calls serious, nothing too small to press, no control
// over another.
import { expect } from "@playwright/test";
import { overlaps, paleControls, scrolledAway, seriousFindings, smallTargets } from "./audit";
import { test } from "./page";
import { holdFits, inTheme, STATES } from "./states";

test("each state can be read and pressed by everybody, in light and dark", async ({ page, base, troubles }) => {
  await holdFits(page);
  for (const { name, reach } of STATES) {
    await test.step(name, async () => {
      await inTheme(page, "light");
      await reach(page, base);
      expect.soft(await seriousFindings(page), `${name}: axe-core`).toEqual([]);
      expect.soft(await smallTargets(page), `${name}: smaller than 24 pixels`).toEqual([]);
      expect.soft(await overlaps(page), `${name}: controls over one another`).toEqual([]);
      expect.soft(await scrolledAway(page), `${name}: off the screen at 1280 x 720`).toEqual([]);
      expect.soft(await paleControls(page), `${name}: outlines under 3 : 1`).toEqual([]);
      await inTheme(page, "dark");
      expect.soft(await paleControls(page), `${name}: outlines under 3 : 1 in the dark`).toEqual([]);
      expect.soft(await seriousFindings(page, { runOnly: ["color-contrast"] }), `${name}: contrast in the dark`).toEqual([]);
    });
  }
  await test.step("the checks themselves can fail", async () => {
    await page.evaluate(() => {
      const title = document.querySelector("h1")!;
      title.style.color = "rgb(160 160 160)";
      title.style.backgroundColor = "rgb(120 120 120)";
      document.querySelector<HTMLElement>(".view-bar .button")!.style.minHeight = "8px";
      document.querySelector<HTMLElement>(".view-bar .button")!.style.height = "8px";
    });
    expect(await seriousFindings(page, { runOnly: ["color-contrast"] })).toHaveLength(1);
    expect(await smallTargets(page)).toHaveLength(1);
    await page.evaluate(() => document.documentElement.style.setProperty("--line-strong", "transparent"));
    expect((await paleControls(page)).length).toBeGreaterThan(0);
  });
  expect(troubles).toEqual([]);
});
