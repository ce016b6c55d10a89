// The states of the page in the order in which a person meets them, for whoever looks at all of them: accessibility,
// sizes of targets, pictures.  A running fit is held at an iteration, so that it can be looked at.
import { expect, type Page } from "@playwright/test";
import { word } from "../src/languages/words";
import { said } from "./words";
import { example, hook, openShare, until, untilFitted } from "./page";

export interface StateOfPage {
  readonly name: string;
  readonly reach: (page: Page, base: string) => Promise<void>;
}

const HELD_AT = 6; // the number of the last event that is let through

/** Before the page is opened: a fit's later events wait until `releaseFit`. */
export async function holdFits(page: Page): Promise<void> {
  await page.addInitScript((last) => {
    const waiting: (() => void)[] = [];
    let isHeld = true;
    const source = EventSource.prototype as unknown as { addEventListener: (this: EventSource, kind: string, listener: EventListener) => void };
    const listen = source.addEventListener;
    source.addEventListener = function (kind, listener) {
      const later = (event: Event): void => {
        if (isHeld && Number((event as MessageEvent).lastEventId) > last) waiting.push(() => listener(event));
        else listener(event);
      };
      listen.call(this, kind, later);
    };
    // A stream whose end is held back has not broken.
    const onerror = Object.getOwnPropertyDescriptor(EventSource.prototype, "onerror")!;
    Object.defineProperty(EventSource.prototype, "onerror", {
      set(listener: EventListener) {
        onerror.set!.call(this, (event: Event) => {
          if (!isHeld) listener(event);
        });
      },
    });
    const release = (): void => {
      isHeld = false;
      for (const each of waiting.splice(0)) each();
    };
    Object.defineProperty(window, "releaseFit", { value: release });
  }, HELD_AT);
}

async function closeDialog(page: Page): Promise<void> {
  await page.keyboard.press("Escape");
  await expect(page.locator("dialog[open]")).toHaveCount(0);
}

export const STATES: readonly StateOfPage[] = [
  {
    name: "empty",
    reach: async (page, base) => {
      await page.goto(base);
      await expect(page.getByRole("button", { name: said("patients.home.example") })).toBeVisible();
    },
  },
  {
    name: "scan",
    reach: async (page) => {
      await example(page);
      await hook.ready(page);
    },
  },
  {
    name: "proposals",
    reach: async (page) => {
      await page.keyboard.press("2");
      await expect(page.locator("[data-proposed]").first()).toBeAttached();
    },
  },
  {
    name: "placing",
    reach: async (page) => {
      for (const name of ["suprasternal_notch", "xiphoid", "nipple_R", "nipple_L"]) await page.locator(`[data-landmark=${name}] .confirm`).click();
      await page.locator(".landmarks [data-landmark=nipple_L] .landmark-name").click();
    },
  },
  {
    name: "before the fit",
    reach: async (page) => {
      await page.keyboard.press("Escape");
      await page.keyboard.press("1");
    },
  },
  {
    name: "fitting",
    reach: async (page) => {
      await page.getByRole("button", { name: said("fit.with") }).click();
      await until(page, (held) => (window.__breastrig?.state().fit?.shown ?? -1) >= held - 2, HELD_AT);
    },
  },
  {
    name: "result",
    reach: async (page) => {
      await page.evaluate(() => (window as unknown as { releaseFit: () => void }).releaseFit());
      await untilFitted(page);
      await until(page, () => window.__breastrig?.state().fit?.distances);
    },
  },
  { name: "distances", reach: (page) => page.keyboard.press("d") },
  {
    name: "share dialog",
    reach: async (page) => {
      await openShare(page);
      const dialog = page.getByRole("dialog", { name: said("share.title") });
      await dialog.getByLabel(word("share.shown")).selectOption("plain");
      await dialog.getByRole("button", { name: said("share.make") }).click();
      await expect(dialog.getByLabel(word("share.link"))).toHaveValue(/\/s#/);
    },
  },
  {
    name: "help",
    reach: async (page) => {
      await closeDialog(page);
      await page.keyboard.press("?");
      await expect(page.getByRole("dialog")).toBeVisible();
    },
  },
  {
    name: "shared viewer",
    reach: async (page) => {
      await closeDialog(page);
      await openShare(page);
      await page.getByRole("dialog").getByRole("button", { name: said("share.make") }).click();
      const address = page.getByLabel(word("share.link"));
      await expect(address).toHaveValue(/\/s#/);
      await page.goto(await address.inputValue());
      await hook.ready(page);
    },
  },
];

/** The same state in a theme; without motion, so that nothing is looked at on its way. */
export const inTheme = (page: Page, colorScheme: "light" | "dark"): Promise<void> => page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
