// A magnifier beside the pointer while a landmark is being placed, with a reticle where the click would land.
import { PerspectiveCamera } from "three";
import { el } from "../ui/dom";
import { quality } from "./graphics";
import { pickAt, type Surface } from "./picking";
import { Snapshot } from "./Snapshot";
import type { Viewer } from "./Viewer";
import { onceAFrame } from "./onceAFrame";

const SIZE = 132; // pixels on the screen, as in the style sheet
const ZOOM = 4;
const AWAY = 34; // pixels from the pointer to the loupe's edge

export class Loupe {
  private readonly canvas = el("canvas", { "aria-hidden": "true" });
  private readonly element = el("div", { class: "loupe", hidden: true }, this.canvas, el("span", { class: "reticle" }));
  private readonly camera = new PerspectiveCamera();
  private readonly snapshot: Snapshot;
  private isArmed = false;
  private pointer: { x: number; y: number } | null = null;
  private readonly later = onceAFrame(() => this.draw());

  constructor(
    private readonly viewer: Viewer,
    private readonly scan: Surface,
    canvas: HTMLCanvasElement,
  ) {
    this.snapshot = new Snapshot(viewer.renderer, SIZE * Math.min(window.devicePixelRatio, quality().pixelRatio));
    viewer.overlay.append(this.element);
    canvas.addEventListener("pointermove", (event) => {
      const isFree = event.pointerType !== "touch" && event.buttons === 0;
      this.ask(isFree ? { x: event.clientX, y: event.clientY } : null);
    });
    canvas.addEventListener("pointerdown", () => this.ask(null));
    canvas.addEventListener("pointerleave", () => this.ask(null));
    canvas.addEventListener("wheel", () => this.ask(null), { passive: true });
  }

  /** Whether it follows the pointer: while something is to be placed. */
  arm(isArmed: boolean): void {
    this.isArmed = isArmed;
    this.ask(this.pointer);
  }

  /** At page pixels, for whoever points without a pointer; null: nowhere. */
  look(at: { x: number; y: number } | null): void {
    this.ask(at);
  }

  private ask(pointer: { x: number; y: number } | null): void {
    this.pointer = pointer;
    if (pointer || !this.element.hidden) this.later();
  }

  private draw(): void {
    const at = this.isArmed ? this.pointer : null;
    const isOver = at !== null && pickAt(this.viewer, this.scan, at.x, at.y) !== null;
    this.element.hidden = !isOver;
    if (!isOver) return;
    const { host, camera, scene, palette } = this.viewer;
    const box = host.getBoundingClientRect();
    const [x, y] = [at.x - box.left, at.y - box.top];
    const part = SIZE / ZOOM;
    this.camera.copy(camera, false);
    this.camera.setViewOffset(box.width, box.height, x - part / 2, y - part / 2, part, part);
    this.camera.updateMatrixWorld();
    this.snapshot.draw(scene, this.camera, palette.canvas, this.canvas);
    const isHigh = y > SIZE + AWAY + 8;
    const left = Math.min(Math.max(x - SIZE / 2, 8), box.width - SIZE - 8);
    const top = isHigh ? y - AWAY - SIZE : y + AWAY;
    this.element.style.transform = `translate(${left.toFixed(0)}px, ${top.toFixed(0)}px)`;
  }
}
