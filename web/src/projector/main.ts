// A second screen: the plan's lines on black, at true scale or as a projector must draw them.  A page of its own, so that it
// can stand on another screen than the one that is worked at.
import "../style.css";
import { client, onSignedOut } from "../api/client";
import type { Vector } from "../api/types";
import { messageOf } from "../store/problems";
import { createStore } from "../store/store";
import { el, setText, show } from "../ui/dom";
import { follow } from "../ui/Panel";
import { name as program, notice } from "../ui/text";
import { ARROWS } from "../viewer/keys";
import { type Camera, parallelCamera, type Place } from "./camera";
import { Picture } from "./Picture";
import { type Opened, openFit, readLines } from "./read";
import { CARD_MM, initialProjector, nextWanted, projectionOf, type ProjectorState, clicksKey, keptClicks, screenKey, withClick, withoutClick } from "./state";
import * as text from "./text";
import { createTools } from "./Tools";

const RULER_MM = 100; // to check the screen with a ruler of one's own
const LOOK_MS = 4000; // how often is asked whether the plan has changed
const words = text.projector;
const id = new URLSearchParams(location.hash.replace(/^#projector&?/, "")).get("fit");
const store = createStore<ProjectorState>(initialProjector);
let opened: Opened | null = null;
let version: number | null = null;
let cursor: Place = [0, 0];

const canvas = el("canvas", { class: "projector-picture", tabindex: 0, role: "img", "aria-label": words.title });
const cross = el("div", { class: "projector-cross", hidden: true }, el("div", {}), el("div", {}));
const mark = el("p", { class: "projector-mark" }, `${words.experimental} ${notice}`);
const hint = el("p", { class: "projector-hint" }, words.hidden);
const ruler = el("div", { class: "projector-ruler", hidden: true }, el("span", {}, words.scale.ruler(RULER_MM)));
const empty = el("p", { class: "projector-empty", role: "status" }); // why the screen is black
const picture = new Picture(canvas);
const fail = (error: unknown): void => store.set({ problem: messageOf(error) });

const tools = createTools({
  mode: (mode) => store.set((state) => ({ mode, wanted: state.wanted ?? nextWanted(state, null) })),
  bar: (pixels) => store.set({ barPixels: Math.min(1200, Math.max(120, pixels)) }),
  measured: () => {
    const pixelsPerMm = store.get().barPixels / CARD_MM;
    remember(pixelsPerMm);
    store.set({ pixelsPerMm });
  },
  measureAgain: () => store.set({ pixelsPerMm: null }),
  side: (side) => store.set({ side, moved: [0, 0] }),
  want: (wanted) => store.set({ wanted }),
  skip: () => store.set((state) => ({ wanted: nextWanted(state, state.wanted) })),
  remove: (each) => store.set((state) => withoutClick(state, each)),
  clear: () => store.set((state) => ({ clicks: {}, wanted: nextWanted({ ...state, clicks: {} }, null) })),
  hide: () => store.set({ areToolsHidden: true }),
  full: () => void document.documentElement.requestFullscreen().catch(() => undefined),
  outline: (hasOutline) => store.set({ hasOutline }),
  colours: (hasColours) => store.set({ hasColours }),
  again: () => void readPlan(),
  dismiss: () => store.set({ problem: null }),
});

document.title = `${words.title} · ${program}`;
document.body.className = "is-projector";
document.body.append(canvas, cross, ruler, mark, hint, empty, tools.element);
follow(store, tools);
store.subscribe((state) => {
  show(hint, state.areToolsHidden);
  draw(state);
});
new ResizeObserver(() => draw(store.get())).observe(canvas);
onSignedOut(() => location.assign("/sign-in"));
listen();
followZoom();
void begin();

async function begin(): Promise<void> {
  if (id === null) return;
  try {
    opened = await openFit(client, id);
    const { landmarks } = opened;
    const clicks = keptClicks(sessionStorage.getItem(clicksHere(id)), landmarks);
    store.set({ landmarks, clicks, wanted: nextWanted({ landmarks, clicks }, null) });
    store.select(
      ({ clicks }) => ({ clicks }),
      ({ clicks }) => sessionStorage.setItem(clicksHere(id), JSON.stringify(clicks)),
    );
    await readPlan();
    setInterval(() => void readIfChanged(), LOOK_MS);
  } catch (error) {
    fail(error);
  }
}

async function readPlan(): Promise<void> {
  if (!opened) return;
  try {
    version = (await client.plan(opened.planLink)).version;
    store.set({ lines: await readLines(client, opened.fit), problem: null });
  } catch (error) {
    fail(error);
  }
}

async function readIfChanged(): Promise<void> {
  if (!opened || document.hidden) return;
  try {
    if ((await client.plan(opened.planLink)).version !== version) await readPlan();
  } catch {
    // what is shown stays; the next look may reach the service again
  }
}

/** The middle of what is planned, else of the landmarks: it is in the middle of the screen. */
function middleOf({ lines, landmarks }: ProjectorState): Vector {
  const points = lines && lines.length > 0 ? lines.flatMap((line) => line.points) : landmarks.map(({ point }) => point);
  return [0, 1, 2].map((axis) => points.reduce((sum, point) => sum + point[axis]!, 0) / Math.max(1, points.length)) as Vector;
}

function cameraOf(state: ProjectorState): { camera: Camera | null; direction: unknown } {
  if (!opened) return { camera: null, direction: null };
  if (state.mode === "projector") {
    const found = projectionOf(state);
    return { camera: typeof found === "string" ? null : found.camera, direction: state.clicks };
  }
  if (state.pixelsPerMm === null) return { camera: null, direction: null };
  const at: Place = [canvas.clientWidth / 2 + state.moved[0], canvas.clientHeight / 2 + state.moved[1]];
  return { camera: parallelCamera(opened.frame, state.side, state.pixelsPerMm, middleOf(state), at), direction: state.side };
}

/** Why nothing is drawn, and what to do; empty where lines are seen, or the tools say it. */
function whyEmpty({ lines, problem, areToolsHidden }: ProjectorState, hasCamera: boolean): string {
  if (id === null) return words.noFit;
  if (problem !== null) return areToolsHidden ? problem : "";
  if (lines === null) return words.opening;
  if (lines.length === 0) return words.noPlan;
  return areToolsHidden && !hasCamera ? words.notSet : "";
}

function draw(state: ProjectorState): void {
  const { camera, direction } = cameraOf(state);
  setText(empty, whyEmpty(state, camera !== null));
  picture.draw(opened?.bodies ?? null, { lines: state.lines ?? [], camera, hasOutline: state.hasOutline, hasColours: state.hasColours }, direction);
  show(ruler, state.mode === "scale" && state.pixelsPerMm !== null && !state.areToolsHidden);
  ruler.style.width = `${RULER_MM * (state.pixelsPerMm ?? 0)}px`;
  show(cross, state.mode === "projector" && state.wanted !== null && !state.areToolsHidden);
}

function moveCross(to: Place): void {
  cursor = [Math.min(innerWidth, Math.max(0, to[0])), Math.min(innerHeight, Math.max(0, to[1]))];
  cross.style.setProperty("--x", `${cursor[0]}px`);
  cross.style.setProperty("--y", `${cursor[1]}px`);
}

function setPlace(): void {
  store.set((state) => (state.mode === "projector" && !state.areToolsHidden ? withClick(state, cursor) : {}));
}

function listen(): void {
  let held: { readonly x: number; readonly y: number; readonly moved: Place } | null = null;
  moveCross([innerWidth / 2, innerHeight / 2]);
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    moveCross([event.clientX, event.clientY]);
    const state = store.get();
    if (state.mode === "projector") setPlace();
    else held = { x: event.clientX, y: event.clientY, moved: state.moved };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    moveCross([event.clientX, event.clientY]);
    if (held) store.set({ moved: [held.moved[0] + event.clientX - held.x, held.moved[1] + event.clientY - held.y] });
  });
  for (const kind of ["pointerup", "pointercancel"] as const) canvas.addEventListener(kind, () => (held = null));
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    const takesKey = key === "enter" ? "input, button" : "input"; // Enter presses the button that has the focus
    if (event.ctrlKey || event.metaKey || event.altKey || (event.target instanceof HTMLElement && event.target.closest(takesKey))) return;
    const arrow = ARROWS[event.key];
    const far = event.shiftKey ? 10 : 1;
    if (arrow && store.get().mode === "projector") moveCross([cursor[0] + far * arrow[0], cursor[1] + far * arrow[1]]);
    else if (arrow) store.set(({ moved }) => ({ moved: [moved[0] + far * arrow[0], moved[1] + far * arrow[1]] }));
    else if (key === "enter") setPlace();
    else if (key === "h" || (key === "escape" && !document.fullscreenElement)) store.set((state) => ({ areToolsHidden: !state.areToolsHidden }));
    else if (key === "f") void document.documentElement.requestFullscreen().catch(() => undefined);
    else return;
    event.preventDefault();
  });
}

/** Another zoom or another screen has other pixels: what was measured holds for one alone. */
function followZoom(): void {
  const read = (): void => {
    const kept = Number(localStorage.getItem(screenKey(screen, devicePixelRatio)));
    store.set({ pixelsPerMm: kept > 0 ? kept : null });
  };
  const wait = (): void => {
    const changed = (): void => {
      read();
      wait();
    };
    matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", changed, { once: true });
  };
  read();
  wait();
}

const clicksHere = (fit: string): string => clicksKey(fit, screenKey(screen, devicePixelRatio));

function remember(pixelsPerMm: number): void {
  localStorage.setItem(screenKey(screen, devicePixelRatio), String(pixelsPerMm));
}
