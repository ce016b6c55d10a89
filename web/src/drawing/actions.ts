// Drawing on the scan: each change is one step of the undo history and is saved with the scan soon after.
import type { Client } from "../api/client";
import type { Scan, Vector } from "../api/types";
import type { FitSlice } from "../fit/state";
import type { LandmarksSlice } from "../landmarks/state";
import { landmarks as landmarkText } from "../landmarks/text";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { formatMmWhole } from "../ui/units";
import type { ViewSlice } from "../viewer/state";
import { planChanges } from "./changes";
import { closedUp, cornerAdded, cornerMoved, cornerRemoved, extended, lineAlong, lineThrough, openedUp } from "./lines/edits";
import { isAnothers, readDrawing, UnreadableDrawing, whoseIs } from "./lines/files";
import { freeName, gap, newId, nextName, type OwnLine, TUMOUR_INK, withLine, withoutLine } from "./lines/lines";
import { mirroredLine, mirrorPlane } from "./mirror/mirror";
import type { Skin } from "./lines/skin";
import { type DrawingSlice, type DrawnState, handsOff, type InkDecided, type Layer, layerKey, lineNamed, type PlanHistory, type PlanStep, stepOf, type Tool, withStep } from "./state";
import { circle, freehand } from "./lines/strokes";
import { type SlicesState, withSlices } from "./slices/state";
import { type Tape, tapeAsked, tapeBack, tapeFrom, tapeMeasured, tapeTo } from "./tape/tape";
import * as text from "./text";

type State = PageSlice & ViewSlice & ScanSlice & LandmarksSlice & FitSlice & DrawingSlice;

const PAUSE_MS = 400; // a run of quick strokes is one save
const CLOSES_MM = 8; // a click, or a stroke's end, so near to the line's start closes it
export const RADIUS_MM = { least: 1, most: 80 }; // what the model's own tumour circle takes as well

/** Where lines are kept: the patient's plan. */
export interface KeepsLines {
  /** As the page shows the scan by then, or as it was left; says in the state whether that worked. */
  save(scan: Scan): Promise<void>;
  /** What the plan says about the scan before it said this; null when nothing earlier is known. */
  earlier(scan: Scan, now: PlanStep): Promise<PlanStep | null>;
}

const OFF_THE_SKIN_MM = 10; // as the service has it: what lies farther off is of another scan, frame or unit
const MOVED_MM = 1; // less is the mesh that is shown, and not said

