// What is left of a shared result in a visitor's browser: nothing in address bar and history, nothing after closing, nothing
// after the browser was started again; and what an owner in the same browser keeps.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type BrowserContext, chromium, expect, type Page, test } from "@playwright/test";
import { overlaps, scrolledAway, seriousFindings, smallTargets } from "./audit";
import { openShare, until } from "./page";
import { type Link, Owner } from "./shared";

const owner = new Owner();
let fit: Record<string, string>;
test.beforeAll(async () => {
  ({ fit } = await owner.fitted("standing"));
});

const secretOf = (link: Link): string => link.url.split("#")[1]!;
const status = (page: Page, path: string, method = "GET"): Promise<number> =>
  page.evaluate(async ([address, how]) => (await fetch(address!, { method: how! })).status, [path, method]);

async function opened(page: Page, link: Link): Promise<void> {
  await page.goto(owner.base + link.url);
  await expect(page.getByText("fitted.glb")).toBeVisible();
}

/** What the browser's own page of its history lists. */
async function addressesInHistory(context: BrowserContext): Promise<string[]> {
  const page = await context.newPage();
  await page.goto("chrome://history/");
  const read = (): Promise<string[]> =>
    page.evaluate(() => {
      const inside = (root: Document | ShadowRoot): string[] =>
        [...root.querySelectorAll("*")].flatMap((each) => [...(each instanceof HTMLAnchorElement ? [each.href] : []), ...(each.shadowRoot ? inside(each.shadowRoot) : [])]);
      return inside(document);
    });
  await expect.poll(async () => (await read()).some((address) => address.startsWith(owner.base))).toBe(true);
  return read();
}

async function signIn(page: Page): Promise<void> {
  await page.goto(owner.base);
  await page.getByLabel("Access token").fill(owner.token);
  await page.getByRole("button", { name: "Sign in" }).click();
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible();
}

test("the secret is in neither the address bar nor the history, and the address of the page opens nothing elsewhere", async ({ page, browser }) => {
  const link = await owner.share(fit, { passcode: "four words of it" });
  await test.step("another link that is put into the address bar is opened", async () => {
    const second = await owner.share(fit);
    await page.goto(owner.base + link.url);
    await expect(page.getByLabel("Passcode")).toBeVisible();
    await page.goto(owner.base + second.url); // the same document but for what stands behind #
    await expect(page.getByText("fitted.glb")).toBeVisible();
    expect(page.url()).toBe(`${owner.base}/s/${second.id}`);
  });
  await page.goto(`${owner.base}/healthz`);
  await page.goto(owner.base + link.url);
  await expect(page.getByLabel("Passcode")).toBeVisible();
  expect(page.url(), "while the passcode is asked for").toBe(`${owner.base}/s`);
  await page.getByLabel("Passcode").fill("four words of it");
  await page.getByRole("button", { name: "Open" }).click();
  await expect(page.getByText("fitted.glb")).toBeVisible();
  const place = `${owner.base}/s/${link.id}`;
  expect(page.url()).toBe(place);
  await page.reload();
  await expect(page.getByText("fitted.glb")).toBeVisible();
  expect(await seriousFindings(page)).toEqual([]);
  expect([await smallTargets(page), await overlaps(page), await scrolledAway(page)]).toEqual([[], [], []]);
  await page.goBack();
  expect(page.url()).toBe(`${owner.base}/healthz`);
  await page.goForward();
  await expect(page.getByText("fitted.glb")).toBeVisible();
  expect(page.url()).toBe(place);
  const stranger = await (await browser.newContext()).newPage();
  await stranger.goto(place);
  await expect(stranger.getByRole("alert")).toContainText("not open in this browser");
  await expect(stranger.getByText("fitted.glb")).toBeHidden();
  await stranger.context().close();
});

