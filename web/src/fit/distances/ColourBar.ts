// What the colours of the distance map mean, drawn by the same function that colours the map.
import type { PageSlice } from "../../store/page";
import { only } from "../../store/store";
import { el, show } from "../../ui/dom";
import type { Panel } from "../../ui/Panel";
import type { ViewSlice } from "../../viewer/state";
import { SCALE_MM, SCANNER_MM, screenColourOf } from "./distances";
import { type FitSlice, showsFittedSurface } from "../state";
import * as text from "../text";

// Twice the size on the screen: sharp on dense displays too.
const WIDTH = 28;
const HEIGHT = 320;
const HATCH = 12;
const words = text.distances;

export const signedMm = (mm: number): string => (mm > 0 ? `+${mm}` : mm < 0 ? `\u2212${-mm}` : "0");

type Shown = Pick<PageSlice & ViewSlice & FitSlice, "overlay" | "meta" | "models" | "fit" | "followed" | "showDistances">;

export function createColourBar(): Panel<Shown> {
  const canvas = el("canvas", { width: WIDTH, height: HEIGHT, role: "img", "aria-label": words.bar(SCALE_MM, SCANNER_MM) });
  const tick = (mm: number, note: string): HTMLElement => el("li", {}, el("span", {}, signedMm(mm)), note === "" ? null : el("small", {}, note));
  const ticks = el(
    "ol",
    { class: "ticks", "aria-hidden": "true" },
    tick(SCALE_MM, words.outside),
    tick(SCANNER_MM, ""),
    tick(0, words.scanner),
    tick(-SCANNER_MM, ""),
    tick(-SCALE_MM, words.inside),
  );
  const element = el(
    "div",
    { class: "colour-bar", hidden: true },
    el("p", {}, words.title),
    el("div", { class: "scale" }, canvas, ticks),
    el("div", { class: "no-scan" }, el("span", { "aria-hidden": "true" }), words.noScan),
  );
  paintColourScale(canvas);
  return {
    element,
    select: only("overlay", "meta", "models", "fit", "followed", "showDistances"),
    update(state: Shown): void {
      show(element, state.showDistances && showsFittedSurface(state) && state.overlay !== "scan");
    },
  };
}

/** Colours and hatching, as large as a canvas of WIDTH by HEIGHT. */
export function paintColourScale(canvas: HTMLCanvasElement): void {
  const context = canvas.getContext("2d");
  if (!context) return;
  for (let y = 0; y < HEIGHT; y += 1) {
    context.fillStyle = `rgb(${screenColourOf(SCALE_MM * (1 - (2 * (y + 0.5)) / HEIGHT)).join(" ")})`;
    context.fillRect(0, y, WIDTH, 1);
  }
  const half = (HEIGHT * SCANNER_MM) / (2 * SCALE_MM);
  context.beginPath();
  context.rect(0, HEIGHT / 2 - half, WIDTH, 2 * half);
  context.clip();
  context.strokeStyle = "rgb(0 0 0 / 28%)";
  context.lineWidth = 2;
  context.beginPath();
  for (let y = 0; y < HEIGHT + WIDTH; y += HATCH) {
    context.moveTo(0, y);
    context.lineTo(WIDTH, y - WIDTH);
  }
  context.stroke();
}
