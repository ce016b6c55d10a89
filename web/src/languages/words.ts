// The words of the page: one JSON a language, the same keys in each, loaded by start.ts before anything that has words.
import type english from "./en.json";

export type Key = keyof typeof english;
export type Values = Readonly<Record<string, string | number>>;
/** A sentence with its {places}, or one a plural form: then it has a {count}. */
export type Catalogue = Readonly<Record<string, string | Readonly<Partial<Record<Intl.LDMLPluralRule, string>>>>>;

interface Spoken {
  readonly locale: string;
  readonly catalogue: Catalogue;
  readonly forms: Intl.PluralRules;
  readonly numbers: Intl.NumberFormat;
}

let spoken: Spoken | null = null;

/** From here on all words are those of this catalogue, and numbers and days are written as its locale has them. */
export function speak(locale: string, catalogue: Catalogue): void {
  spoken = { locale, catalogue, forms: new Intl.PluralRules(locale), numbers: new Intl.NumberFormat(locale) };
}

function now(): Spoken {
  if (spoken === null) throw new Error("words are asked for before a language is loaded");
  return spoken;
}

/** The locale that numbers and days are written in. */
export const locale = (): string => now().locale;

/** The sentence of this key; numbers are written as its language has them, `count` chooses the plural form. */
export function word(key: Key, values: Values = {}): string {
  const { catalogue, forms, numbers } = now();
  const entry = catalogue[key]!;
  const sentence = typeof entry === "string" ? entry : (entry[forms.select(Number(values.count))] ?? entry.other!);
  return sentence.replace(/\{(\w+)\}/g, (_, name: string) => {
    const value = values[name]!;
    return typeof value === "number" ? numbers.format(value) : value;
  });
}

/** "a, b and c". */
export const listed = (names: Iterable<string>): string => new Intl.ListFormat(locale()).format(names);

/** A name or heading as it stands inside a sentence: German keeps its capital, which nouns have there. */
export const inSentence = (words: string): string => (locale().startsWith("de") ? words : words.charAt(0).toLowerCase() + words.slice(1));

/** A name as it stands at the beginning of a sentence. */
export const capital = (words: string): string => words.charAt(0).toUpperCase() + words.slice(1);
