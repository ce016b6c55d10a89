// Which model a scan is brought for: a word of the sentence, and everything after goes by it.
import { expect } from "@playwright/test";
import { hook, SCAN_FILE, test } from "./page";

test("a man's scan is brought for the chest of a man, and a woman's again for a woman's torso", async ({ page, base, troubles }) => {
  await page.goto(base);
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  const model = page.locator("[popovertarget=model-word]");
  await expect(model).toHaveText("a woman?");
  await model.click();
  await page.getByRole("button", { name: "Chest of a man" }).click();
  await expect(model).toHaveText("a man");
  await hook.ready(page);
  await page.keyboard.press("2");
  const his = page.locator(".landmark .label-text", { hasText: "lower border of the chest muscle" });
  await expect(his).toHaveCount(2);
  await page.reload(); // the address names the scan, and the scan its model
  await hook.ready(page);
  await page.keyboard.press("2");
  await expect(his).toHaveCount(2);
  await page.getByRole("button", { name: "All patients" }).click();
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await expect(model, "as it was chosen last").toHaveText("a man");
  await model.click();
  await page.getByRole("button", { name: "Torso of a woman" }).click();
  await expect(model).toHaveText("a woman");
  await page.reload();
  await hook.ready(page);
  await expect(model, "the answer is kept").toHaveText("a woman");
  await page.keyboard.press("2");
  await expect(page.locator(".landmark .label-text", { hasText: "fold under the breast" })).toHaveCount(2);
  await expect(his).toHaveCount(0);
  expect(troubles).toEqual([]);
});
