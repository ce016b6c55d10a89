// Pictures of every state of the page: light and dark, desktop and tablets.  BREASTRIG_SHOW_STATES: names, by commas; BREASTRIG_SHOW_LANGUAGE: de.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { holdFits, STATES } from "../../e2e/states";
import { choose, type Language, speakIn } from "../../e2e/words";

const SCREENS = {
  desktop: { viewport: { width: 1280, height: 720 } },
  tablet: { viewport: { width: 1024, height: 768 }, hasTouch: true },
  upright: { viewport: { width: 820, height: 1180 }, hasTouch: true },
} as const;

const wanted = (process.env.BREASTRIG_SHOW_STATES ?? "").split(",").filter((name) => name !== "");
const language = (process.env.BREASTRIG_SHOW_LANGUAGE ?? "en") as Language;
speakIn(language);
const screens = (process.env.BREASTRIG_SHOW_SCREENS ?? "desktop,tablet,upright").split(",") as (keyof typeof SCREENS)[];

for (const screen of screens) {
  test(screen, async ({ browser }) => {
    const folder = join(process.env.BREASTRIG_SHOW_FOLDER!, screen);
    mkdirSync(folder, { recursive: true });
    const page = await (await browser.newContext({ ...SCREENS[screen], reducedMotion: "reduce" })).newPage();
    await holdFits(page);
    await choose(page, process.env.BREASTRIG_E2E_BASE!, language);
    for (const [i, { name, reach }] of STATES.entries()) {
      await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
      await reach(page, process.env.BREASTRIG_E2E_BASE!);
      if (wanted.length > 0 && !wanted.includes(name)) continue;
      for (const colorScheme of ["light", "dark"] as const) {
        await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
        await page.mouse.move(2, 2);
        await page.waitForTimeout(250);
        await page.screenshot({ path: join(folder, `${String(i + 1).padStart(2, "0")}_${name.replaceAll(" ", "_")}_${colorScheme}.png`) });
      }
    }
    expect(await page.title()).not.toBe("");
  });
}
