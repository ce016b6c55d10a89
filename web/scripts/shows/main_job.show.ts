// The main job as a person does it, by clicks, with a clock: from the page's address to the fitted result with its drawing.
import { test } from "@playwright/test";
import { hook, trueLandmarks, untilFitted, untilStill } from "../../e2e/page";

for (const way of ["twelve clicks on the body", "proposals, confirmed at once"] as const) {
  test(way, async ({ page }) => {
    const begun = performance.now();
    const laps: string[] = [];
    const lap = (what: string): void => void laps.push(`${what} ${((performance.now() - begun) / 1000).toFixed(1)} s`);
    await page.goto(process.env.BREASTRIG_E2E_BASE!);
    await page.getByRole("button", { name: /standing/i }).click();
    await hook.ready(page);
    lap("scan drawn");
    await page.getByRole("button", { name: /^Landmarks/ }).click();
    await page.locator("[data-proposed]").first().waitFor({ state: "attached" });
    lap("landmarks proposed");
    if (way === "twelve clicks on the body") {
      for (const [name, point] of Object.entries(trueLandmarks())) {
        await page.locator(`.landmarks [data-landmark=${name}] .landmark-name`).click();
        await untilStill(page);
        const { x, y } = await hook.project(page, point);
        await page.mouse.click(x, y);
      }
    } else {
      await page.getByRole("button", { name: "Fit as proposed" }).waitFor();
    }
    lap(`${await hook.pickCount(page)} landmarks placed`);
    await page.getByRole("button", { name: /^Fit (with \d+ landmarks|as proposed)$/ }).click();
    await page.waitForFunction(() => (window.__breastrig!.state().fit?.shown ?? -1) >= 0);
    lap("model on the scan");
    await untilFitted(page);
    lap("fitted, with drawing");
    console.log(`${way}: ${laps.join(", ")}`);
  });
}
