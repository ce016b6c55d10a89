// Which model a scan is brought for: chosen beside the file, and everything after goes by it.
import { expect } from "@playwright/test";
import { hook, SCAN_FILE, test } from "./page";

test("a man's scan is brought for the chest of a man, and a woman's again for a woman's torso", async ({ page, base, troubles }) => {
  await page.goto(base);
  const model = page.getByRole("combobox", { name: "Model" });
  await expect(model.locator("option")).toHaveText(["Torso of a woman", "Chest of a man"]);
  await model.selectOption("male");
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await page.getByRole("button", { name: "Size and direction are right" }).click();
  const his = page.locator(".landmark .label-text", { hasText: "lower border of the chest muscle" });
  await expect(his).toHaveCount(2);
  await page.reload(); // the address names the scan, and the scan its model
  await hook.ready(page);
  await page.keyboard.press("2");
  await expect(his).toHaveCount(2);
  await page.goto(base);
  await expect(model).toHaveValue("torso");
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await page.keyboard.press("2");
  await expect(page.locator(".landmark .label-text", { hasText: "fold under the breast" })).toHaveCount(2);
  await expect(his).toHaveCount(0);
  expect(troubles).toEqual([]);
});
