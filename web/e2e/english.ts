// What a test says with the page's own words it says in English.
import { readFileSync } from "node:fs";
import { type Catalogue, speak } from "../src/languages/words";

speak("en-GB", JSON.parse(readFileSync(new URL("../src/languages/en.json", import.meta.url), "utf8")) as Catalogue);
