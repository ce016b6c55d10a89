// Files that are refused, landmark files, Back and Forward, what is not saved.
import { writeFileSync } from "node:fs";
import { expect } from "@playwright/test";
import { example, fittedExample, hook, more, SCAN_FILE, test, until, untilFitted, withoutEndOfTime } from "./page";

test.use({ contextOptions: { reducedMotion: "no-preference" } }); // with its motion, as most people see it

test("a file that is no scan is refused with the service's own sentence, and a good one still goes in", async ({ page, base }, info) => {
  const bad = info.outputPath("bad.ply");
  writeFileSync(bad, "this is no mesh\n");
  await page.goto(base);
  const refused = page.waitForResponse((answer) => answer.url().endsWith("/api/scans") && answer.status() >= 400);
  await page.locator("#scan-file").setInputFiles(bad);
  const { detail } = (await (await refused).json()) as { detail: string };
  await expect(page.getByRole("alert").filter({ hasText: detail })).toBeVisible();
  const text = info.outputPath("notes.doc");
  writeFileSync(text, "no scan at all\n");
  await page.locator("#scan-file").setInputFiles(text);
  await expect(page.getByRole("alert").filter({ hasText: "This file is no 3D scan that can be read" })).toBeVisible();
  await page.locator("#scan-file").setInputFiles(SCAN_FILE);
  await hook.ready(page);
  await expect(page.getByRole("alert").filter({ visible: true })).toHaveCount(0);
  await page.getByRole("button", { name: "More" }).click();
  await expect(page.locator("#page-menu")).toBeVisible();
  await page.keyboard.press("Escape");
  await expect(page.locator("#page-menu")).toBeHidden();
});

test("the landmarks are saved in the four kinds that the page and other programs read", async ({ page, base, troubles }, info) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  for (const name of ["landmarks.json", "landmarks.csv", "landmarks.pp", "landmarks.mrk.json"]) {
    await page.getByRole("button", { name: "Save the placed landmarks" }).click();
    const menu = page.getByRole("group", { name: "Save the placed landmarks" });
    await expect(menu).toBeInViewport({ ratio: 1 });
    if (name === "landmarks.json") await page.screenshot({ path: info.outputPath("menu.png") });
    const [download] = await Promise.all([page.waitForEvent("download"), menu.getByRole("button", { name }).click()]);
    expect(download.suggestedFilename()).toMatch(new RegExp(`^[A-Z0-9]{3}-[A-Z0-9]{3}_standing_\\d{4}-\\d{2}-\\d{2}_${name}$`));
    await expect(menu).toBeHidden();
    const file = await download.path();
    const copy = info.outputPath(name);
    await download.saveAs(copy);
    await page.locator("#landmark-file").setInputFiles(copy);
    expect(await hook.pickCount(page), file).toBe(12);
  }
  expect(troubles).toEqual([]);
});

test("Back and Forward go through patient and steps and stay in the page; a deleted scan can be taken back", async ({ page, base, troubles }) => {
  const open = page.locator(".side-body:visible");
  await withoutEndOfTime(page);
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await expect(page).toHaveURL(/step=body/);
  await page.keyboard.press("2");
  await expect(page).toHaveURL(/step=points/);
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.keyboard.press("3");
  await expect(open).toHaveAttribute("id", "side-plan");
  await expect(page).toHaveURL(/step=plan/);
  for (const step of ["points", "body"]) {
    await page.goBack();
    await expect(open).toHaveAttribute("id", `side-${step}`);
  }
  await page.goBack();
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  await page.goForward();
  await hook.ready(page);
  await expect(open).toHaveAttribute("id", "side-body");
  await page.goForward();
  await expect(open).toHaveAttribute("id", "side-points");
  expect(await hook.pickCount(page)).toBe(12);
  await page.reload();
  await hook.ready(page);
  await expect(open).toHaveAttribute("id", "side-points");
  await page.getByRole("button", { name: "All patients" }).click();
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  await page.goBack();
  await hook.ready(page);
  expect(await hook.pickCount(page)).toBe(12);

  await page.keyboard.press("1");
  const links = await page.evaluate(() => window.__breastrig!.state().scan!.info.links);
  await more(page, "Delete this scan …");
  const question = page.getByRole("dialog", { name: "Delete this scan?" });
  await expect(question).toContainText("12 landmarks");
  await page.keyboard.press("Escape");
  await expect(question).toBeHidden();
  await more(page, "Delete this scan …");
  await question.getByRole("button", { name: "Delete", exact: true }).click();
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  await page.getByRole("button", { name: "Take it back" }).click();
  await hook.ready(page);
  expect(await hook.pickCount(page)).toBe(12);
  await page.keyboard.press("1");
  await more(page, "Delete this scan …");
  await question.getByRole("button", { name: "Delete", exact: true }).click();
  expect((await page.request.get(base + links.self)).status(), "not yet").toBe(200);
  await page.goto("about:blank"); // the page is left: the service is told at once
  await expect.poll(async () => (await page.request.get(base + links.self)).status()).toBe(404);
  expect(troubles).toEqual([]);
});

test("landmarks that the service does not take are asked about before another patient, and nothing is lost by staying", async ({ page, base }) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  await expect(page).toHaveURL(/step=body/);
  await page.keyboard.press("2");
  await expect(page).toHaveURL(/step=points/);
  const refuse = { status: 507, contentType: "application/problem+json", body: JSON.stringify({ title: "Full", detail: "The disk is full.", status: 507 }) };
  await page.route("**/landmarks", (route) => (route.request().method() === "PUT" ? route.fulfill(refuse) : route.fallback()));
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  await page.getByRole("button", { name: "All patients" }).click();
  const question = page.getByRole("dialog", { name: "Not everything is saved" });
  await expect(question).toContainText("The landmarks of this scan could not be saved");
  await page.keyboard.press("Escape");
  await expect(question).toBeHidden();
  expect(await hook.pickCount(page)).toBe(12);
  await page.goBack();
  await expect(page).toHaveURL(/step=body/);
  await page.goBack();
  await expect(question, "Back does not leave them either").toBeVisible();
  await page.unroute("**/landmarks");
  await question.getByRole("button", { name: "Save again" }).click();
  await expect(page.getByText("Drop the patient's scans anywhere on this page")).toBeVisible();
  await page.goForward();
  await hook.ready(page);
  expect(await hook.pickCount(page)).toBe(12);
});

test("who goes to another step while the second scan is still on its way stays there", async ({ page, base, troubles }) => {
  const [, second] = await fittedExample(page, base, { stances: ["standing", "supine"] });
  let release!: () => void;
  const held = new Promise<void>((done) => (release = done));
  await page.route(`**/api/scans/${second!.scan.id}`, async (route) => held.then(() => route.continue()));
  await page.reload();
  await hook.ready(page);
  await untilFitted(page);
  expect((await hook.state(page)).step, "as the address says").toBe("plan");
  await page.locator("#tab-handover").click();
  release();
  await until(page, () => window.__breastrig!.state().stances.other);
  await expect.poll(() => page.evaluate(() => location.hash)).toContain("step=handover");
  expect((await hook.state(page)).step).toBe("handover");
  expect(troubles).toEqual([]);
});
