// What a German page must not show: English words, and words that do not fit where they stand.
import { expect, type Page } from "@playwright/test";
import { word } from "../src/languages/words";
import { overlaps, smallTargets } from "./audit";
import { untilStill } from "./page";
import { catalogueOf, formsOf } from "./words";

const english = new Set(
  Object.entries(catalogueOf("en")).flatMap(([key, entry]) => {
    const german = formsOf(catalogueOf("de")[key]!);
    return formsOf(entry).filter((form) => !german.includes(form) && !form.includes("{") && /[a-z]{3}/.test(form));
  }),
);
for (const form of Object.values(catalogueOf("de")).flatMap(formsOf)) english.delete(form); // elsewhere a German word too
for (const form of ["Tumour", "none"]) english.delete(form); // words of the service as well, which has its own catalogue and tests

/** Texts on the page, hints and names for screen readers among them. */
const texts = (page: Page): Promise<string[]> =>
  page.evaluate(() => {
    const found: string[] = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) if (walker.currentNode.parentElement?.checkVisibility() && !walker.currentNode.parentElement.closest("[lang=en]")) found.push(walker.currentNode.textContent!.trim());
    for (const each of document.querySelectorAll("[title], [aria-label], [placeholder]")) if (each.checkVisibility()) found.push(...["title", "aria-label", "placeholder"].map((name) => each.getAttribute(name)?.trim() ?? ""));
    return [...new Set(found)].filter((text) => text !== "");
  });

/** Labels that are wider than their place: cut off, or over its edge.  What is cut by its own look, with three points, is so in every language. */
const tooWide = (page: Page): Promise<string[]> =>
  page.evaluate(() => {
    const root = document.querySelector("dialog[open]") ?? document.body;
    return [...root.querySelectorAll<HTMLElement>("button, .button, summary, label, h1, h2, h3, th, .tab, .menu-item, .chip, p, li, dt")].flatMap((each) => {
      if (!each.checkVisibility({ visibilityProperty: true }) || each.clientWidth === 0 || each.matches(".visually-hidden")) return [];
      const cut = [each, ...each.querySelectorAll<HTMLElement>("*")].some((part) => getComputedStyle(part).textOverflow === "ellipsis");
      const isOver = each.scrollWidth > each.clientWidth + 1 && !cut;
      const isHigh = each.matches("button, .button, .tab") && each.scrollHeight > each.clientHeight + 2 && getComputedStyle(each).overflowY !== "auto";
      return isOver || isHigh ? [`${each.tagName.toLowerCase()}.${each.className}: ${each.textContent.trim().slice(0, 60)} (${each.scrollWidth} x ${each.scrollHeight} in ${each.clientWidth} x ${each.clientHeight})`] : [];
    });
  });

/** Codes are drawn at random, and the bar says of saving what there is to say: all are shown at their widest while it is looked. */
async function atItsWidest<Found>(page: Page, look: () => Promise<Found>): Promise<Found> {
  const exchange = (back: boolean): Promise<void> =>
    page.evaluate(([isBack, unsaved]) => {
      const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      const own = window as unknown as { asItWas?: [Text, string][] };
      for (const [node, text] of own.asItWas ?? []) node.data = text;
      own.asItWas = [];
      while (!isBack && walker.nextNode()) {
        const node = walker.currentNode as Text;
        const widest = /^[A-Z\d]{3}-[A-Z\d]{3}$/.test(node.data) ? "WWM-WMW" : node.parentElement!.matches(".top-bar .saved") ? unsaved : null;
        if (widest === null) continue;
        own.asItWas.push([node, node.data]);
        node.data = widest;
      }
    }, [back, word("app.top.unsaved")] as const);
  await exchange(false);
  const found = await look();
  await exchange(true);
  return found;
}

const SCREENS = { tablet: { width: 834, height: 1112 }, desk: { width: 1280, height: 720 } };

/** The page is German in all that it says itself, and all of it fits, on a desk and on a tablet. */
export async function expectGerman(page: Page, name: string, picture?: (screen: string) => string): Promise<void> {
  expect.soft((await texts(page)).filter((text) => english.has(text)), `${name}: English`).toEqual([]);
  for (const [screen, viewport] of Object.entries(SCREENS)) {
    await page.setViewportSize(viewport);
    await untilStill(page);
    expect.soft(await atItsWidest(page, () => tooWide(page)), `${name}, ${screen}: too wide`).toEqual([]);
    expect.soft(await smallTargets(page), `${name}, ${screen}: too small to press`).toEqual([]);
    expect.soft(await atItsWidest(page, () => overlaps(page)), `${name}, ${screen}: controls over one another`).toEqual([]);
    if (picture) await page.screenshot({ path: picture(screen) });
  }
}
