// The picture itself: lines on black, and nothing else that could be taken for skin.
import type { BufferGeometry } from "three";
import type { Vector } from "../api/types";
import { type Camera, type Place, project } from "./camera";
import { onBlack, type PlannedLine } from "./state";
import { isSeen, outlineOf } from "./visible";

const LINE_PX = 3;
const OUTLINE_PX = 1;
const DASH_PX = [10, 8];
const OUTLINE = "#5a6570";

export interface Bodies {
  readonly skin: BufferGeometry; // of the scan, metres, with its tree
  readonly model: BufferGeometry; // fitted
}

interface Drawn {
  readonly lines: readonly PlannedLine[];
  readonly camera: Camera | null;
  readonly hasOutline: boolean;
  readonly hasColours: boolean;
}

export class Picture {
  private seen: { readonly key: readonly unknown[]; readonly lines: boolean[][]; readonly rims: [Vector, Vector][] } | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {}

  /** `direction`: what of the camera decides which points are seen; a picture that is only moved keeps them. */
  draw(bodies: Bodies | null, { lines, camera, hasOutline, hasColours }: Drawn, direction: unknown): void {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const times = window.devicePixelRatio;
    if (canvas.width !== Math.round(width * times)) canvas.width = Math.round(width * times);
    if (canvas.height !== Math.round(height * times)) canvas.height = Math.round(height * times);
    const pen = canvas.getContext("2d")!;
    pen.setTransform(times, 0, 0, times, 0, 0);
    pen.fillStyle = "#000000";
    pen.fillRect(0, 0, width, height);
    if (!bodies || !camera) return;
    const { lines: isSeenAt, rims } = this.look(bodies, lines, camera, direction);
    pen.lineCap = pen.lineJoin = "round";
    if (hasOutline) {
      pen.strokeStyle = OUTLINE;
      pen.lineWidth = OUTLINE_PX;
      pen.setLineDash([]);
      pen.beginPath();
      for (const [a, b] of rims) segment(pen, project(camera, a).at, project(camera, b).at);
      pen.stroke();
    }
    pen.lineWidth = LINE_PX;
    lines.forEach((line, n) => {
      const { points, closed, bridged, color } = line;
      pen.strokeStyle = hasColours ? onBlack(color) : "#ffffff";
      const places = points.map((point) => project(camera, point).at);
      for (const isDashed of [false, true]) {
        pen.setLineDash(isDashed ? DASH_PX : []);
        pen.beginPath();
        for (let i = 0; i < (closed ? places.length : places.length - 1); i += 1) {
          const next = (i + 1) % places.length;
          const isBridged = Boolean(bridged[i]) || Boolean(bridged[next]);
          if (isBridged === isDashed && isSeenAt[n]![i]! && isSeenAt[n]![next]!) segment(pen, places[i]!, places[next]!);
        }
        pen.stroke();
      }
    });
  }

  private look({ skin, model }: Bodies, lines: readonly PlannedLine[], camera: Camera, direction: unknown): { lines: boolean[][]; rims: [Vector, Vector][] } {
    const key = [skin, lines, direction];
    if (this.seen && key.every((each, i) => each === this.seen!.key[i])) return this.seen;
    this.seen = { key, lines: lines.map(({ points }) => points.map((point) => isSeen(skin, camera, point))), rims: outlineOf(model, camera) };
    return this.seen;
  }
}

function segment(pen: CanvasRenderingContext2D, a: Place, b: Place): void {
  pen.moveTo(a[0], a[1]);
  pen.lineTo(b[0], b[1]);
}
