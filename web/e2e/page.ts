// What the browser tests share: the page with its record of errors, and the example patient's files.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { type CDPSession, expect, type Locator, type Page, test as plain } from "@playwright/test";
import type { LandmarkFile, Vector } from "../src/api/types";
import { mmFrom } from "../src/ui/units";
import "./words";

const EXAMPLE = resolve(import.meta.dirname, "../../model_assets/example/standing");
export const SCAN_FILE = join(process.env.BREASTRIG_E2E_EXAMPLES ?? "", "standing", "scan.ply"); // the service's own

/** The example's landmarks in millimetres, scan's frame. */
export function trueLandmarks(): Record<string, Vector> {
  const file = JSON.parse(readFileSync(join(EXAMPLE, "landmarks.json"), "utf8")) as LandmarkFile;
  const entries = Object.entries(file.landmarks);
  return Object.fromEntries(entries.map(([name, point]) => [name, point.map((value) => mmFrom(value, file.unit ?? "mm")) as Vector]));
}

/** A page that reports errors in its console and requests to anywhere else. */
export const test = plain.extend<{ base: string; troubles: string[]; fitsAtOnce: boolean }>({
  fitsAtOnce: [false, { option: true }], // as most tests want it: nothing is fitted before they ask for it
  page: async ({ page, fitsAtOnce }, use) => {
    if (!fitsAtOnce) await page.addInitScript(() => {
      if (location.protocol === "http:") localStorage.setItem("breastrig.fits-at-once", "no");
    });
    await use(page);
  },
  base: async ({}, use) => use(process.env.BREASTRIG_E2E_BASE!),
  troubles: async ({ page, base }, use) => {
    const troubles: string[] = [];
    page.on("console", (message) => {
      // The first page shows everybody's patients, and other tests delete theirs while it is read.
      if (message.type() === "error" && !message.location().url.endsWith("/thumbnail.png")) troubles.push(`console: ${message.text()} ${message.location().url}`);
    });
    page.on("pageerror", (error) => troubles.push(`error: ${error.message}`));
    page.on("request", (request) => {
      const url = new URL(request.url());
      if (url.origin !== base && url.protocol !== "blob:" && url.protocol !== "data:") troubles.push(`outside: ${url.href}`);
    });
    await use(troubles);
  },
});

/** Waits until it is so, and looks ten times a second: looking at every frame makes the browser draw frames for nothing else. */
export const until = <Given>(page: Page, isSo: (given: Given) => unknown, given?: Given) => page.waitForFunction(isSo as () => unknown, given, { polling: 100 });

export const hook = {
  ready: (page: Page) => until(page, () => window.__breastrig?.isReady()),
  project: (page: Page, point: Vector) => page.evaluate((at) => window.__breastrig!.project(at), point),
  pick: (page: Page, name: string) => page.evaluate((key) => window.__breastrig!.state().picks.present[key] ?? null, name),
  pickCount: (page: Page) => page.evaluate(() => Object.keys(window.__breastrig!.state().picks.present).length),
  picture: (page: Page) => page.evaluate(() => window.__breastrig!.picture()),
  /** All but the fits' surfaces, which are long on their way. */
  state: (page: Page) =>
    page.evaluate(() => {
      const all = window.__breastrig!.state();
      const light = <Part extends { readonly fit: typeof all.fit }>(part: Part): Part => ({ ...part, fit: part.fit && { ...part.fit, surface: null, distances: null } });
      return { ...light(all), stances: { ...all.stances, other: all.stances.other && light(all.stances.other) } };
    }),
  fit: (page: Page) =>
    page.evaluate(() => {
      const { fit } = window.__breastrig!.state();
      return fit && { id: fit.id, state: fit.state, shown: fit.shown, iterations: fit.iterations.length, reason: fit.reason };
    }),
};

/** Lets files go over the page, as a hand does that holds them. */
export async function drop(page: Page, files: readonly { readonly name: string; readonly path: string }[]): Promise<void> {
  const held = files.map(({ name, path }) => ({ name, bytes: readFileSync(path).toString("base64") }));
  await page.evaluate((all) => {
    const data = new DataTransfer();
    for (const { name, bytes } of all) data.items.add(new File([Uint8Array.from(atob(bytes), (letter) => letter.charCodeAt(0))], name));
    for (const kind of ["dragenter", "drop"]) document.querySelector(".stages")!.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
  }, held);
}

