// The hand on the canvas while a tool is taken: a drag draws, a short click sets a corner, a corner is dragged over the skin.
// The first button, a pen or one finger draw; the second button and two fingers turn the body.  A pen's other end erases.
import type { Vector } from "../../api/types";
import type { PageSlice } from "../../store/page";
import type { Store } from "../../store/store";
import type { Surface } from "../../viewer/picking";
import type { Viewer } from "../../viewer/Viewer";
import type { DrawingActions } from "../actions";
import type { CornerPins } from "./CornerPins";
import { cornerMoved } from "../lines/edits";
import { rejectPalms } from "./palms";
import { clickPen, skinAt } from "./penPlace";
import { gap } from "../lines/lines";
import { type HandStrokes, handStrokes } from "../lines/strokes";
import type { OwnLines } from "../lines/OwnLines";
import { type DrawingSlice, lineNamed } from "../state";

const STILL = 6; // pixels; less is a click
const NEAR_LINE = { fine: 12, finger: 22 }; // pixels from a line that still choose it
const ERASER = 5; // the button of a pen turned over

interface Held {
  readonly id: number;
  readonly x: number;
  readonly y: number;
  readonly corner: number | null;
  moved: boolean;
  at: Vector | null; // where the corner is held
  readonly drawn: HandStrokes | null; // of the pen
}

export function listenToPen(canvas: HTMLElement, viewer: Viewer, scan: Surface, own: OwnLines, pins: CornerPins, store: Store<PageSlice & DrawingSlice>, drawing: DrawingActions): void {
  let held: Held | null = null;
  const pointers = new Set<number>(); // that may draw
  const isDrawing = (): boolean => store.get().step === "plan" && store.get().drawn.tool !== "none";
  const palms = rejectPalms(canvas, isDrawing, () => {
    if (palms.hasPen !== store.get().hasPen) drawing.penSeen();
    follow();
  });
  const point = (event: { clientX: number; clientY: number }): Vector | null => skinAt(viewer, scan, drawing.skin(), event.clientX, event.clientY);

  function letGo(): void {
    held = null;
    own.show(null);
    pins.hold(null, null);
  }

  /** The own line under page pixels, and where. */
  function lineAt(event: PointerEvent): { name: string; at: Vector } | null {
    let best: { name: string; at: Vector; away: number } | null = null;
    const hit = point(event);
    const reach = event.pointerType === "touch" ? NEAR_LINE.finger : NEAR_LINE.fine;
    for (const line of store.get().drawn.lines.present) {
      for (const each of line.points) {
        if (hit && gap(hit, each) > 40) continue; // on the other side of the body
        const { x, y } = viewer.toPage(each);
        const away = Math.hypot(x - event.clientX, y - event.clientY);
        if (away <= reach && away < (best?.away ?? Infinity)) best = { name: line.name, at: each, away };
      }
    }
    return best;
  }

  function click(event: PointerEvent): void {
    const { tool, chosen } = store.get().drawn;
    const at = point(event);
    if (tool === "erase" || event.button === ERASER) {
      const line = lineAt(event);
      if (line) drawing.erase(line.name);
    } else if (tool === "points") {
      const line = lineAt(event);
      if (!line) drawing.chooseCorner(null);
      else if (line.name !== chosen) drawing.choose(line.name);
      else drawing.addCorner(line.name, line.at);
    } else if (at && tool === "pen") clickPen(at, store.get().drawn, drawing);
    else if (at && tool === "tumour") drawing.tumour(at);
    else if (at && tool === "tape") drawing.measure(at);
  }

  function move(event: PointerEvent, now: Held): void {
    const { drawn } = store.get();
    if (now.corner !== null) {
      const line = lineNamed(drawn, drawn.chosen);
      const skin = drawing.skin();
      const to = point(event);
      if (!line || !skin || !to) return; // beside the body it stays where it was
      now.at = to;
      pins.hold(now.corner, to);
      own.show({ ...line, points: cornerMoved(skin, line, now.corner, to).points }, line.name);
      return;
    }
    if (drawn.tool !== "pen") return;
    const all = (event as Partial<Pick<PointerEvent, "getCoalescedEvents">>).getCoalescedEvents?.() ?? []; // older Safaris have none
    for (const each of all.length > 0 ? all : [event]) {
      now.drawn?.add(point(each));
    }
    own.showStrokes(now.drawn?.strokes() ?? [], drawn.ink);
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (!palms.mayDraw(event.pointerType)) return;
    pointers.add(event.pointerId);
    if (pointers.size > 1) letGo(); // two fingers turn
    if (pointers.size > 1 || !isDrawing() || (event.button !== 0 && event.button !== ERASER)) return;
    const { tool } = store.get().drawn;
    const corner = tool === "points" ? pins.at(event.clientX, event.clientY) : null;
    const skin = tool === "pen" && event.button === 0 ? drawing.skin() : null;
    const drawn = skin && handStrokes(skin);
    drawn?.add(point(event));
    held = { id: event.pointerId, x: event.clientX, y: event.clientY, corner, moved: false, at: null, drawn };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held && isDrawing() && event.buttons === 0) canvas.classList.toggle("is-over-pin", pins.at(event.clientX, event.clientY) !== null);
    if (event.pointerId !== held?.id) return;
    held.moved ||= Math.hypot(event.clientX - held.x, event.clientY - held.y) >= STILL;
    if (held.moved) move(event, held);
  });
  canvas.addEventListener("pointerup", (event) => {
    pointers.delete(event.pointerId);
    if (event.pointerId !== held?.id) return;
    const done = held;
    const { drawn } = store.get();
    letGo();
    if (!isDrawing()) return;
    const isErasing = drawn.tool === "erase" || event.button === ERASER;
    if (!done.moved || isErasing) {
      if (done.corner !== null) drawing.chooseCorner(done.corner);
      else click(event);
    } else if (done.corner !== null && drawn.chosen !== null && done.at) drawing.moveCorner(drawn.chosen, done.corner, done.at);
    else if (done.corner === null && drawn.tool === "pen") drawing.strokes(done.drawn?.strokes() ?? []);
  });
  canvas.addEventListener("pointercancel", (event) => {
    pointers.delete(event.pointerId);
    if (event.pointerId === held?.id) letGo();
  });

  /** What turns the body. */
  function follow(): void {
    viewer.drawWith(!isDrawing() ? "nothing" : palms.areFingersFree ? "pen" : "anything");
    viewer.mayTurn = !(isDrawing() && palms.isPenDown);
  }

  store.select(
    ({ step, drawn: { tool }, fingersDraw }) => ({ step, tool, fingersDraw }),
    ({ tool, fingersDraw }) => {
      palms.fingersDraw = fingersDraw;
      const isOn = isDrawing();
      follow();
      canvas.classList.toggle("is-drawing", isOn && tool !== "points");
    },
  );
}
