// The wiring plan: makes store, actions, page and view, and lets them follow the state.
import "../style.css";
import { client, onSignedOut } from "../api/client";
import { mayShowInk } from "../scan/fineColours";
import { followModels } from "../stances/followModels";
import { createOutbox } from "../store/outbox";
import { followMarks } from "../stances/marksBeside";
import type { Place } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { createStore, only } from "../store/store";
import { watchTyping } from "../ui/dom";
import { createActions } from "./actions";
import { followAddress } from "./followAddress";
import { listenToKeys } from "./keyboard";
import { isRefused } from "./leaving";
import { openViewer } from "./openViewer";
import { createPage } from "./Page";
import { withPlacingView } from "./placingView";
import { initialSession, type Session } from "./session";
import { followIdle } from "./people/idle";
import { keepAddress, takeAddress } from "./unsavedWork";

const still = matchMedia("(prefers-reduced-motion: reduce)");
const prefersStill = (): boolean => still.matches;

const store = createStore<Session>(initialSession, withPlacingView);
const outbox = createOutbox(sessionStorage);
const actions = createActions(store, client, prefersStill, outbox);
const dismiss = (place: Place): void => store.set((state) => withProblem(state, place, null));

watchTyping();
const page = createPage(actions, dismiss);
document.body.append(...page.elements);
page.follow(store);
openViewer(store, actions, page.stages, prefersStill);
const FITS_AT_ONCE = "breastrig.fits-at-once"; // a wish of whoever uses this browser
if (localStorage.getItem(FITS_AT_ONCE) === "no") store.set({ fitsAtOnce: false });
store.select(only("fitsAtOnce"), ({ fitsAtOnce }) => (fitsAtOnce ? localStorage.removeItem(FITS_AT_ONCE) : localStorage.setItem(FITS_AT_ONCE, "no")));
let isInkOpen = false;
store.select(only("scan"), ({ scan }) => {
  if (isInkOpen || !scan || !mayShowInk(scan.info)) return;
  isInkOpen = true;
  void import("../ink/open").then(({ openInk }) => openInk(store, client, actions, page.ink));
});
listenToKeys(store, actions);
/** What is typed in a field is taken as it stands: the page is about to go. */
const endTyping = (): void => (document.activeElement as HTMLElement | null)?.blur();
addEventListener("pagehide", endTyping);
addEventListener("pagehide", () => void actions.landmarks.flush(true));
addEventListener("pagehide", () => void actions.drawing.flush());
addEventListener("pagehide", () => void actions.deletion.send());
// Whoever comes back to this tab learns what was written in another one meanwhile.
const look = (): void => {
  void actions.size.look().then(() => Promise.all([actions.plan.look(), actions.landmarks.look()]));
  actions.unsaved.soon();
};
addEventListener("focus", look);
addEventListener("online", () => actions.unsaved.soon());
document.addEventListener("visibilitychange", () => document.visibilityState === "visible" && look());
let isSigningIn = false; // what is unsaved waits in this tab's memory then
addEventListener("beforeunload", (event) => {
  endTyping(); // while the page is still there: what a slow one writes in pagehide may come after the next page has read
  if (!isSigningIn && isRefused(store.get())) event.preventDefault(); // the browser asks
});
function signIn(): void {
  if (isSigningIn) return;
  isSigningIn = true;
  endTyping();
  keepAddress(location.hash, sessionStorage);
  location.assign("/sign-in");
}
onSignedOut(signIn);
reportUnforeseen();
void begin();

/** Unforeseen errors are shown too: a page that stands still without a word is the worst of errors. */
function reportUnforeseen(): void {
  const report = (error: unknown): void => store.set((state) => withProblem(state, "page", messageOf(error)));
  addEventListener("error", (event) => {
    if (!event.message.startsWith("ResizeObserver")) report(event.error ?? event.message); // that one is only a late layout
  });
  addEventListener("unhandledrejection", (event) => report(event.reason));
}

async function begin(): Promise<void> {
  try {
    const [meta, examples] = await Promise.all([client.meta(), client.examples()]);
    const preset = meta.presets.includes("default") ? "default" : (meta.presets[0] ?? "default");
    store.set({ meta, examples, preset });
  } catch (error) {
    store.set((state) => withProblem(state, "service", messageOf(error)));
    return;
  }
  followModels(store, client);
  followMarks(store);
  void client.isSignedIn().then((isSignedIn) => store.set({ isSignedIn }), () => undefined); // then there is just no button
  const { person } = store.get().meta ?? {};
  const isAnother = person ? outbox.belongTo(person.id) : false;
  if (person?.idle_minutes) followIdle({ minutes: person.idle_minutes, memory: localStorage, stay: client.stay, warn: (sentence) => store.set((state) => withProblem(state, "page", sentence)), leave: signIn });
  const kept = takeAddress(sessionStorage);
  const hash = isAnother ? null : kept;
  if (hash !== null && location.hash === "") history.replaceState(null, "", hash || location.pathname);
  await followAddress(store, actions);
  // Whenever no patient is on the page, the list of all is, as the service has it now; not before the one that the address names.
  store.select(only("scan"), ({ scan }) => {
    if (scan === null) queueMicrotask(() => void actions.patients.read());
  });
  await actions.unsaved.now(); // what could not be saved of scans that are not on the page
}