/** Opens one of the menus on the stage's bar or in the top bar, presses what is called so, and closes it. */
async function inMenu(page: Page, id: string, name: string): Promise<void> {
  await page.locator(`[popovertarget=${id}]`).click();
  await page.locator(`#${id}`).getByRole("button", { name: new RegExp(`^${name}`) }).click();
  if (await page.locator(`#${id}`).isVisible()) await page.keyboard.press("Escape");
}

interface Made {
  readonly id: string;
  readonly patient: string;
  readonly links: Readonly<Record<string, string>>;
}

/**
 * Opens the example patient with scans that the service has fitted before, the first one to be worked on; how a person comes
 * there is a question of other tests.  Without `landmarks` nobody has placed any; the example's are the default, on each scan.
 */
export async function fittedExample(page: Page, base: string, { stances = ["standing"], step = "plan", landmarks = {}, fit = {} }: { stances?: readonly ("standing" | "supine")[]; step?: "body" | "points" | "plan" | "handover"; landmarks?: Record<string, Vector> | null; fit?: object } = {}): Promise<{ scan: Made; fit: Made }[]> {
  const send = async <Body>(method: "post" | "put" | "get", path: string, data?: object): Promise<Body> => {
    const answer = await page.request[method](base + path, data ? { data } : {});
    expect(answer.ok(), `${method} ${path}: ${answer.status()}`).toBe(true);
    return (await answer.json()) as Body;
  };
  const made: { scan: Made; fit: Made }[] = [];
  for (const [i, stance] of stances.entries()) {
    const scan = await send<Made & { example_landmarks: LandmarkFile }>("post", `/api/examples/${stance}`);
    if (made[0]) await send("put", `/api/scans/${scan.id}/patient`, { patient: made[0].scan.patient, ...(stances.indexOf(stance) < i ? { again: true } : {}) });
    const placed = landmarks && { ...scan.example_landmarks.landmarks, ...landmarks };
    if (placed) await send("put", scan.links.landmarks!, { unit: "mm", landmarks: placed });
    made.push({ scan, fit: await send<Made>("post", "/api/fits", { scan: scan.id, ...(placed ? { landmarks: placed } : {}), ...fit }) });
  }
  for (const each of made) await expect.poll(async () => (await send<{ state: string }>("get", each.fit.links.self!)).state).toBe("done");
  const [here, other] = made;
  await page.goto(`${base}/#scan=${here!.scan.id}&fit=${here!.fit.id}&step=${step}${other ? `&other=${other.scan.id}&otherfit=${other.fit.id}` : ""}`);
  await hook.ready(page);
  await untilFitted(page);
  return made;
}

/** A scan of the example patient, as the first page offers it. */
export async function example(page: Page, name: "standing" | "supine" = "standing"): Promise<void> {
  await page.locator("[popovertarget=example-menu]").click();
  await page.locator(`#example-menu [data-example=${name}]`).click();
}
/** What of scan and model is shown, or what else can be switched on the stage. */
export const look = (page: Page, name: "Skin" | "Both" | "Model" | "Distances" | "Left on right" | "Table and loose pieces" | "Turn both together" | "The scan's own colours"): Promise<void> => inMenu(page, "look-menu", name);
/** From which side the body is seen. */
export const lookFrom = (page: Page, side: "Front" | "Left" | "Right" | "Back" | "Top"): Promise<void> => inMenu(page, "view-menu", side);
export const more = (page: Page, name: string): Promise<void> => inMenu(page, "page-menu", name);
/** Opens the dialog that makes links. */
export async function openShare(page: Page): Promise<void> {
  await hook.ready(page);
  await page.locator("#tab-handover").click();
  await page.locator("#share").click();
}
/** Presses what is called so in the plan's menu of what may be added. */
export async function addToPlan(page: Page, name: RegExp): Promise<void> {
  await page.locator("[popovertarget=add-menu]").click();
  await page.locator("#add-menu").getByRole("button", { name }).click();
}
/** An item's row in the plan, and what stands below the list for the chosen one. */
export const planItem = (page: Page, name: string | RegExp): Locator => page.locator(".plan-item").filter({ hasText: name });
export const details = (page: Page): Locator => page.locator(".item-details");
/** A number of the chosen pattern, on one side. */
export const numberField = (page: Page, name: string, side: "L" | "R" | "" = "L"): Locator => page.locator(`.item-details [data-side="${side}"] [data-parameter=${name}]`);
/** What is taken away as files, folded away beside the printed pages. */
export async function openFiles(page: Page): Promise<void> {
  await page.keyboard.press("4");
  await page.locator(".file-list > summary").click();
}
/** A scan on the strip. */
export const thumb = (page: Page, stance: "standing" | "supine" | "prone" | "image"): Locator => page.locator(`.thumb[data-stance=${stance}]`);
/** Opens the details of the body's tab. */
export async function openDetails(page: Page): Promise<void> {
  await page.keyboard.press("1");
  const details = page.locator("#details");
  if ((await details.getAttribute("open")) === null) await details.locator("> summary").click();
}

