// How the page arrives, and what it says when it cannot draw: nothing from elsewhere, small, cached, still while it
// loads; without a graphics card, and when the driver drops the picture.
import { gzipSync } from "node:zlib";
import { chromium, expect } from "@playwright/test";
import { example, hook, test, thumb } from "./page";

const BOUND_KB = 312; // gzip, all of script and style that the first view asks for: three.js is more than half of it, the words of all rooms are 20

test("the page arrives small, from its own service only, cached for good where a name stands for the content, and without a jump", async ({ page, base, troubles }) => {
  const sizes: Record<string, Promise<number>> = {};
  const caching: Record<string, string> = {};
  const failed: string[] = [];
  page.on("response", (answer) => {
    const { pathname } = new URL(answer.url());
    if (!answer.ok()) failed.push(`${answer.status()} ${pathname}`);
    caching[pathname] = answer.headers()["cache-control"] ?? "";
    if (/\.(js|css)$|^\/$/.test(pathname)) sizes[pathname] = answer.body().then((body) => gzipSync(body).length / 1000);
  });
  await page.addInitScript(() => {
    const shifts: number[] = [];
    Object.defineProperty(window, "layoutShifts", { value: shifts });
    const observer = new PerformanceObserver((list) => shifts.push(...list.getEntries().map((entry) => (entry as unknown as { value: number }).value)));
    observer.observe({ type: "layout-shift", buffered: true });
  });
  await page.goto(base);
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible();
  await page.waitForLoadState("networkidle");
  const total = (await Promise.all(Object.values(sizes))).reduce((sum, size) => sum + size, 0);
  console.log(`first view: ${total.toFixed(1)} kB of script and style, gzip, in ${Object.keys(sizes).length} files`);
  expect(total).toBeLessThan(BOUND_KB);
  const assets = Object.entries(caching).filter(([path]) => path.startsWith("/assets/"));
  expect(assets.length).toBeGreaterThan(2);
  for (const [path, rule] of assets) expect(rule, path).toContain("immutable");
  expect(caching["/"], "the page itself is asked for again").toBe("no-cache");
  expect(failed).toEqual([]);
  const shift = await page.evaluate(() => (window as unknown as { layoutShifts: number[] }).layoutShifts.reduce((sum, value) => sum + value, 0));
  expect(shift, "cumulative layout shift").toBeLessThan(0.02);
  const head = await page.evaluate(() => [document.documentElement.lang, document.title, document.querySelector("meta[name=viewport]") !== null, document.querySelector("meta[name=description]") !== null]);
  expect(head).toEqual(["en", "BreastRig", true, true]);
  expect(troubles).toEqual([]);
});

test("when the driver drops a picture its pane says so, the page goes on working, and draws again when it is back", async ({ page, base }) => {
  await page.goto(base);
  await example(page);
  await hook.ready(page);
  const wishes = await page.evaluate(() => document.querySelector<HTMLCanvasElement>("main canvas.view")!.getContext("webgl2")!.getContextAttributes());
  expect(wishes, "on the processor each pixel is drawn once").toMatchObject({ antialias: false });
  await page.evaluate(() => {
    const loss = document.querySelector<HTMLCanvasElement>("main canvas.view")!.getContext("webgl2")!.getExtension("WEBGL_lose_context")!;
    Object.defineProperty(window, "bringBack", { value: () => loss.restoreContext() });
    loss.loseContext();
  });
  const said = page.getByRole("alert").filter({ hasText: "dropped this page's picture" });
  await expect(said).toBeVisible();
  await page.keyboard.press("2");
  await page.getByRole("button", { name: "Use the example's landmarks" }).click();
  expect(await hook.pickCount(page)).toBe(12);
  await page.evaluate(() => (window as unknown as { bringBack: () => void }).bringBack());
  await expect(said).toBeHidden();
  const { colours, isLost } = await hook.picture(page);
  expect(isLost).toBe(false);
  expect(colours, "a lit body has many shades").toBeGreaterThan(100);

  await page.locator("#add-scan").click();
  await page.getByRole("dialog", { name: "Add a scan of this patient" }).getByRole("button", { name: /patient, supine/i }).click();
  await hook.ready(page);
  await thumb(page, "standing").click();
  const pane = page.locator(".other-stage");
  await expect(pane.locator("canvas")).toBeVisible();
  await page.evaluate(() => {
    const loss = document.querySelector<HTMLCanvasElement>("canvas.other-view")!.getContext("webgl2")!.getExtension("WEBGL_lose_context")!;
    Object.defineProperty(window, "bringItBack", { value: () => loss.restoreContext() });
    loss.loseContext();
  });
  const there = pane.getByRole("alert");
  await expect(there).toContainText("dropped this page's picture");
  await expect(there.getByRole("button", { name: "Load the page again" })).toBeVisible();
  await expect(page.locator(".stage").getByRole("alert").filter({ hasText: "dropped this page's picture" })).toBeHidden();
  await page.evaluate(() => (window as unknown as { bringItBack: () => void }).bringItBack());
  await expect(there).toBeHidden();
});

test("in a browser without any graphics the page says what is missing and what to do, and still fits", async ({ base }, info) => {
  const { executablePath } = info.project.use.launchOptions!;
  const browser = await chromium.launch({ ...(executablePath ? { executablePath } : {}), args: ["--disable-gpu", "--disable-software-rasterizer", "--disable-3d-apis", "--no-sandbox"] });
  try {
    const page = await browser.newPage();
    await page.goto(base);
    await expect(page.getByRole("alert").filter({ hasText: "no WebGL 2" })).toContainText("Turn on hardware acceleration");
    await example(page);
    await expect(page.locator(".stage .sureness")).toContainText(/^(one|two|three) fingers? wide±\s\d+\smm/);
    await page.keyboard.press("4");
    await expect(page.getByRole("link", { name: "Report (PDF)" })).toBeVisible();
  } finally {
    await browser.close();
  }
});
