// Two links, opened at once in two tabs of one browser: each tab has its own patient's result, body and files, every time.
import { readFile } from "node:fs/promises";
import { expect, type Page, test } from "@playwright/test";
import { hook, until } from "./page";
import { type Link, Owner, sha256 } from "./shared";

const ROUNDS = Number(process.env.BREASTRIG_ROUNDS ?? 2); // each order of opening once; `make routes` runs 20

const owner = new Owner();

interface Tab {
  readonly link: Link;
  readonly mean: number;
  readonly expected: Record<string, string>; // file → sha256, as a visitor gets it who has opened nothing else
}

/** A link to the fit of a stance. */
async function patient(stance: "standing" | "supine"): Promise<Tab> {
  const { fit } = await owner.fitted(stance);
  const link = await owner.share(fit, { scan: "full" });
  const result = await owner.json<{ surface_distance_mm: { mean: number } }>(fit.result!);
  const expected = await owner.offered(link);
  expect(Object.keys(expected).sort()).toEqual(["drawing.json", "fitted.glb", "fitted.ply", "report.pdf", "result.json", "scan.glb"]);
  expect(expected["fitted.ply"]).toBe(await owner.hash(fit.fitted_ply!));
  return { link, mean: result.surface_distance_mm.mean, expected };
}

/** What the tab has: the number on it, the scan in its memory, and each file that it offers, as it would be downloaded. */
async function shown(page: Page): Promise<{ mean: number; mesh: string; files: Record<string, string> }> {
  await until(page, () => window.__breastrig?.state().fit?.result != null);
  return page.evaluate(async () => {
    const hex = async (bytes: ArrayBuffer): Promise<string> =>
      [...new Uint8Array(await crypto.subtle.digest("SHA-256", bytes))].map((each) => each.toString(16).padStart(2, "0")).join("");
    const { fit, scan } = window.__breastrig!.state();
    const links = [...document.querySelectorAll<HTMLAnchorElement>(".files a")];
    const files = await Promise.all(links.map(async (each) => [each.download, await hex(await (await fetch(each.href)).arrayBuffer())] as const));
    return { mean: fit!.result!.surface_distance_mm.mean!, mesh: await hex(scan!.mesh!), files: Object.fromEntries(files) };
  });
}

/** By hand, as a browser takes files away. */
async function downloads(page: Page, tab: Tab): Promise<void> {
  for (const name of ["fitted.ply", "scan.glb"]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("link", { name }).click()]);
    expect(sha256(await readFile(await download.path())), name).toBe(tab.expected[name]);
    expect(download.suggestedFilename()).toBe(name);
  }
}

test("two tabs with two links show and give each its own, opened at once and loaded again at once", async ({ browser }) => {
  const [first, second] = [await patient("standing"), await patient("supine")];
  expect(first.mean).not.toBe(second.mean);
  const context = await browser.newContext(); // one browser for all rounds: what is left of a round must not matter
  const check = async (page: Page, tab: Tab, when: string): Promise<void> => {
    const found = await shown(page);
    expect(found, when).toEqual({ mean: tab.mean, mesh: tab.expected["scan.glb"], files: tab.expected });
    expect(new URL(page.url()).pathname, when).toBe(`/s/${tab.link.id}`);
  };
  for (let round = 1; round <= ROUNDS; round += 1) {
    const tabs = round % 2 === 0 ? [first, second] : [second, first];
    const pages = await Promise.all(tabs.map(() => context.newPage()));
    await Promise.all(tabs.map((tab, index) => pages[index]!.goto(owner.base + tab.link.url)));
    await Promise.all(tabs.map((tab, index) => check(pages[index]!, tab, `round ${round}, opened`)));
    if (round % 2 === 0) {
      await Promise.all(pages.map((page) => page.reload()));
      await Promise.all(tabs.map((tab, index) => check(pages[index]!, tab, `round ${round}, loaded again`)));
      await hook.ready(pages[0]!);
    }
    if (round === ROUNDS) for (const [index, tab] of tabs.entries()) await downloads(pages[index]!, tab); // each while the other is open beside it
    await Promise.all(pages.map((page) => page.close()));
  }
  await context.close();
});