/** Waits until no camera moves and nothing is drawn any more, however seldom a busy machine draws: then places on the screen hold still. */
export const untilStill = async (page: Page): Promise<void> => {
  await page.evaluate(() => (document.documentElement.dataset.frames = ""));
  await page.waitForFunction(
    () => {
      const { dataset } = document.documentElement;
      const frames = String(window.__breastrig!.frames());
      const isStill = window.__breastrig!.isAtRest() && frames === dataset.frames;
      dataset.frames = frames;
      return isStill;
    },
    undefined,
    { polling: 150 },
  );
};

/** Before the page is opened: what it sends ten seconds late it does not send by itself, however long a busy machine takes. */
export async function withoutEndOfTime(page: Page): Promise<void> {
  await page.addInitScript(() => {
    const later = window.setTimeout.bind(window);
    Object.assign(window, { setTimeout: (act: () => void, ms?: number) => (ms === 10_000 ? 0 : later(act, ms)) });
  });
}

/** Waits until the fit, the one just asked for if there is one, is over and its last iteration and drawing are on the screen. */
export async function untilFitted(page: Page): Promise<void> {
  await until(page, () => {
    const { fit, isStarting } = window.__breastrig!.state();
    return fit && !isStarting && fit.state !== "running" && !fit.playing && (fit.state !== "done" || fit.drawing !== null || fit.drawingName === null);
  });
  expect(await hook.fit(page)).toMatchObject({ state: "done" });
}

export const distance = (a: Vector, b: Vector): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

type Finger = readonly { x: number; y: number }[];
export type FingerEvent = readonly ["touchStart" | "touchMove" | "touchEnd", Finger];

/** Sends what fingers do as one burst: awaited one by one, a tap would last as long as a busy page takes to answer. */
export async function touch(session: CDPSession, ...events: FingerEvent[]): Promise<void> {
  const points = (fingers: Finger) => fingers.map(({ x, y }, id) => ({ x, y, id }));
  await Promise.all(events.map(([type, fingers]) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points(fingers) })));
}

export const tapAt = (session: CDPSession, place: { x: number; y: number }): Promise<void> => touch(session, ["touchStart", [place]], ["touchEnd", []]);

/**
 * Taps, and waits for the click that the browser makes of it a moment later.  A busy browser may take a tap for a part of the
 * gesture before it, and make no click of it: a person taps again then, and so does this.
 */
export async function tap(place: Locator): Promise<void> {
  await place.scrollIntoViewIfNeeded(); // once it is visible and holds still
  await expect(place).toBeEnabled();
  const click = place.evaluate((element) => new Promise<true>((clicked) => element.addEventListener("click", () => clicked(true), { once: true })));
  const session = await place.page().context().newCDPSession(place.page());
  for (let taps = 1; ; taps += 1) {
    const { x, y, width, height } = (await place.boundingBox())!;
    await tapAt(session, { x: x + width / 2, y: y + height / 2 });
    const clicked = await Promise.race([click, new Promise<false>((late) => setTimeout(() => late(false), 10_000))]);
    if (clicked || taps === 3) break;
  }
  await click;
  await session.detach();
}
