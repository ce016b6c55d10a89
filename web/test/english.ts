// The tests speak English.
import english from "../src/languages/en.json";
import { speak } from "../src/languages/words";

speak("en-GB", english);