test("closing ends the credential, also for a copy of it, and leaves an owner in the same browser signed in", async ({ page, context, browser }) => {
  await signIn(page);
  await page.evaluate(() => {
    for (const storage of [sessionStorage, localStorage]) storage.setItem("unsaved", "mine");
  });
  const link = await owner.share(fit);
  const again = await context.newPage();
  await opened(again, link);
  const shared = await context.newPage();
  await opened(shared, link);
  const place = `/api/shared/${link.id}/result.json`;
  const [cookie, ...more] = (await context.cookies(owner.base + place)).filter(({ name }) => name.startsWith("breastrig_share"));
  expect(more).toEqual([]);
  expect(cookie).toMatchObject({ name: `breastrig_share_${link.id}`, path: `/api/shared/${link.id}`, expires: -1, httpOnly: true, sameSite: "Strict" });
  const thief = await browser.newContext();
  await thief.addCookies([cookie!]);
  const copy = await thief.newPage();
  await copy.goto(`${owner.base}/healthz`);
  expect(await status(copy, place)).toBe(200);

  await shared.getByRole("button", { name: "Close" }).click();
  await expect(shared.getByText("The result is closed")).toBeVisible();
  await expect(again.getByText("The result is closed"), "in the other tab that showed it").toBeVisible();
  expect(shared.url()).toBe(`${owner.base}/s`);
  expect(await status(shared, place)).toBe(401);
  expect(await status(copy, place)).toBe(401);
  expect((await context.cookies(owner.base + place)).filter(({ name }) => name.startsWith("breastrig_share"))).toEqual([]);
  await shared.goBack().catch(() => null); // there is nothing to go back to
  await expect(shared.getByText("fitted.glb")).toBeHidden();

  expect(await page.evaluate(() => [sessionStorage.getItem("unsaved"), localStorage.getItem("unsaved")])).toEqual(["mine", "mine"]);
  await page.reload();
  await expect(page.getByRole("button", { name: "Try the example" })).toBeVisible();
  await thief.close();
});

