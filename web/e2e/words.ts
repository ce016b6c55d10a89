// What a test says with the page's own words: English, unless it asks for another language.
import { readFileSync } from "node:fs";
import type { Page } from "@playwright/test";
import { type Catalogue, type Key, speak } from "../src/languages/words";

const LOCALES = { en: "en-GB", de: "de-DE" } as const;
export type Language = keyof typeof LOCALES;

export const catalogueOf = (language: Language): Catalogue => JSON.parse(readFileSync(new URL(`../src/languages/${language}.json`, import.meta.url), "utf8")) as Catalogue;

let now: Catalogue;

/** From here on `said` is in this language. */
export function speakIn(language: Language): void {
  now = catalogueOf(language);
  speak(LOCALES[language], now);
}

speakIn("en");

/** All forms of an entry. */
export const formsOf = (entry: Catalogue[string]): string[] => (typeof entry === "string" ? [entry] : Object.values(entry));

/** What the page says under this key, whatever is in its places. */
export function said(key: Key): RegExp {
  const patterns = formsOf(now[key]!).map((form) => form.replaceAll(/[.*+?^$()[\]\\|]/g, "\\$&").replaceAll(/\{\w+\}/g, ".+").replaceAll(/\s/g, "\\s"));
  return new RegExp(`^(${patterns.join("|")})$`);
}

/** Before the page is opened: it was chosen in this browser. */
export const choose = (page: Page, base: string, language: Language): Promise<void> => page.context().addCookies([{ name: "breastrig_language", value: language, url: base, sameSite: "Strict" }]);
