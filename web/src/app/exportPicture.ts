// The picture as it stands, for a slide or a paper: twice the size, with the letters, a 10 cm scale, the colours' scale
// where distances are shown, and what it must not be used for.  No date and no name: nothing in it identifies the patient.
import { paintColourScale, signedMm } from "../fit/distances/ColourBar";
import { SCALE_MM, SCANNER_MM } from "../fit/distances/distances";
import { fingersMark, fingersOf, wideOf } from "../fit/fingers";
import { showsFittedSurface } from "../fit/state";
import { distances as distancesText } from "../fit/text";
import { marginOf } from "../fit/verdict";
import { name, notice } from "../ui/text";
import { metresFromMm } from "../ui/units";
import { view as viewText } from "../viewer/text";
import type { Viewer } from "../viewer/Viewer";
import type { Session } from "./session";
import * as text from "./text";

const TIMES = 2;
const SCALE_BAR_MM = 100;
const FOOT = 34; // pixels below the picture, for scale and notice

/** What stands on the stage, from left to right; the title says which stance it is, where there are two. */
export interface Pane {
  readonly viewer: Viewer;
  readonly title: string;
  readonly lines: number | null | undefined; // mm, how sure lines are on it; null: not known, undefined: there is no fit
}

/** PNG bytes of all panes beside each other, with one legend. */
export function exportPicture(panes: readonly Pane[], state: Session): Promise<Blob> {
  const [main] = panes;
  if (!main) return Promise.reject(new Error("no view"));
  const width = panes.reduce((sum, { viewer }) => sum + viewer.host.clientWidth, 0);
  const height = Math.max(...panes.map(({ viewer }) => viewer.host.clientHeight));
  const canvas = document.createElement("canvas");
  canvas.width = TIMES * width;
  canvas.height = TIMES * (height + FOOT);
  const pen = canvas.getContext("2d")!;
  const colour = coloursOf(main.viewer.host);
  pen.scale(TIMES, TIMES);
  pen.fillStyle = colour("--view-canvas");
  pen.fillRect(0, 0, width, height + FOOT);
  pen.textBaseline = "middle";
  let left = 0;
  for (const { viewer, title, lines } of panes) {
    const { clientWidth: wide, clientHeight: high } = viewer.host;
    pen.save();
    pen.translate(left, 0);
    viewer.drawAt(TIMES, (picture) => pen.drawImage(picture, 0, 0, wide, high));
    drawLetters(pen, viewer.overlay, colour);
    drawScaleBar(pen, 16, height + FOOT / 2, viewer.pixelsPerMetre * metresFromMm(SCALE_BAR_MM), colour);
    pen.font = font(15, 600);
    pen.textAlign = "left";
    pen.fillText(title, 16, 24);
    if (lines !== undefined) drawFingers(pen, 16 + (title === "" ? 0 : pen.measureText(title).width + 12), lines);
    pen.restore();
    left += wide;
  }
  if (state.showDistances && showsFittedSurface(state) && state.overlay !== "scan") drawColours(pen, height, colour);
  pen.fillStyle = colour("--text");
  pen.font = font(12, 600);
  pen.textAlign = "right";
  pen.fillText(`${name} · ${notice}`, width - 16, height + FOOT / 2);
  return new Promise((done, failed) => canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error("no picture"))), "image/png"));
}

/** How wide lines are, as the pane's mark has it. */
function drawFingers(pen: CanvasRenderingContext2D, left: number, mm: number | null): void {
  const mark = fingersMark(fingersOf(mm));
  pen.save();
  pen.translate(left, 14);
  for (const bar of mark.querySelectorAll("rect")) {
    const [x, y, width, height, radius] = ["x", "y", "width", "height", "rx"].map((name) => Number(bar.getAttribute(name))) as [number, number, number, number, number];
    pen.beginPath();
    pen.roundRect(x, y, width, height, radius);
    pen.fill();
  }
  if (fingersOf(mm) === null) {
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(9, 10, 7.5, 0, 2 * Math.PI);
    pen.stroke();
    pen.stroke(new Path2D(mark.querySelector("path")!.getAttribute("d")!));
  }
  pen.restore();
  pen.font = font(13);
  pen.fillText([wideOf(mm), ...(fingersOf(mm) === null ? [] : [marginOf(mm!)])].join("  "), left + 26, 24);
}