test("a visitor's day: what stood when the link was made, the present state when its owner says so, nothing when it is over", async ({ page, browser }) => {
  const own = await owner.fitted("standing");
  const { id } = await owner.json<{ id: string }>(own.scan.self!);
  const { bounds_m: bounds } = await owner.json<{ bounds_m: { min: number[]; max: number[] } }>(own.scan.self!);
  const below = bounds.min[1]! + 0.1 * (bounds.max[1]! - bounds.min[1]!);
  const plan = async (name: string, text: string): Promise<void> => {
    const { landmarks } = await owner.json<{ landmarks: Record<string, number[]> }>(own.fit.result!);
    const unit = { m: 1000, mm: 1 }[(await owner.json<{ unit: "m" | "mm" }>(own.scan.self!)).unit];
    const point = landmarks.nipple_L!.map((each) => each * unit);
    const line = { kind: "line", id: "a", scan: id, name, points: [point, point.map((each) => each + 5)] };
    await owner.ask(own.scan.plan!, "PUT", { items: [line, { kind: "note", id: "n", scan: id, text }] }, { "If-Match": (await owner.ask(own.scan.plan!)).headers.get("ETag")! });
  };
  await plan("before lunch", "she wants it smaller");

  await signIn(page);
  const part = (links: Record<string, string>): string => links.self!.split("/").at(-1)!;
  await page.goto(`${owner.base}/#scan=${part(own.scan)}&fit=${part(own.fit)}&step=handover`);
  const dialog = page.getByRole("dialog", { name: "Share this result" });
  await test.step("where the dialog's code does not arrive it is said, and tried again", async () => {
    await page.route("**/ShareDialog-*.js", (route) => route.abort());
    await openShare(page);
    await expect(page.getByText("The service does not answer")).toBeVisible();
    await page.unroute("**/ShareDialog-*.js");
    await expect(async () => {
      if (await dialog.isHidden()) await page.locator("#share").click({ timeout: 1_000 }); // the list of links may have come first, and have tried
      await expect(dialog).toBeVisible({ timeout: 3_000 });
    }).toPass();
  });
  await expect(dialog.getByText("without the layer that follows the skin")).toBeVisible();
  await dialog.getByLabel("It shows").selectOption("full");
  await expect(dialog.getByText("The visible part of the scan and its picture")).toBeVisible();
  expect(await seriousFindings(page)).toEqual([]);
  await dialog.getByRole("button", { name: "Make a link" }).click();
  const made = dialog.getByLabel("Address of the link");
  await expect(made).toHaveValue(/\/s#/);
  const address = await made.inputValue();

  const visitor = await (await browser.newContext()).newPage();
  await visitor.goto(address);
  await expect(visitor.locator(`[data-line="before lunch"]`)).toBeVisible();
  await expect(visitor.getByText("It is shown as it stood on")).toBeVisible();
  await expect(visitor.getByText("she wants it smaller"), "notes were not asked for").toHaveCount(0);
  const triangles = async (): Promise<number> => {
    await until(visitor, () => window.__breastrig?.state().scan?.mesh != null);
    return visitor.evaluate(() => window.__breastrig!.state().scan!.mesh!.byteLength);
  };
  const before = await triangles();

  await plan("after lunch", "she said otherwise");
  const eye = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  await owner.ask(own.scan.cuts!, "PUT", { cuts: [{ to_picture: eye, lasso: [[-9, -9], [9, -9], [9, below], [-9, below]] }] });
  await visitor.reload();
  await expect(visitor.locator(`[data-line="before lunch"]`)).toBeVisible();
  await expect(visitor.locator(`[data-line="after lunch"]`)).toHaveCount(0);
  expect(await triangles()).toBe(before);

  await dialog.getByRole("button", { name: "Show the present state" }).click();
  await expect(page.getByText("The link shows the present state.")).toBeAttached();
  await visitor.reload();
  await expect(visitor.locator(`[data-line="after lunch"]`)).toBeVisible();
  await expect(visitor.locator(`[data-line="before lunch"]`)).toHaveCount(0);
  expect(await triangles()).toBeLessThan(before);

  await dialog.getByRole("button", { name: "Revoke" }).click();
  await expect(dialog.getByText("Revoked on")).toBeVisible();
  await expect(dialog.getByRole("button", { name: "Show the present state" })).toHaveCount(0);
  await visitor.reload();
  await expect(visitor.getByRole("alert")).toContainText("revoked");
  await expect(visitor.locator(`[data-line="after lunch"]`)).toHaveCount(0);
  const second = await owner.share(own.fit, { notes: true });
  await opened(visitor, second);
  await expect(visitor.getByText("This is the model alone")).toBeVisible();
  await expect(visitor.getByText("she said otherwise")).toBeVisible();
  await expect(visitor.getByText("report.pdf")).toHaveCount(0);
  await owner.ask(own.scan.patient!, "DELETE");
  await visitor.reload();
  await expect(visitor.getByRole("alert")).toContainText("not open in this browser");
  await visitor.context().close();
});

test("the browser's history does not list the secret, and after it was started again nothing is open", async () => {
  const profile = mkdtempSync(join(tmpdir(), "breastrig-profile-"));
  const { args } = test.info().project.use.launchOptions!;
  const executablePath = (test.info().config.metadata as { chromium: string }).chromium; // a headless shell lists no history
  const start = (): Promise<BrowserContext> => chromium.launchPersistentContext(profile, { executablePath, args: args! });
  try {
    const link = await owner.share(fit);
    const before = await start();
    await opened(await before.newPage(), link);
    const listed = await addressesInHistory(before);
    expect(listed).toContain(`${owner.base}/s/${link.id}`);
    expect(listed.filter((address) => address.includes(secretOf(link)))).toEqual([]);
    await before.close();
    const after = await start();
    const page = await after.newPage();
    await page.goto(`${owner.base}/s`);
    await expect(page.getByText("No link is open here.")).toBeVisible();
    await expect(page.getByRole("button", { name: "Close" })).toBeHidden();
    await page.goto(`${owner.base}/s/${link.id}`);
    await expect(page.getByRole("alert")).toContainText("open it again as it was sent to you");
    await expect(page.getByText("fitted.glb")).toBeHidden();
    await opened(page, link); // the link itself works as before
    await after.close();
  } finally {
    rmSync(profile, { recursive: true, force: true });
  }
});

test("wrong passcodes make one wait and are counted for the owner, and the right one opens the link all the same", async ({ page }) => {
  const link = await owner.share(fit, { passcode: "the right one" });
  const guess = async (): Promise<void> => {
    await page.getByLabel("Passcode").fill("a wrong one");
    // The last guess's words stand there until this one is answered, so they say nothing of it.
    await Promise.all([page.waitForResponse((answer) => answer.url().endsWith("/api/shared/open")), page.getByRole("button", { name: "Open" }).click()]);
  };
  await page.goto(owner.base + link.url);
  for (let tried = 0; tried < 3; tried += 1) {
    await guess();
    await expect(page.getByRole("alert")).toContainText("not the link's passcode");
  }
  await guess();
  await expect(page.getByRole("alert")).toContainText(/wrong passcodes|not the link's passcode/);
  for (const colorScheme of ["light", "dark"] as const) {
    await page.emulateMedia({ colorScheme });
    expect(await seriousFindings(page), `${colorScheme}: axe-core`).toEqual([]);
  }
  expect(await smallTargets(page)).toEqual([]);
  const seen = await owner.json<{ wrong_passcodes: number; is_open: boolean }>(link.links.self);
  expect(seen.wrong_passcodes).toBeGreaterThanOrEqual(3);
  expect(seen.is_open).toBe(true);
  await expect(async () => {
    if (await page.getByLabel("Passcode").isVisible()) {
      await page.getByLabel("Passcode").fill("the right one", { timeout: 3000 });
      await page.getByRole("button", { name: "Open" }).click({ timeout: 3000 });
    }
    await expect(page.getByText("fitted.glb")).toBeVisible({ timeout: 3000 }); // on a busy machine the next look sees it
  }).toPass();
});
