// What browser tests may ask the page, see src/viewer/testHook.ts.
import type { Session } from "../src/app/session";
import type { TestHook } from "../src/viewer/testHook";

declare global {
  interface Window {
    readonly __breastrig?: TestHook<Session>;
  }
}