type Colour = (name: string) => string;

const font = (size: number, weight = 400): string => `${weight} ${size}px ${getComputedStyle(document.body).fontFamily}`;

/** What a variable of the style sheet comes to in the theme that holds. */
function coloursOf(host: HTMLElement): Colour {
  const probe = document.createElement("span");
  return (name) => {
    host.append(probe);
    probe.style.color = `var(${name})`;
    const { color } = getComputedStyle(probe);
    probe.remove();
    return color;
  };
}

/** L and R where they stand on the screen. */
function drawLetters(pen: CanvasRenderingContext2D, overlay: HTMLElement, colour: Colour): void {
  const origin = overlay.getBoundingClientRect();
  pen.textAlign = "center";
  for (const letter of overlay.querySelectorAll<HTMLElement>(".letter:not([hidden], .is-far)")) {
    const box = letter.querySelector("strong")!.getBoundingClientRect();
    const [x, y, radius] = [box.left + box.width / 2 - origin.left, box.top + box.height / 2 - origin.top, box.width / 2];
    const isLeft = letter.classList.contains("side-left");
    pen.strokeStyle = pen.fillStyle = colour(isLeft ? "--left" : "--right");
    pen.lineWidth = 2;
    pen.beginPath();
    if (isLeft) pen.arc(x, y, radius, 0, 2 * Math.PI);
    else pen.roundRect(x - radius, y - radius, 2 * radius, 2 * radius, 6);
    pen.stroke();
    pen.font = font(17, 700);
    pen.fillText(isLeft ? "L" : "R", x, y + 1);
    pen.font = font(11);
    pen.fillText(isLeft ? viewText.left : viewText.right, x, y + radius + 11);
  }
}

/** As long as 10 cm are at the middle of the body. */
function drawScaleBar(pen: CanvasRenderingContext2D, left: number, y: number, length: number, colour: Colour): void {
  pen.strokeStyle = pen.fillStyle = colour("--text");
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(left, y - 5);
  pen.lineTo(left, y + 5);
  pen.moveTo(left, y);
  pen.lineTo(left + length, y);
  pen.moveTo(left + length, y - 5);
  pen.lineTo(left + length, y + 5);
  pen.stroke();
  pen.font = font(12);
  pen.textAlign = "left";
  pen.fillText(text.files.scale, left + length + 8, y);
}

function drawColours(pen: CanvasRenderingContext2D, height: number, colour: Colour): void {
  const [left, top, wide, high] = [16, height - 212, 14, 160];
  const bar = document.createElement("canvas");
  [bar.width, bar.height] = [TIMES * wide, TIMES * high];
  paintColourScale(bar);
  pen.fillStyle = colour("--muted");
  pen.font = font(11);
  pen.textAlign = "left";
  pen.fillText(distancesText.title, left, top - 14);
  pen.drawImage(bar, left, top, wide, high);
  const notes: Record<number, string> = { [SCALE_MM]: distancesText.outside, 0: distancesText.scanner, [-SCALE_MM]: distancesText.inside };
  for (const mm of [SCALE_MM, SCANNER_MM, 0, -SCANNER_MM, -SCALE_MM]) {
    const y = top + (high * (SCALE_MM - mm)) / (2 * SCALE_MM);
    pen.fillStyle = colour("--text");
    pen.fillText(signedMm(mm), left + wide + 8, y);
    pen.fillStyle = colour("--muted");
    if (notes[mm]) pen.fillText(notes[mm], left + wide + 34, y);
  }
  pen.fillStyle = colour("--view-unknown");
  pen.fillRect(left, top + high + 12, wide, wide);
  pen.fillStyle = colour("--muted");
  pen.fillText(distancesText.noScan, left + wide + 8, top + high + 12 + wide / 2);
}
