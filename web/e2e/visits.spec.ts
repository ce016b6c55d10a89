// Visits: two scans of one position get their days on the page, and what changed between them is said, drawn and plotted.
import { expect } from "@playwright/test";
import { seriousFindings } from "./audit";
import { fittedExample, hook, test } from "./page";

test("one scan brought twice, two days: nothing is said to have changed, and the plots follow the days", async ({ page, base, troubles }) => {
  await fittedExample(page, base, { stances: ["standing", "standing"] });
  await page.locator("#visits").click();
  const dialog = page.locator("dialog.visits");
  const sent: string[] = [];
  page.on("request", (request) => request.method() === "PUT" && request.url().endsWith("/visit") && sent.push(request.postData()!));
  await expect(dialog).toContainText("The day of a scan is missing");
  const rows = dialog.locator(".visit-scans li");
  await expect(rows).toHaveCount(2);
  for (const [i, day] of ["2026-03-01", "2026-09-01"].entries()) {
    await rows.nth(i).getByLabel("Day of the scan").focus();
    const [year, month, date] = day.split("-");
    await page.keyboard.type(`${month}${date}`);
    for (const digit of year!) {
      await page.keyboard.type(digit);
      await expect.poll(async () => (await hook.state(page)).stances.visits.isBusy, "answers come while the year is typed").toBe(false);
    }
    await expect(rows.nth(i).getByLabel("Day of the scan")).toBeFocused();
    await rows.nth(i).getByLabel("Name of the visit").focus();
    await expect.poll(async () => (await hook.state(page)).stances.visits.days?.filter(({ date }) => date !== null).length).toBe(i + 1);
    await expect.poll(async () => (await hook.state(page)).stances.visits.isBusy).toBe(false);
  }
  await expect(dialog.getByRole("heading", { level: 3 })).toHaveText(/^Standing: from 1 Mar 2026 to 1 Sept? 2026$/);
  for (const side of ["Left", "Right"]) await expect(dialog).toContainText(new RegExp(`${side} breast: no change of the skin beyond the band of \\d\\.\\d mm`));
  const width = (part: string): Promise<number> => dialog.locator(part).evaluate((image: HTMLImageElement) => (image.loading = "eager", image.decode().then(() => image.naturalWidth)));
  expect(await width("img.visit-plots")).toBeGreaterThan(100);
  expect(await width("img.visit-map")).toBeGreaterThan(100);
  await page.screenshot({ path: test.info().outputPath("visits.png") });
  await test.step("the map on the body: turned by hand and by keys, it says its numbers under the pointer", async () => {
    await dialog.getByRole("button", { name: "Turn the body" }).click();
    const body = dialog.getByRole("img", { name: /^Change of the skin on the body/ });
    await expect(body).toBeFocused();
    await expect(dialog.locator("img.visit-map")).toBeHidden();
    const letter = dialog.locator(".letter.side-left");
    const before = await letter.getAttribute("style");
    await body.press("ArrowRight");
    await expect(letter).not.toHaveAttribute("style", before!);
    const box = (await body.boundingBox())!;
    const said = dialog.locator(".hover-value");
    const sees = async (x: number, y: number): Promise<string> => {
      await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
      await expect(said).toBeVisible();
      return (await said.textContent())!;
    };
    const places: string[] = [];
    for (const x of [0.44, 0.47, 0.5, 0.53, 0.56]) places.push(await sees(x, 0.45));
    expect(places.join(" | ")).toMatch(/[+−]?0\.\d mm ?within the band of \d\.\d mm/);
    await page.screenshot({ path: test.info().outputPath("turned.png") });
    expect.soft(await seriousFindings(page)).toEqual([]);
  });
  const renamed = page.waitForResponse((answer) => answer.url().includes("/visits.svg"));
  await rows.nth(1).getByLabel("Name of the visit").fill("6 months");
  await rows.nth(1).getByLabel("Name of the visit").press("Tab");
  expect(await (await renamed).text(), "the plot is drawn anew, not taken from the browser's memory").toContain("6 months");
  await expect(dialog.getByRole("heading", { level: 3 })).toHaveText(/^Standing: from 1 Mar 2026 to 1 Sept? 2026, 6 months$/);
  await test.step("half a day beside a new name is asked for; no day is taken away", async () => {
    const before = sent.length;
    await rows.nth(0).getByLabel("Day of the scan").focus();
    await page.keyboard.press("Backspace"); // its month
    await rows.nth(0).getByLabel("Name of the visit").fill("before");
    await rows.nth(0).getByLabel("Name of the visit").press("Enter");
    await expect(rows.nth(0).getByLabel("Day of the scan")).toBeFocused();
    expect(sent.length).toBe(before);
    await page.keyboard.type("03");
    await expect.poll(async () => (await hook.state(page)).stances.visits.days?.map(({ label }) => label)).toContain("before");
  });
  expect(sent.filter((each) => !each.includes('"2026-')), "no year is taken before it is whole").toEqual([]);
  expect(troubles).toEqual([]);
});
