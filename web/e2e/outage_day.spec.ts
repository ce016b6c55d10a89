// The outage's day: the service, or the way to it, goes away while landmarks, a line, a pattern with its numbers, a tumour and
// notes are entered, and comes back; the session ends; the page is reloaded in between; another tab works on the same patient.
// Nothing is lost, all of it is saved without a click, and the page says so where somebody looks.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, type Page } from "@playwright/test";
import type { StoredPlan, Vector } from "../src/api/types";
import { seriousFindings } from "./audit";
import { addToPlan, details, example, hook, numberField, planItem, test, trueLandmarks, until } from "./page";
import { type Running, startService } from "./service";

const TOKEN = "a-token-of-more-than-sixteen-characters";
let service: Running;
let folder: string;

test.use({ base: async ({}, use) => use(service.base) });
test.beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
  service = await startService({ BREASTRIG_TOKEN: TOKEN }, [], folder);
});
test.afterAll(async () => {
  await service.stop();
  rmSync(folder, { recursive: true, force: true });
});

const comeBack = async (): Promise<void> => {
  service = await startService({ BREASTRIG_TOKEN: TOKEN }, [], folder, new URL(service.base).port);
};

async function ask<Body>(path: string): Promise<Body> {
  const answer = await fetch(service.base + path, { headers: { Authorization: `Bearer ${TOKEN}` } });
  expect(answer.ok, path).toBe(true);
  return (await answer.json()) as Body;
}

async function signIn(page: Page): Promise<void> {
  await page.getByLabel("Access token").fill(TOKEN);
  await page.getByRole("button", { name: "Sign in" }).click();
}

async function opened(page: Page, base: string): Promise<{ scan: string; plan: string }> {
  await page.goto(base);
  await signIn(page);
  await example(page);
  await hook.ready(page);
  return page.evaluate(() => {
    const { id, links } = window.__breastrig!.state().scan!.info;
    return { scan: id, plan: links.plan };
  });
}

const bar = (page: Page) => page.locator(".unsaved-bar");

/** Clicks on a place of the body, scan's frame. */
async function click(page: Page, place: Vector): Promise<void> {
  const { x, y } = await hook.project(page, place);
  await page.mouse.click(x, y);
}

const isInView = (page: Page) =>
  bar(page).evaluate((element) => {
    const { left, top, right, bottom } = element.getBoundingClientRect();
    const middle = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    return left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight && element.contains(middle);
  });

interface Typed {
  readonly areola: string;
  readonly clock: string;
  readonly notes: string;
}

/** Pattern, its number, the tumour, its depth, notes. */
async function type(page: Page, { areola, clock, notes }: Typed, isLast = "leave the field"): Promise<void> {
  await page.keyboard.press("3");
  await page.keyboard.press("Escape");
  const panel = details(page);
  if ((await planItem(page, "Wise").count()) === 0) await addToPlan(page, /Wise/);
  else if ((await planItem(page, "Wise").getAttribute("aria-pressed")) === "false") await planItem(page, "Wise").click();
  await numberField(page, "areola_mm").fill(areola);
  await numberField(page, "areola_mm").press("Tab");
  if ((await planItem(page, "Tumour").count()) === 0) await addToPlan(page, /^Tumour by the clock/);
  else await planItem(page, "Tumour").click();
  await panel.locator("[data-parameter=side]:visible").last().selectOption("L");
  for (const [name, value] of [["clock", clock], ["distance_mm", "45"], ["radius_mm", "12"]] as const) {
    await numberField(page, name).fill(value);
    await numberField(page, name).press("Tab");
  }
  await panel.locator("[data-parameter=depth_mm]:visible").fill("21");
  await panel.locator("[data-parameter=depth_mm]:visible").press("Tab");
  await toNotes(page);
  await panel.getByLabel("Notes").fill(notes);
  if (isLast === "leave the field") await panel.getByLabel("Notes").press("Tab");
}

async function toNotes(page: Page): Promise<void> {
  if (!(await details(page).getByLabel("Notes").isVisible())) await addToPlan(page, /^Note/);
}

/** What the service has of it. */
async function kept(scan: string, plan: string) {
  const [{ items }, { landmarks }] = await Promise.all([ask<StoredPlan>(plan), ask<{ landmarks: Record<string, Vector> }>(`/api/scans/${scan}/landmarks`)]);
  const said = <Value>(say: (item: StoredPlan["items"][number]) => Value | null): Value[] => items.map(say).filter((each) => each !== null);
  return {
    landmarks: Object.keys(landmarks).sort(),
    lines: items.filter(({ kind }) => kind === "line").length,
    patterns: said((item) => (item.kind === "pattern" ? [item.name, item.parameters?.areola_mm] : null)),
    tumours: said((item) => (item.kind === "tumour" ? [item.clock, item.distance_mm, item.radius_mm, item.depth_mm] : null)),
    notes: said((item) => (item.kind === "note" ? item.text : null)),
  };
}

const inBrowser = (page: Page) => page.evaluate(() => Object.keys(sessionStorage).filter((key) => key.startsWith("breastrig.unsaved")).length + Object.keys(localStorage).filter((key) => key !== "breastrig.fits-at-once").length);

