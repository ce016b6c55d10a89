// The tests speak English, but for those that ask for another language.
import german from "../src/languages/de.json";
import english from "../src/languages/en.json";
import { type Catalogue, speak } from "../src/languages/words";

const LANGUAGES: Record<"en" | "de", [string, Catalogue]> = { en: ["en-GB", english], de: ["de-DE", german] };

speak(...LANGUAGES.en);

/** Constants of modules that are loaded already stay as they are. */
export function inLanguage(language: keyof typeof LANGUAGES, act: () => void): void {
  speak(...LANGUAGES[language]);
  try {
    act();
  } finally {
    speak(...LANGUAGES.en);
  }
}
