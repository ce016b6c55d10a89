// Which language the page is in: the one that was chosen, else the first of the browser's that there is.
import { type Catalogue, speak } from "./words";

/** Each with its own name for itself, how its numbers and days are written, and its words. */
const LANGUAGES = {
  en: { name: "English", locale: "en-GB", load: (): Promise<{ default: Catalogue }> => import("./en.json") },
  de: { name: "Deutsch", locale: "de-DE", load: (): Promise<{ default: Catalogue }> => import("./de.json") },
};

export type Language = keyof typeof LANGUAGES;

const COOKIE = "breastrig_language"; // the service reads it as well: its sentences and files come in the same language
const YEAR = 365 * 24 * 60 * 60; // seconds

const isLanguage = (tag: string): tag is Language => Object.hasOwn(LANGUAGES, tag);

/** `cookies` as the document has them, `wishes` the browser's list ("de-AT", "en"), the dearest first. */
export function languageOf(cookies: string, wishes: readonly string[]): Language {
  const chosen = cookies.split(/;\s*/).find((each) => each.startsWith(`${COOKIE}=`));
  const tags = [chosen?.slice(COOKIE.length + 1) ?? "", ...wishes].map((tag) => tag.toLowerCase().split("-")[0]!);
  return tags.find(isLanguage) ?? "en";
}

const now = (): Language => languageOf(document.cookie, navigator.languages);

/** Loads the words; only then may a module that has some be imported. */
export async function openLanguage(): Promise<void> {
  const language = now();
  const { locale, load } = LANGUAGES[language];
  speak(locale, (await load()).default);
  document.documentElement.lang = language;
}

/** Those that the page is not in, as people who read them call them. */
export const otherLanguages = (): { language: Language; name: string }[] =>
  (Object.keys(LANGUAGES) as Language[]).filter((language) => language !== now()).map((language) => ({ language, name: LANGUAGES[language].name }));

/** Keeps the choice, and opens the page again in that language. */
export function changeLanguage(to: Language): void {
  document.cookie = `${COOKIE}=${to}; path=/; max-age=${YEAR}; SameSite=Strict${location.protocol === "https:" ? "; Secure" : ""}`;
  location.reload();
}