test("the service is killed while everything is entered, and comes back: all of it is saved without a click", async ({ page, base }) => {
  const { scan, plan } = await opened(page, base);
  await page.keyboard.press("3");
  await service.stop();
  const at = trueLandmarks();
  await page.keyboard.press("2");
  for (const name of ["suprasternal_notch", "xiphoid"] as const) {
    await page.locator(`[data-landmark=${name}] button`).first().click();
    await click(page, at[name]!);
  }
  await expect.poll(() => hook.pickCount(page)).toBe(2);
  await page.keyboard.press("3");
  await page.keyboard.press("p");
  await click(page, at.xiphoid!);
  await click(page, at.umbilicus!);
  await page.keyboard.press("Enter");
  await type(page, { areola: "41", clock: "10:30", notes: "Wants it smaller, left more than right." });

  await expect(bar(page)).toBeVisible();
  await expect(bar(page)).toContainText("Not saved yet");
  await expect(bar(page)).toContainText("kept in this tab");
  expect(await isInView(page)).toBe(true);
  await page.evaluate(() => document.querySelector(".side-foot")!.scrollIntoView());
  expect(await isInView(page), "however the page is scrolled").toBe(true);
  expect(await bar(page).locator("xpath=..").getAttribute("aria-live")).toBe("polite");
  expect(await seriousFindings(page)).toEqual([]);
  expect(await inBrowser(page)).toBe(2);

  await comeBack();
  const all = { landmarks: ["suprasternal_notch", "xiphoid"], lines: 1, patterns: [["reduction", 41]], tumours: [[10.5, 45, 12, 21]], notes: ["Wants it smaller, left more than right."] };
  await expect.poll(() => kept(scan, plan)).toEqual(all);
  await expect(bar(page)).toBeHidden();
  expect(await inBrowser(page), "nothing of a patient stays in the browser").toBe(0);
  await page.reload();
  await hook.ready(page);
  expect(await page.evaluate(() => window.__breastrig!.state().drawn.note)).toBe(all.notes[0]);
});

test("a reload in the middle of it, also of what stands in a field that was not left yet", async ({ page, context, base }) => {
  const { scan, plan } = await opened(page, base);
  await context.setOffline(true);
  await type(page, { areola: "39", clock: "2", notes: "First." });
  await expect(bar(page)).toBeVisible();
  await details(page).getByLabel("Notes").fill("First, and more.");
  await page.reload().catch(() => undefined); // nobody answers
  await context.setOffline(false);
  await page.goto(`${base}/#scan=${scan}`);
  await hook.ready(page);
  await expect.poll(() => kept(scan, plan)).toMatchObject({ patterns: [["reduction", 39]], tumours: [[2, 45, 12, 21]], notes: ["First, and more."] });
  await page.keyboard.press("3");
  await toNotes(page);
  await expect(details(page).getByLabel("Notes")).toHaveValue("First, and more.");
  expect(await inBrowser(page)).toBe(0);
});

test("the session ends while notes and numbers are typed: after signing in all of it is there and saved", async ({ page, context, base }) => {
  const { scan, plan } = await opened(page, base);
  await context.clearCookies();
  await page.keyboard.press("3");
  await toNotes(page);
  await details(page).getByLabel("Notes").fill("Typed in an old session.");
  await details(page).getByLabel("Notes").press("Tab");
  await signIn(page);
  await hook.ready(page);
  await expect.poll(() => kept(scan, plan)).toMatchObject({ notes: ["Typed in an old session."] });
  await context.clearCookies();
  await page.keyboard.press("3");
  await toNotes(page);
  const notes = details(page).getByLabel("Notes");
  await expect(notes).toHaveValue("Typed in an old session.");
  await notes.fill("Not left yet.");
  await page.evaluate(() => dispatchEvent(new Event("focus"))); // the page asks the service, and learns of the end
  await signIn(page);
  await hook.ready(page);
  await expect.poll(() => kept(scan, plan)).toMatchObject({ notes: ["Not left yet."] });
  expect(await inBrowser(page)).toBe(0);
});

test("two tabs in one outage: both notes stay, and where numbers contradict each other the page asks", async ({ page, context, base }) => {
  const { scan, plan } = await opened(page, base);
  const other = await context.newPage();
  await other.goto(`${base}/#scan=${scan}`);
  await hook.ready(other);
  await context.setOffline(true);
  await type(page, { areola: "40", clock: "3", notes: "From the first tab." });
  await type(other, { areola: "44", clock: "3", notes: "From the second tab." });
  await context.setOffline(false);
  await expect(bar(page)).toBeHidden();
  await expect(bar(other)).toBeHidden();
  await expect.poll(async () => (await kept(scan, plan)).notes.join().split(/[\n,]/).sort()).toEqual(["From the first tab.", "From the second tab."]);
  const found = await kept(scan, plan);
  expect([found.patterns.length, found.tumours.length]).toEqual([1, 1]);
  const asked = (await page.getByRole("button", { name: "Take it as it is there" }).isVisible()) ? page : other;
  const theirs = asked === page ? 44 : 40;
  await expect(asked.locator(".notice-bar", { hasText: "in two ways" })).toContainText(`${theirs}`);
  expect(found.patterns).toEqual([["reduction", theirs === 44 ? 40 : 44]]);
  await asked.getByRole("button", { name: "Take it as it is there" }).click();
  await expect.poll(async () => (await kept(scan, plan)).patterns).toEqual([["reduction", theirs]]);
  await until(asked, () => window.__breastrig!.state().drawn.contested === null);
});
