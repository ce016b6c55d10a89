// Checks that any state of the page must pass: axe-core, the size of what can be pressed, nothing beside the screen.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { expect, type Page } from "@playwright/test";
import type { AxeResults, RunOptions } from "axe-core";
import { untilStill } from "./page";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const TARGET_PX = 24; // WCAG 2.2, 2.5.8
const FINGER_PX = 44; // where fingers press

/** What axe-core itself calls moderate or minor at most: the ones that take long, which are not asked for nothing. */
const MILD = ["region", "hidden-content", "heading-order", "page-has-heading-one", "skip-link", "aria-allowed-role", "presentation-role-conflict"];
const MILD_LANDMARKS = ["banner-is-top-level", "contentinfo-is-top-level", "main-is-top-level", "no-duplicate-banner", "no-duplicate-contentinfo", "no-duplicate-main", "one-main", "unique"];
const WITHOUT_MILD = Object.fromEntries([...MILD, ...MILD_LANDMARKS.map((name) => `landmark-${name}`)].map((rule) => [rule, { enabled: false }]));

/** What axe-core calls serious or critical, as "rule: element". */
export async function seriousFindings(page: Page, options: RunOptions = {}): Promise<string[]> {
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(AXE);
  const { violations } = await page.evaluate((given) => (window as unknown as { axe: { run(options: RunOptions): Promise<AxeResults> } }).axe.run(given), {
    resultTypes: ["violations"],
    preload: false, // of style sheets: for rules that are not asked
    ...(options.runOnly ? {} : { rules: WITHOUT_MILD }),
    ...options,
  } as RunOptions);
  return violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)} ${node.failureSummary?.split("\n")[1]?.trim() ?? ""}`));
}

/** Everything that can be pressed and is smaller than 24 pixels, or 44 where fingers press; a label counts with its control. */
export function smallTargets(page: Page): Promise<string[]> {
  return page.evaluate(([mouse, finger]) => {
    const least = matchMedia("(pointer: coarse)").matches ? finger : mouse;
    const root = document.querySelector("dialog[open]") ?? document.body;
    const all = [...root.querySelectorAll<HTMLElement>("button, a[href], input, select, textarea, summary, [tabindex='0'], [role=button]")];
    return all.flatMap((each) => {
      if (each.closest("[aria-hidden=true]")) return [];
      const target = each.closest<HTMLElement>("label") ?? each;
      if (!target.checkVisibility({ visibilityProperty: true })) return [];
      const { width, height } = target.getBoundingClientRect();
      // Half a pixel is the browser's rounding of a layout in fractions.
      return width + 0.5 >= least && height + 0.5 >= least ? [] : [`${target.outerHTML.slice(0, 120)}: ${width.toFixed(1)} x ${height.toFixed(1)}`];
    });
  }, [TARGET_PX, FINGER_PX] as const);
}

/** At this size nobody has to scroll for the one thing that comes next, nor for a way to look and to replay. */
export function scrolledAway(page: Page): Promise<string[]> {
  return page.evaluate(() =>
    ["#next", "#report", ".view-bar", ".strip", ".top-bar", ".side-foot"].filter((name) => {
      const shown = document.querySelector(name);
      if (!shown?.checkVisibility()) return false;
      const { top, bottom, left, right } = shown.getBoundingClientRect();
      return top < 0 || left < 0 || bottom > innerHeight || right > innerWidth;
    }),
  );
}

/** Controls whose outline or fill has less than 3 : 1 to what is around them (WCAG 2.2, 1.4.11); one that is words alone has axe's rule for text. */
export function paleControls(page: Page): Promise<string[]> {
  return page.evaluate(() => {
    const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true })!;
    /** What a colour of the style sheet comes to over others, the last one opaque. */
    const seen = (...colours: string[]): readonly number[] => {
      for (const colour of colours.reverse()) {
        pen.fillStyle = colour;
        pen.fillRect(0, 0, 1, 1);
      }
      return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3).map((value) => (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4));
    };
    const bright = ([r, g, b]: readonly number[]): number => 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
    const ratio = (one: readonly number[], other: readonly number[]): number => (Math.max(bright(one), bright(other)) + 0.05) / (Math.min(bright(one), bright(other)) + 0.05);
    const grounds = (each: Element | null): string[] => (each ? [getComputedStyle(each).backgroundColor, ...grounds(each.parentElement)] : ["Canvas"]);
    const root = document.querySelector("dialog[open]") ?? document.body;
    const all = [...root.querySelectorAll<HTMLElement>("input:not([type=file], [type=range]), select, textarea, .button.outlined, .button.primary:not(:disabled, [aria-disabled=true])")];
    return all.flatMap((each) => {
      if (!each.checkVisibility({ visibilityProperty: true, opacityProperty: true }) || each.matches("input.visually-hidden")) return [];
      const { borderTopColor, borderTopWidth, backgroundColor, appearance } = getComputedStyle(each);
      if (appearance !== "none" && each.matches("[type=checkbox], [type=radio]")) return []; // the browser's own
      const around = grounds(each.parentElement);
      const edges = [seen(backgroundColor, ...around), ...(parseFloat(borderTopWidth) > 0 ? [seen(borderTopColor, ...around)] : [])];
      const best = Math.max(...edges.map((edge) => ratio(edge, seen(...around))));
      return best >= 3 ? [] : [`${each.outerHTML.slice(0, 120)}: ${best.toFixed(2)}`];
    });
  });
}

/** Controls that lie over one another or outside the screen, by pairs. */
export function overlaps(page: Page): Promise<string[]> {
  return page.evaluate(() => {
    const root = document.querySelector("dialog[open]") ?? document.body;
    const name = (each: Element): string => (each.getAttribute("aria-label") ?? each.textContent).trim().slice(0, 40) || each.className;
    const shown = [...root.querySelectorAll<HTMLElement>("button, a[href], input:not([type=file]), select, summary")].flatMap((each) => {
      // What is not drawn, as it is far below the screen, has no places yet.
      if (!each.checkVisibility({ visibilityProperty: true, opacityProperty: true, contentVisibilityAuto: true }) || each.matches("[aria-hidden=true] *")) return [];
      const box = each.getBoundingClientRect();
      const holder = each.closest(".side-scroll, .strip, .share-list, .measures-scroll")?.getBoundingClientRect();
      const isScrolledAway = holder && (box.bottom > holder.bottom || box.top < holder.top);
      return isScrolledAway ? [] : [{ each, box }];
    });
    const outside = shown.filter(({ box }) => box.left < -1 || box.right > innerWidth + 1).map(({ each }) => `beside the screen: ${name(each)}`);
    const pairs = shown.flatMap(({ each, box }, i) =>
      shown.slice(i + 1).flatMap(({ each: other, box: its }) => {
        const across = Math.min(box.right, its.right) - Math.max(box.left, its.left);
        const down = Math.min(box.bottom, its.bottom) - Math.max(box.top, its.top);
        if (each.matches(".handle") && other.matches(".handle")) return []; // a pointer takes the one whose middle is nearest
        return across > 1 && down > 1 && !each.contains(other) && !other.contains(each) ? [`${name(each)} over ${name(other)}`] : [];
      }),
    );
    return [...outside, ...pairs];
  });
}

const DESK = { width: 1280, height: 720 };
const TABLET = { width: 834, height: 1112 };

/** What is on the screen can be read and pressed by everybody: light and dark, on a desk and on a tablet. */
export async function expectForEverybody(page: Page, name: string): Promise<void> {
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" }); // nothing is looked at on its way
  expect.soft(await seriousFindings(page), `${name}: axe-core`).toEqual([]);
  for (const [device, viewport] of [["tablet", TABLET], ["desk", DESK]] as const) {
    await page.setViewportSize(viewport);
    await untilStill(page); // handles follow the picture
    expect.soft(await smallTargets(page), `${name}, ${device}: smaller than 24 pixels`).toEqual([]);
    expect.soft(await overlaps(page), `${name}, ${device}: controls over one another`).toEqual([]);
  }
  await page.emulateMedia({ colorScheme: "dark" });
  expect.soft(await seriousFindings(page, { runOnly: ["color-contrast"] }), `${name}: contrast in the dark`).toEqual([]);
  await page.emulateMedia({ colorScheme: null, reducedMotion: null });
}
