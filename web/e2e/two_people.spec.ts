// Several people at one service: two plan one patient and lose no word, a reader cannot change, a stranger cannot see, an
// administrator gives a patient away; and a sign-in at a provider of OpenID Connect that a session's end leads back to.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { type Browser, expect, type Page } from "@playwright/test";
import { addToPlan, details, example, hook, test } from "./page";
import { findPython, helper, type Running, startService } from "./service";

const folder = mkdtempSync(join(tmpdir(), "breastrig-e2e-"));
const USERS = `
proxy_header = "X-Remote-User"
proxy_groups_header = "X-Remote-Groups"
[groups.north]
role = "plan"
[groups.south]
role = "plan"
[groups.readers]
role = "look"
[groups.office]
role = "administer"
`;
let service: Running;

test.use({ base: async ({}, use) => use(service.base) });
test.beforeAll(async () => {
  const users = join(folder, "users.toml");
  writeFileSync(users, USERS);
  service = await startService({}, ["--users", users, "--trusted-proxy", "127.0.0.1"]);
});
test.afterAll(async () => {
  await service.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** The browser of a person whom the proxy names. */
async function of(browser: Browser, name: string, groups: string): Promise<Page> {
  const context = await browser.newContext({ extraHTTPHeaders: { "X-Remote-User": name, "X-Remote-Groups": groups } });
  const page = await context.newPage();
  await page.addInitScript(() => localStorage.setItem("breastrig.fits-at-once", "no"));
  await page.goto(service.base);
  return page;
}

const statusOf = (page: Page, path: string, method = "GET"): Promise<number> =>
  page.evaluate(async ([at, how]) => (await fetch(at!, { method: how! })).status, [path, method]);

async function note(page: Page, text: string): Promise<void> {
  await page.keyboard.press("3");
  if (!(await details(page).getByLabel("Notes").isVisible())) await addToPlan(page, /^Note/);
  await details(page).getByLabel("Notes").fill(text);
  await details(page).getByLabel("Notes").press("Tab");
}

test("two people plan one patient, a reader looks, a stranger finds nothing, an administrator gives the patient away", async ({ browser }) => {
  const anna = await of(browser, "anna", "north");
  await example(anna);
  await hook.ready(anna);
  const { scan, plan, patient } = await anna.evaluate(() => {
    const { id, links, patient } = window.__breastrig!.state().scan!.info;
    return { scan: id, plan: links.plan, patient };
  });
  await anna.locator("[popovertarget=page-menu]").click();
  await expect(anna.locator("#page-menu")).toContainText("Signed in as anna · may plan");
  await anna.keyboard.press("Escape");

  const bea = await of(browser, "bea", "north");
  await bea.goto(`${service.base}/#scan=${scan}`);
  await hook.ready(bea);
  for (const page of [anna, bea]) await page.context().setOffline(true);
  await note(anna, "Anna saw a scar on the left.");
  await note(bea, "Bea asks for a smaller areola.");
  for (const page of [anna, bea]) await page.context().setOffline(false);
  const notes = (): Promise<string[]> =>
    anna.evaluate(async (at) => {
      const { items } = (await (await fetch(at)).json()) as { items: { kind: string; text?: string }[] };
      return items.flatMap(({ kind, text }) => (kind === "note" ? text!.split("\n") : [])).sort();
    }, plan);
  await expect.poll(notes).toEqual(["Anna saw a scar on the left.", "Bea asks for a smaller areola."]);

  const stranger = await of(browser, "carl", "south");
  await expect(stranger.getByRole("button", { name: "Try the example" })).toBeVisible();
  await expect(stranger.locator(".patients li")).toHaveCount(0);
  for (const path of [`/api/scans/${scan}`, plan, `/api/patients/${patient}`, `/api/scans/${scan}/mesh.glb`]) expect(await statusOf(stranger, path)).toBe(404);
  await stranger.goto(`${service.base}/#scan=${scan}`);
  await expect(stranger.getByRole("alert").filter({ visible: true })).toContainText("no longer kept by the service");

  const office = await of(browser, "olga", "office");
  const card = office.locator(`[data-patient="${patient}"]`);
  await expect(card.getByLabel("Group")).toHaveValue("north");
  await card.getByLabel("Group").selectOption("readers");
  await expect.poll(() => statusOf(anna, plan)).toBe(404);

  const rose = await of(browser, "rose", "readers");
  await expect(rose.getByText("You may look at patients, not change them.")).toBeVisible();
  await expect(rose.getByText("New patient", { exact: true })).toBeHidden();
  await expect(rose.locator(`[data-patient="${patient}"] [popovertarget^=patient-menu]`)).toHaveCount(0);
  await rose.goto(`${service.base}/#scan=${scan}`);
  await hook.ready(rose);
  await note(rose, "Rose may not.");
  await expect(rose.getByText("rose may look at patients, not change them.", { exact: false }).first()).toBeVisible();
  expect(await notes().catch(() => [])).toEqual([]); // it is not Anna's any more
  expect(await statusOf(rose, plan)).toBe(200);
  expect(await statusOf(rose, `/api/patients/${patient}`, "DELETE")).toBe(403);
  expect(await rose.evaluate(() => window.__breastrig!.state().drawn.note)).not.toContain("Rose");
  for (const page of [anna, bea, stranger, office, rose]) await page.context().close();
});

test("a person in two groups names the one that a new patient belongs to", async ({ browser }) => {
  const both = await of(browser, "cleo", "north,south");
  await both.getByRole("button", { name: "Try the example" }).click();
  await both.locator("#example-menu").getByRole("button").nth(1).click();
  await expect(both.getByRole("alert").filter({ visible: true })).toContainText("You are in several groups");
  await both.getByLabel("A new patient belongs to").selectOption("south");
  await example(both);
  await hook.ready(both);
  const patient = await both.evaluate(() => window.__breastrig!.state().scan!.info.patient);
  const carl = await of(browser, "carl", "south");
  await expect(carl.locator(`[data-patient="${patient}"]`)).toBeVisible();
  for (const page of [both, carl]) await page.context().close();
});

test("a person signs in at the provider; when the session ends, what is typed is there after the next sign-in", async ({ browser }) => {
  const port = await freePort();
  const origin = `http://localhost:${port}`; // another site than the provider's
  const { path, env } = helper("openid_provider.py");
  const provider = spawn(findPython(), ["-W", "ignore", path, `${origin}/sign-in/callback`], { env, stdio: ["pipe", "pipe", "ignore"] });
  let own: Running | null = null;
  try {
    const issuer = await new Promise<string>((done) => provider.stdout.once("data", (line: Buffer) => done(line.toString().trim())));
    const users = join(folder, "oidc.toml");
    writeFileSync(users, `issuer = "${issuer}"\nclient_id = "breastrig"\nclient_secret = "a-secret-of-the-client"\nscopes = ["openid", "profile", "groups"]\n[groups.clinic-north]\nrole = "plan"\n[groups.clinic-south]\nrole = "plan"\n`);
    own = await startService({}, ["--users", users], undefined, String(port));
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.addInitScript(() => location.port !== "" && localStorage.setItem("breastrig.fits-at-once", "no"));
    const signIn = async (name: string): Promise<void> => {
      await page.getByRole("link", { name: "Sign in" }).click();
      const login = page.locator("input[name=login]");
      const password = page.locator("input[name=password]");
      await expect(login.or(password).first()).toBeVisible();
      if (await login.isVisible()) {
        await login.fill(name);
        await login.press("Enter");
      }
      await password.fill("correct horse battery staple");
      await password.press("Enter");
      await page.waitForURL((url) => url.origin === origin && !url.pathname.startsWith("/sign-in"));
    };
    await page.goto(origin);
    await signIn("anna");
    await example(page);
    await hook.ready(page);
    expect(await page.evaluate(() => document.cookie)).toBe("");
    await note(page, "First.");
    await expect(page.getByText("Saved", { exact: true })).toBeVisible();
    await context.clearCookies({ name: /^breastrig_session/ });
    await details(page).getByLabel("Notes").fill("Typed when the session was over.");
    await details(page).getByLabel("Notes").press("Tab");
    await signIn("anna");
    await hook.ready(page);
    await expect.poll(() => page.evaluate(() => window.__breastrig!.state().drawn.note)).toBe("Typed when the session was over.");
    await expect(page.getByText("Saved", { exact: true })).toBeVisible();
    await page.locator("[popovertarget=page-menu]").click();
    await page.getByRole("button", { name: "Sign out" }).click();
    await expect(page.getByRole("link", { name: "Sign in" })).toBeVisible();
    expect(await statusOf(page, "/api/patients")).toBe(401);
    await context.close();
  } finally {
    await own?.stop();
    provider.stdin.end();
  }
});

function freePort(): Promise<number> {
  return new Promise((done) => {
    const server = createServer();
    server.listen(0, "127.0.0.1", () => {
      const address = server.address();
      server.close(() => done(typeof address === "object" && address ? address.port : 0));
    });
  });
}
