// A German surgeon's day: the page is German because the browser is, decimals have a comma, nothing English is left and every
// word fits; the other language is a click away and back, for whoever visits a link as well.
import { expect, type Page } from "@playwright/test";
import { word } from "../src/languages/words";
import { expectGerman } from "./german";
import { addToPlan, details, hook, numberField, openShare, planItem, test, untilFitted } from "./page";
import { holdFits, STATES } from "./states";
import { said, speakIn } from "./words";

test.use({ locale: "de-DE" });
test.beforeAll(() => speakIn("de"));
test.afterAll(() => speakIn("en")); // for the next file of this worker

const { state } = hook;
const language = (page: Page) => page.evaluate(() => document.documentElement.lang);

async function write(page: Page, name: string, value: string): Promise<void> {
  await numberField(page, name).fill(value);
  await numberField(page, name).press("Tab");
}

test("a day in German: scan, landmarks, fit, plan, second scan, measures, hand over, a link, and the other language", async ({ page, base, troubles }, info) => {
  test.slow(); // a whole day
  const look = (name: string) => expectGerman(page, name, process.env.BREASTRIG_SHOW_FOLDER ? (screen) => `${process.env.BREASTRIG_SHOW_FOLDER}/${name}_${screen}.png` : undefined);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await holdFits(page);
  for (const { name, reach } of STATES.filter((each) => each.name !== "shared viewer")) {
    await test.step(name, async () => {
      await reach(page, base);
      await look(name);
    });
  }
  expect(await language(page)).toBe("de");
  await page.keyboard.press("Escape");

  await test.step("the plan: a pattern and a tumour by the clock, numbers with a comma", async () => {
    await page.keyboard.press("3");
    await addToPlan(page, /Wise/);
    await addToPlan(page, new RegExp(`^${word("drawing.panel.planPanel.clock")}`));
    await expect(details(page).locator("[data-parameter=side]").last()).toBeVisible();
    await details(page).locator("[data-parameter=side]").last().selectOption("L");
    await write(page, "clock", "10:30");
    await write(page, "distance_mm", "1.234");
    await expect(page.getByText("lässt sich auf zwei Arten lesen")).toBeVisible();
    await look("unclear number");
    await write(page, "distance_mm", "40,5");
    await write(page, "radius_mm", "15");
    await expect.poll(async () => (await state(page)).drawing).toBe("reduction+tumour:side=L,clock=10.5,distance_mm=40.5,radius_mm=15");
    await expect(numberField(page, "distance_mm")).toHaveValue("40,5");
    await look("tumour");
    await planItem(page, "Wise").click();
    await look("pattern");
  });

  await test.step("the second scan, onto which the plan is carried", async () => {
    await page.locator("#add-scan").click();
    await look("second scan");
    await page.locator(".stances-dialog .choices .button.outlined").nth(1).click();
    await expect(page.getByRole("dialog")).toHaveCount(0);
    await hook.ready(page);
    await page.keyboard.press("1");
    await page.getByRole("button", { name: /^Anpassen (mit|ohne)/ }).first().click();
    await untilFitted(page);
    await page.keyboard.press("3");
    await expect(page.getByText(/Übertragene Linien sind (einen|zwei|drei) Finger breit/)).toBeVisible();
    await look("carried");
    await page.locator(".thumb[data-stance=standing]").click();
    await look("side by side");
    await page.locator("#visits").click();
    await expect(page.getByRole("dialog", { name: said("stances.visits.title") }).getByText(word("stances.visits.none"))).toBeVisible();
    await look("visits");
    await page.keyboard.press("Escape");
  });

  await test.step("measures, and what is handed over", async () => {
    await page.keyboard.press("4");
    await page.locator("#measures").click();
    const table = page.getByRole("dialog", { name: said("stances.measures.table.title") });
    await expect(table.locator("thead .group[colspan]")).toHaveText(["Stehend", "Rückenlage", "Änderung: Rückenlage − Stehend"]);
    await expect(table.locator("tbody td").filter({ hasText: /^−?\d+,\d/ }).first(), "decimals with a comma").toBeVisible();
    await look("measures");
    await page.keyboard.press("Escape");
    await expect(page.locator(".paper img")).not.toHaveCount(0);
    await look("hand over");
  });

  await test.step("the other language is a click away, keeps everything, and so is the way back", async () => {
    const before = await state(page);
    const change = async (name: string): Promise<void> => {
      await page.locator("[popovertarget=page-menu]").click();
      await Promise.all([page.waitForEvent("load"), page.locator("#page-menu").getByRole("button", { name, exact: true }).click()]);
      await page.evaluate(() => (window as unknown as { releaseFit: () => void }).releaseFit());
      await hook.ready(page);
      await untilFitted(page);
    };
    await page.keyboard.press("3");
    await change("English");
    expect(await language(page)).toBe("en");
    await expect(page.locator("#tab-body")).toHaveText("Body");
    const [cookie] = (await page.context().cookies()).filter(({ name }) => name === "breastrig_language");
    expect(cookie).toMatchObject({ value: "en", path: "/", sameSite: "Strict" });
    expect((await state(page)).drawing).toBe(before.drawing);
    await change("Deutsch");
    expect(await language(page)).toBe("de");
    await expect(page.locator("#tab-body")).toHaveText("Körper");
  });

  await test.step("a visitor of a link", async () => {
    await openShare(page);
    await page.getByRole("dialog").getByRole("button", { name: said("share.make") }).click();
    const address = page.getByLabel(word("share.link"));
    await expect(address).toHaveValue(/\/s#/);
    await page.goto(await address.inputValue());
    await expect(page.getByText(word("share.shared.what"))).toBeVisible();
    await look("shared viewer");
    await Promise.all([page.waitForEvent("load"), page.getByRole("button", { name: "English", exact: true }).click()]);
    await expect(page.getByText("This result was shared with you")).toBeVisible();
    expect(await language(page)).toBe("en");
  });
  expect(troubles).toEqual([]);
  expect(info.errors).toEqual([]);
});
