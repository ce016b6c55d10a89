// docs/tutorials/surgeon.md as a person follows it: the spec looks at each step, scripts/shows/pictures.show.ts takes its pictures.
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import { addToPlan, details, planItem, thumb, until, untilStill } from "./page";
import { REPOSITORY } from "./service";

/** The examples as they ship: the browser tests' own are coarser, and only two. */
export const SHIPPED = { BREASTRIG_E2E_EXAMPLES: join(REPOSITORY, "model_assets/example") };

export const STEPS = ["body", "lines", "check", "plan", "lesion", "slices", "handover"] as const;

/** `seen`: called when a step is done, with what there is to see on the screen. */
export async function followTutorial(page: Page, base: string, seen: (step: (typeof STEPS)[number]) => Promise<void>): Promise<void> {
  const next = page.locator("#next");
  await page.goto(base);
  await page.getByRole("button", { name: "Try the example" }).click();
  await page.getByRole("button", { name: "All scans of the example patient" }).click();
  await expect(page.locator(".thumb .thumb-name")).toHaveText([/^Standing/, /^Supine/, /^MRI/]);
  await until(page, () => {
    const { fit, stances } = window.__breastrig!.state();
    return fit?.state === "done" && !fit.playing && stances.other?.fit?.state === "done";
  });
  await expect(page.locator(".sentence")).toHaveText(/^Standing\s?,\s?a woman\?\s?,\s?53\scm tall\s?,\s?facing you$/, { useInnerText: true });
  const found = page.getByRole("region", { name: "Lines found on the skin" });
  await expect(found.getByRole("button", { name: "Accept 8 lines" })).toBeVisible();
  await seen("body");

  for (const short of ["Violet line 7", "Violet line 6"]) await found.getByRole("button", { name: `Drop ${short}` }).click();
  const name = found.getByRole("textbox", { name: "Name of Violet closed line 1" });
  await name.fill("Tumour");
  await name.press("Enter");
  await found.getByRole("button", { name: "Accept 6 lines" }).click();
  await expect(found).toContainText("All lines found on the skin are decided.");
  await expect(page.locator(".verdict-level")).toHaveText("One point first");
  await seen("lines");

  await expect(next).toHaveText(/^Check 1 point/);
  await next.click();
  await expect(page.locator(".check-card")).toContainText(/Middle of the breastbone.*Is the dot there\?/s);
  await seen("check");
  await page.getByRole("button", { name: /^Yes, it is here/ }).click();
  await until(page, () => window.__breastrig!.state().checks.outcome);
  await expect(page.getByText(/The lines have narrowed: they were .* and are/).first()).toBeAttached();
  await untilStill(page);
  await expect(page.locator(".verdict-level")).toHaveText(/^(Ready to draw|Draw with lines one finger wide)$/);

  await expect(next).toHaveText("Draw the plan");
  await next.click();
  await addToPlan(page, /^Reduction \(Wise pattern\)/);
  await expect(planItem(page, "Wise")).toBeVisible();
  await expect(planItem(page, "Lesion 1")).toContainText(/mm deep/);
  const areola = details(page).locator('[data-side="L"] [data-parameter=areola_mm]');
  await areola.fill("40");
  await areola.press("Tab");
  await expect(page.getByText(/^The plan is shown on the standing and supine scans/)).toBeVisible();
  await expect(details(page)).toContainText("Dashed:");
  await seen("plan");

  await planItem(page, "Lesion 1").click();
  await expect(page.locator(".lesion-view")).toContainText("To the nipple");
  await seen("lesion");
  await thumb(page, "image").click();
  await expect(thumb(page, "image")).toHaveAttribute("aria-pressed", "true");
  await expect(page.locator(".slice .slice-ball").first()).toBeVisible();
  await seen("slices");

  await thumb(page, "supine").click();
  await expect(thumb(page, "supine")).toHaveAttribute("aria-pressed", "true");
  await page.getByRole("button", { name: "Hand over" }).click();
  await expect(page.getByRole("region", { name: "Before you print" })).toContainText("Supine");
  await expect(page.getByRole("img", { name: /^Page 1 of/ })).toBeVisible();
  await seen("handover");
}