export function drawingActions(store: Store<State>, client: Pick<Client, "lengths">, plan: KeepsLines) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let waiting: Scan | null = null;
  let onItsWay: Promise<unknown> = Promise.resolve();
  let skin: () => Skin | null = () => null; // the view has the mesh

  const drawn = (): DrawnState => store.get().drawn;
  const lines = (): readonly OwnLine[] => drawn().lines.present;
  /** The last leg on the fitted skin, where the service's own measures are taken: one number for one length. */
  async function measureOn(fit: string, asked: Tape): Promise<void> {
    const leg = asked.legs.at(-1)!;
    try {
      const { legs } = await client.lengths(fit, asked.places.slice(-2));
      const { tape } = drawn();
      if (!tape?.legs.includes(leg)) return;
      const now = tapeMeasured(tape, leg, legs[0] as { mm: number; points: Vector[] });
      put({ tape: now }, { announcement: text.tape.says(now) });
    } catch (error) {
      const { tape } = drawn();
      if (tape?.legs.includes(leg)) store.set((state) => ({ ...withProblem(state, "drawing", messageOf(error)), drawn: { ...state.drawn, tape: tapeBack(tape) } }));
    }
  }

  const put = (part: Partial<DrawnState>, more: Partial<State> = {}): void => store.set((state) => ({ ...more, ...(part.chosen ? { lesion: null } : {}), drawn: { ...state.drawn, ...part } }));

  /** What waits is sent, and what is on its way has come. */
  async function flush(): Promise<void> {
    clearTimeout(timer);
    const scan = waiting;
    waiting = null;
    if (scan) onItsWay = Promise.all([onItsWay, plan.save(scan)]);
    await onItsWay;
  }

  function saveSoon(): void {
    const { scan } = store.get();
    if (!scan) return;
    if (waiting && waiting.id !== scan.info.id) void flush();
    clearTimeout(timer);
    waiting = scan.info;
    put({ saving: "unsaved" });
    timer = setTimeout(() => void flush(), PAUSE_MS);
  }

  function change(next: readonly OwnLine[], part: Partial<DrawnState>, announcement: string): void {
    put({ ...part, lines: { ...withStep(store.get()), present: next } }, { announcement });
    saveSoon();
  }

  /** Back or forth: all that the step holds is as it was then.  What is not a line is kept by plan/actions.ts. */
  function goTo(step: PlanStep, history: Omit<PlanHistory, "present">, isBack: boolean): void {
    const now = stepOf(store.get());
    const { meta } = store.get();
    const named = [...(meta?.patterns ?? []), ...(meta?.drawings ?? [])];
    const changes = isBack ? planChanges(step, now, named) : planChanges(now, step, named);
    const says = (isBack ? landmarkText.undone : landmarkText.redone)(changes);
    put({ lines: { ...history, present: step.lines }, note: step.note, depthMm: step.depthMm, lesions: step.lesions, decided: step.decided ?? drawn().decided, start: null, corner: null }, { drawing: step.drawing, announcement: "", undone: { says } });
  }

  function add(line: OwnLine, announcement: string, part: Partial<DrawnState> = {}): void {
    change([...lines(), { ...line, id: newId() }], { start: null, open: null, chosen: line.name, corner: null, ...part }, announcement);
  }

  function edit(name: string, changed: (line: OwnLine, on: Skin) => OwnLine | null, announcement: string, part: Partial<DrawnState> = {}): void {
    const line = lineNamed(drawn(), name);
    const on = skin();
    const next = line && on ? changed(line, on) : null;
    if (next && next !== line) change(withLine(lines(), name, () => next), part, announcement);
  }

  const words = text.drawing;

  /** Lines of a file, on the skin; those that lie farther off than a file may are left out, and it is said. */
  function take(read: readonly OwnLine[]): void {
    const on = skin();
    const laid = read.map((line) => laidOnSkin(on, line));
    const taken = laid.filter(({ away }) => away <= OFF_THE_SKIN_MM);
    const out = laid.filter((each) => !taken.includes(each));
    if (taken.length === 0 && out[0]) throw new UnreadableDrawing(words.elsewhere(out[0].line.name, out[0].away));
    const all = [...lines()];
    for (const { line } of taken) all.push({ ...line, id: newId(), name: freeName(all, line.name) });
    const moved = Math.max(0, ...taken.map(({ away }) => away));
    const remark = words.imported(taken.length, moved > MOVED_MM ? moved : 0, out.map(({ line }) => line.name));
    store.set((state) => withProblem(state, "drawing", moved > MOVED_MM || out.length > 0 ? remark : null));
    change(all, { start: null, open: null, chosen: null, corner: null }, remark);
  }

  return {
    /** Set by the view: how to reach the surface of the scan on the screen. */
    setSkin: (now: () => Skin | null): void => void (skin = now),
    skin: (): Skin | null => skin(),

    penSeen: (): void => store.set({ hasPen: true, announcement: text.canvas.pen }),
    drawWithFingers: (fingersDraw: boolean): void => store.set({ fingersDraw, announcement: fingersDraw ? text.canvas.fingersDraw : text.canvas.pen }),

    take: (tool: Tool): void => {
      const chosen = tool === "points" ? (drawn().chosen ?? lines().at(-1)?.name ?? null) : drawn().chosen;
      store.set((state) => ({
        step: tool === "none" ? state.step : "plan",
        active: null,
        drawn: { ...state.drawn, tool, start: null, open: null, tape: null, chosen, corner: null },
        announcement: words.hints[tool],
      }));
    },

    /** A short click of the pen: the first corner, the next one, or the one that closes the line. */
    click(at: Vector): void {
      const on = skin();
      if (!on) return;
      const { open, start } = drawn();
      const line = lineNamed(drawn(), open);
      if (line) {
        const closes = line.corners.length > 2 && gap(at, line.points[0]!) < CLOSES_MM;
        if (closes) edit(line.name, (own) => closedUp(on, own), words.announceClosed(line.name), { open: null });
        else edit(line.name, (own) => extended(on, own, at), words.announceCorner(line.corners.length + 1));
      } else if (start) {
        if (gap(start, at) < 1) return;
        const name = nextName(lines(), words.stem);
        add(lineThrough(on, name, drawn().ink, start, at), words.announceCorner(2), { open: name });
      } else put({ start: at, chosen: null, corner: null }, { announcement: words.announceCorner(1) });
    },

    /** One movement of the pen, cut where it left the skin: as many lines, and one step to undo.  What comes back to its start is closed. */
    strokes(hand: readonly (readonly Vector[])[]): void {
      const on = skin();
      if (!on) return;
      const all = [...lines()];
      const names: string[] = [];
      for (const hits of hand) {
        const line = strokeOn(on, hits, nextName(all, words.stem), drawn().ink);
        if (!line) continue;
        all.push({ ...line, id: newId() });
        names.push(line.name);
      }
      if (names.length > 0) change(all, { start: null, open: null, chosen: names.at(-1)!, corner: null }, names.map(words.announceDrawn).join(" "));
    },

    /** The body alone with floating tools, the pen in the hand; or back to the page. */
    fullCanvas(isCanvasFull: boolean): void {
      if (isCanvasFull === store.get().isCanvasFull) return;
      this.take(isCanvasFull ? "pen" : "none");
      store.set({ isCanvasFull, announcement: isCanvasFull ? text.canvas.opened : text.canvas.closed });
    },

    /** The item of the plan whose numbers are shown (panel/items.ts): a line is chosen, a lesion is seen through the skin and in slices. */
    chooseItem: (item: string | null): void => {
      const [kind, name] = item?.split(/ (.*)/s) ?? [];
      const line = kind === "line" && name !== undefined ? name : null;
      const lesion = kind === "lesion" && name !== undefined ? name : null;
      store.set((state) => {
        const isPutAway = lesion === null && state.lesion !== null && (item ?? "") === "";
        const { slices } = lesion !== null || isPutAway ? withSlices(state, lesion !== null) : state;
        return { item, lesion, slices: { ...slices, cross: lesion === null ? slices.cross : null, moves: false, marks: null }, drawn: { ...state.drawn, chosen: lesion === null ? line : state.drawn.chosen, corner: null } };
      });
    },

    /** The lesion that is looked at is in the hand, in the slices, or laid down. */
    moveLesion: (moves: boolean): void => store.set((state) => ({ slices: { ...withSlices(state, true).slices, cross: null, moves, marks: null } })),
    /** A new one by three taps in the slices. */
    markLesion: (): void => store.set((state) => ({ slices: { ...withSlices(state, true).slices, moves: false, marks: [] } })),
    slices: (change: Partial<SlicesState>): void => store.set(({ slices }) => ({ slices: { ...slices, ...change } })),
    showSlices: (isOn: boolean): void => store.set((state) => withSlices(state, isOn)),

    /** What the next line is drawn with. */
    ink: (ink: string): void => put({ ink }),

    recolour(name: string, color: string): void {
      change(withLine(lines(), name, (line) => ({ ...line, color })), {}, words.announceRecoloured(name));
    },

    /** How deep a closed line is to be cut; null: not said. */
    cutTo(name: string, mm: number | null): void {
      change(withLine(lines(), name, ({ depthMm: _, ...line }) => (mm === null ? line : { ...line, depthMm: mm })), {}, words.announceDepth(name, mm));
    },

    /** Another pattern or tumour, or other numbers of it: one step to undo.  The tool is put down, for the handles on the body. */
    choosePattern: (drawing: string): void => store.set((state) => (drawing === state.drawing ? {} : { drawing, drawn: { ...handsOff(state.drawn), live: state.drawn.live, lines: withStep(state) } })),

    /** The clicked line is complete. */
    finish: (): void => put({ start: null, open: null }),

    close(name: string): void {
      edit(name, (line, on) => (line.closed ? openedUp(line) : closedUp(on, line)), words.announceClosed(name), { open: null, corner: null });
    },

    /** A copy on the patient's other side, by the fitted model's plane of symmetry. */
    mirror(name: string): void {
      const line = lineNamed(drawn(), name);
      const on = skin();
      const result = store.get().fit?.result;
      const plane = result && mirrorPlane(result);
      if (!line || !on || !plane) return;
      const other = mirroredLine(on, plane, line);
      store.set((state) => withProblem(state, "drawing", other ? null : words.noOtherSide(name)));
      if (other) add({ ...other, mirrored: true, name: freeName(lines(), words.mirrored(name)) }, words.announceDrawn(words.mirrored(name)));
    },

    /** A circle of true radius along the skin. */
    tumour(at: Vector): void {
      const on = skin();
      if (!on) return;
      const radius = drawn().radiusMm;
      const name = freeName(lines(), words.tumourName(formatMmWhole(radius)));
      add(lineAlong(name, TUMOUR_INK, circle(on, at, radius), true), words.announceDrawn(name));
    },

    /** The tape goes on to here; the first click, and the one after its end, begins another one. */
    measure(at: Vector): void {
      const on = skin();
      if (!on) return;
      const { tape } = drawn();
      if (!tape || tape.isEnded) return put({ tape: tapeFrom(at) }, { announcement: text.tape.says(tapeFrom(at)) });
      if (gap(tape.places.at(-1)!, at) < 1) return;
      const next = tapeTo(on, tape, at);
      const { fit } = store.get();
      if (fit?.state !== "done" || next.isRefused) return put({ tape: next }, { announcement: text.tape.says(next) });
      const asked = tapeAsked(next);
      put({ tape: asked });
      void measureOn(fit.links.self, asked);
    },

    /** It stays to be read until the next one is begun or the tool is put down. */
    endTape(): void {
      const { tape } = drawn();
      if (tape) put({ tape: tape.legs.length > 0 ? { ...tape, isEnded: true, isRefused: false } : null });
    },

    radius(mm: number): void {
      if (Number.isFinite(mm)) put({ radiusMm: Math.min(RADIUS_MM.most, Math.max(RADIUS_MM.least, mm)) });
    },

    /** False when the name is not free. */
    rename(name: string, wanted: string): boolean {
      const to = wanted.trim().slice(0, 100);
      if (to === name) return true;
      if (to === "" || lines().some((line) => line.name === to)) return false;
      const follow = (known: string | null): string | null => (known === name ? to : known);
      change(withLine(lines(), name, (line) => ({ ...line, name: to })), { chosen: follow(drawn().chosen), open: follow(drawn().open) }, words.announceRenamed(to));
      return true;
    },

    erase(name: string): void {
      const forget = (known: string | null): string | null => (known === name ? null : known);
      change(withoutLine(lines(), name), { chosen: forget(drawn().chosen), open: forget(drawn().open), corner: null }, words.announceErased(name));
    },

    /** Lines that were found elsewhere become the scan's own, as one step to undo. */
    adopt(found: readonly OwnLine[], decided: InkDecided, announcement: string): void {
      const all = [...lines()];
      for (const line of found) all.push({ ...line, id: newId(), name: freeName(all, line.name) });
      change(all, { start: null, open: null, corner: null, decided }, announcement);
    },

    /** Which lines of ink are none of the plan; one step to undo, too. */
    decide: (decided: InkDecided, announcement: string): void => put({ lines: withStep(store.get()), decided }, { announcement }),

    /** Other lines instead, as one step to undo. */
    restore: (kept: readonly OwnLine[]): void => change(kept, {}, ""),


    choose: (name: string | null): void => put({ chosen: name, corner: null }),
    chooseCorner: (corner: number | null): void => put({ corner }),

    moveCorner(name: string, corner: number, to: Vector): void {
      edit(name, (line, on) => cornerMoved(on, line, corner, to), words.announceMoved, { chosen: name, corner });
    },

    addCorner(name: string, at: Vector): void {
      const line = lineNamed(drawn(), name);
      if (!line) return;
      const added = cornerAdded(line, at);
      if (added.line.corners.length === line.corners.length) put({ chosen: name, corner: added.corner });
      else change(withLine(lines(), name, () => added.line), { chosen: name, corner: added.corner }, words.announceCorner(added.corner + 1));
    },

    removeCorner(): void {
      const { chosen, corner } = drawn();
      const line = lineNamed(drawn(), chosen);
      const on = skin();
      if (!line || !on || corner === null) return;
      const next = cornerRemoved(on, line, corner);
      if (next === null) this.erase(line.name);
      else change(withLine(lines(), line.name, () => next), { corner: Math.min(corner, next.corners.length - 1) }, words.announceCornerGone);
    },

    undo(): void {
      const { tape, start } = drawn();
      if (tape) return put({ tape: tapeBack(tape) });
      if (start) return put({ start: null });
      const { past, future } = drawn().lines;
      const before = past.at(-1);
      if (!before) return void this.undoKept();
      goTo(before, { past: past.slice(0, -1), future: [stepOf(store.get()), ...future] }, true);
      this.tidy();
    },

    /** Before the page was opened: as far back as the service remembers. */
    async undoKept(): Promise<void> {
      const scan = store.get().scan?.info;
      const before = stepOf(store.get());
      if (!scan) return;
      await flush();
      try {
        const earlier = await plan.earlier(scan, before);
        const now = stepOf(store.get());
        if (store.get().scan?.info.id !== scan.id || now.lines !== before.lines || now.drawing !== before.drawing) return;
        if (earlier === null) {
          put({}, { announcement: words.nothingEarlier });
          return;
        }
        goTo(earlier, { past: [], future: [before, ...drawn().lines.future] }, true);
        this.tidy();
      } catch (error) {
        store.set((state) => withProblem(state, "drawing", messageOf(error)));
      }
    },

    redo(): void {
      const { past, future } = drawn().lines;
      const next = future[0];
      if (!next) return;
      goTo(next, { past: [...past, stepOf(store.get())], future: future.slice(1) }, false);
      this.tidy();
    },

    /** What is chosen must still be there. */
    tidy(): void {
      const { open, chosen } = drawn();
      put({ open: lineNamed(drawn(), open)?.name ?? null, chosen: lineNamed(drawn(), chosen)?.name ?? null });
      saveSoon();
    },

    show(layer: Layer, names: readonly string[], isShown: boolean): void {
      const hidden = new Set(drawn().hidden);
      for (const name of names) {
        if (isShown) hidden.delete(layerKey(layer, name));
        else hidden.add(layerKey(layer, name));
      }
      put({ hidden });
    },

    async importFile(file: File): Promise<void> {
      const scan = store.get().scan;
      if (!scan) return;
      try {
        const text = await file.text();
        const read = readDrawing(text, scan.info.unit);
        if (store.get().scan?.info.id !== scan.info.id) return;
        const whose = whoseIs(text);
        if (isAnothers(whose, scan.info.patient_code, scan.info.sha256)) put({ another: { theirs: whose.patient, ours: scan.info.patient_code, lines: read } });
        else take(read);
      } catch (error) {
        const message = error instanceof UnreadableDrawing ? error.message : messageOf(error);
        store.set((state) => withProblem(state, "drawing", message));
      }
    },

    /** What was asked about is this patient's. */
    takeAnother(): void {
      const { another } = drawn();
      put({ another: null });
      try {
        if (another) take(another.lines);
      } catch (error) {
        store.set((state) => withProblem(state, "drawing", messageOf(error)));
      }
    },

    leaveAnother: (): void => put({ another: null }),

    async saveNow(): Promise<void> {
      const { scan } = store.get();
      if (scan) await plan.save(scan.info);
    },
    flush,
  };
}

/** The line with its points on the skin, and how far the farthest was away, mm; what lies over a hole stays. */
function laidOnSkin(on: Skin | null, line: OwnLine): { line: OwnLine; away: number } {
  if (!on) return { line, away: 0 };
  const met = line.points.map((point) => on.nearest(point));
  const isOver = (k: number): boolean => line.bridged?.[k] === true;
  return { line: { ...line, points: line.points.map((point, k) => (isOver(k) || met[k]!.away < MOVED_MM ? point : met[k]!.point)) }, away: Math.max(0, ...met.map(({ away }, k) => (isOver(k) ? 0 : away))) };
}

/** A hand's stroke as a line; null where it is too short for one. */
function strokeOn(on: Skin, hits: readonly Vector[], name: string, ink: string): OwnLine | null {
  if (hits.length < 2) return null;
  const points = freehand(on, hits);
  if (points.length < 2) return null;
  const isClosed = points.length > 12 && gap(points[0]!, points.at(-1)!) < CLOSES_MM;
  return lineAlong(name, ink, isClosed ? freehand(on, [...points, points[0]!]).slice(0, -1) : points, isClosed);
}

export type DrawingActions = ReturnType<typeof drawingActions>;
