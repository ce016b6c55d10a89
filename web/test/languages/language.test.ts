import { expect, test } from "vitest";
import { languageOf } from "../../src/languages/language";
import { capital, inSentence, listed, word } from "../../src/languages/words";
import { inLanguage } from "../english";

test("the chosen language comes before the browser's, of whose wishes the first counts that there is; English is the last", () => {
  expect(languageOf("", ["de-AT", "en"])).toBe("de");
  expect(languageOf("", ["fr-FR", "en-US", "de"])).toBe("en");
  expect(languageOf("", ["fr"])).toBe("en");
  expect(languageOf("", [])).toBe("en");
  expect(languageOf("other=de; breastrig_language=de", ["en"])).toBe("de");
  expect(languageOf("breastrig_language=en", ["de"])).toBe("en");
  expect(languageOf("breastrig_language=xx", ["de"]), "of another version").toBe("de");
  expect(languageOf("my_breastrig_language=de", ["en"])).toBe("en");
  expect(languageOf("breastrig_language=constructor", ["en"])).toBe("en");
});

test("places are filled, numbers as the language writes them, and the count chooses the form", () => {
  expect(word("share.days", { count: 1 })).toBe("1 day");
  expect(word("share.days", { count: 2000 })).toBe("2,000 days");
  expect(word("share.until", { when: "{count} $& $1" }), "a value is no pattern").toBe("Open until {count} $& $1");
  inLanguage("de", () => {
    expect([0, 1, 2000].map((count) => word("landmarks.landmarks", { count }))).toEqual(["0 Landmarken", "1 Landmarke", "2.000 Landmarken"]);
    expect(word("drawing.pattern.range", { min: 0.5, max: 12.5, unit: "Uhr" })).toBe("0,5 bis 12,5 Uhr");
    expect(listed(["im Stehen", "in Rückenlage", "im MRT"])).toBe("im Stehen, in Rückenlage und im MRT");
    expect([inSentence("Winkel"), capital("übrige")]).toEqual(["Winkel", "Übrige"]);
  });
  expect([listed(["a", "b", "c"]), inSentence("Angle")]).toEqual(["a, b and c", "angle"]);
});
