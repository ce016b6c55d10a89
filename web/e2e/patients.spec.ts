// The first page: patients under codes, opened where their work was left, deleted with ten seconds to take it back.
import { expect } from "@playwright/test";
import { hook, test, withoutEndOfTime } from "./page";

interface Scan {
  id: string;
  patient: string;
}

test("a patient is renamed, found, opened, left by Back, and deleted after a second thought", async ({ page, base, troubles }) => {
  const add = async (): Promise<Scan> => (await (await page.request.post(`${base}/api/examples/standing`)).json()) as Scan;
  const [first, second] = [await add(), await add()];
  await withoutEndOfTime(page);
  await page.goto(base);
  const row = (scan: Scan) => page.locator(`[data-patient="${scan.patient}"]`);
  await expect(row(first)).toBeVisible();
  await expect(row(first).locator("img")).toHaveJSProperty("naturalWidth", 144);
  const more = async (code: RegExp | string, what: string): Promise<void> => {
    await row(first).getByRole("button", { name: code }).click();
    await row(first).getByRole("button", { name: what }).click();
  };
  await more(/^More about /, "Change the code");
  await add(); // one more card, above hers
  const planned = await page.request.put(`${base}/api/patients/${first.patient}/plan`, { headers: { "If-Match": '"0"' }, data: { schema: "breastrig/plan@1", unit: "mm", items: [] } });
  expect(planned.ok(), await planned.text()).toBe(true);
  const listed = page.waitForResponse((answer) => answer.url().includes("/api/patients?"));
  await page.locator(".home-head select").evaluate((order: HTMLSelectElement) => {
    order.selectedIndex = 1;
    order.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await listed; // her row has changed while a code is typed in it: it stays
  await row(first).getByLabel("Code, never a name").fill("Ward 7 / 3");
  await row(first).getByLabel("Code, never a name").press("Tab");
  await expect.poll(async () => ((await (await page.request.get(`${base}/api/patients/${first.patient}`)).json()) as { code: string }).code).toBe("Ward 7 / 3");
  await page.reload();
  await page.getByLabel("Find a code").fill("ward 7");
  await expect(row(second)).toHaveCount(0);
  await expect(row(first).getByRole("link", { name: "Ward 7 / 3" })).toBeVisible();

  await row(first).getByRole("link", { name: "Ward 7 / 3" }).click();
  await hook.ready(page);
  expect((await hook.state(page)).scan!.info.id).toBe(first.id);
  await page.goBack();
  await expect(row(first)).toBeVisible();

  const status = async (): Promise<number> => (await page.request.get(`${base}/api/patients/${first.patient}`)).status();
  await more("More about Ward 7 / 3", "Delete this patient …");
  await expect(row(first)).toContainText("1 scan with landmarks, fits, plan, reports and every link");
  const again = page.waitForResponse((answer) => answer.url().includes("/api/patients?"));
  await page.locator(".home-head select").selectOption({ index: 0 });
  await again;
  await expect(row(first), "what is asked stays asked when the list comes again").toContainText("1 scan with landmarks");
  await row(first).getByRole("button", { name: "Delete", exact: true }).click();
  await expect(row(first)).toContainText("will be deleted in ten seconds");
  expect(await status()).toBe(200);
  await row(first).getByRole("button", { name: "Take it back" }).click();
  await more("More about Ward 7 / 3", "Delete this patient …");
  await row(first).getByRole("button", { name: "Delete", exact: true }).click();
  await page.close({ runBeforeUnload: true }); // leaving the page sends what waits
  await expect.poll(status).toBe(404);
  expect(troubles).toEqual([]);
});
