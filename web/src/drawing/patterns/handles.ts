// The handles of patterns and tumour: asked for with the pattern, dragged, moved by keys, and written into the plan when
// the hand lets go.  The service draws the pattern anew for each place (one code for lines and numbers); while it does so
// the hand goes on, and only the newest place is asked for next.
import { ApiError, type Client } from "../../api/client";
import type { PatternOnScan, PatternQuestion, PlannedShape, Vector } from "../../api/types";
import { areApart, nameOn, parametersOf, readRequest, requestText, TUMOUR, type Values } from "../../fit/requestedDrawing";
import { type FitSlice, isAtRest } from "../../fit/state";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { messageOf } from "../../store/problems";
import { only, type Store } from "../../store/store";
import { type DrawingSlice, type Laid, laidPatterns, type Live, type LiveHandle, type LivePart } from "../state";
import * as text from "../text";

type State = PageSlice & ScanSlice & FitSlice & DrawingSlice;

interface Part {
  readonly part: LivePart;
  readonly name: string;
  readonly values: Values;
}

interface Held {
  readonly handle: LiveHandle;
  readonly part: Part; // as it was when the hand took it
  readonly link: string;
  answer: PatternOnScan | null; // as it is now
}

const words = text.drawing.handles;
const REFUSED = 422;
const LATER_MS = 3000; // until handles that did not come are asked for again
const CALM_MS = 600; // after the last key the hand has let go

/** What of the drawing has parameters: its pattern and its tumour. */
function partsOf({ meta, drawing }: Pick<State, "meta" | "drawing">): Part[] {
  const { base, values, tumour } = readRequest(drawing);
  const isPattern = meta?.patterns.some(({ name }) => name === base) ?? false;
  return [...(isPattern ? [{ part: "values", name: base, values } as const] : []), ...(tumour ? [{ part: TUMOUR, name: TUMOUR, values: tumour } as const] : [])];
}

/** Handles are there while the drawing is the matter, no line is drawn, and the body is fitted. */
export const hasHandles = ({ step, fit, drawn }: Pick<State, "step" | "fit" | "drawn">): boolean =>
  step === "plan" && (drawn.tool === "none" || drawn.tool === "points") && fit?.state === "done" && isAtRest(fit);

/** What handles are of: the fit and the numbers. */
export const keyOf = ({ fit, drawing }: Pick<State, "fit" | "drawing">): string => `${fit?.id ?? ""} ${drawing}`;

const handlesOf = (part: LivePart, { handles, measured = {} }: PatternOnScan): LiveHandle[] =>
  handles.map((handle) => {
    const here = Object.entries(measured).flatMap(([parameter, sides]) => (sides[handle.side] === undefined ? [] : [[parameter, sides[handle.side]!] as const]));
    return { ...handle, id: `${part}/${handle.name}`, part, ...(here.length > 0 ? { measured: Object.fromEntries(here) } : {}) };
  });

const valuesOf = ({ parameters }: PatternOnScan): Values => Object.fromEntries(Object.entries(parameters).map(([name, value]) => [name, String(value)]));

/** The patterns on the scan with the lines of the answer instead of those of the same name. */
function withLinesOf(laid: Pick<Laid, "shapes" | "unit"> | null, { shapes, unit }: PatternOnScan): Laid {
  const plain: Omit<PlannedShape, keyof PatternOnScan["shapes"][number]> = { item: "", kind: "pattern", carried: false };
  const moved = new Map(shapes.map((shape) => [shape.name, shape]));
  const known = laid?.shapes ?? [];
  const kept = known.map((shape) => ({ ...shape, ...moved.get(shape.name) }));
  const fresh = shapes.filter(({ name }) => !known.some((shape) => shape.name === name)).map((shape) => ({ ...plain, ...shape }));
  return { unit, shapes: [...kept, ...fresh] };
}

export function handleActions(store: Store<State>, client: Pick<Client, "pattern">, choosePattern: (drawing: string) => void) {
  let held: Held | null = null;
  let wanted: (() => Promise<PatternOnScan>) | null = null; // the newest question that waits
  let busy: Promise<void> | null = null;
  let asked = ""; // the handles of this are on their way, or came
  let isLooking = false; // one question at a time: numbers that are typed must not make a queue
  let calm: ReturnType<typeof setTimeout> | undefined;

  const live = (): Live | null => store.get().drawn.live;
  const isHeld = (): boolean => held !== null;
  const put = (part: Partial<Live>): void =>
    store.set((state) => (state.drawn.live ? { drawn: { ...state.drawn, live: { ...state.drawn.live, ...part } } } : {}));

  /** The handles of what is drawn now, when they are to be seen and are not here yet. */
  async function look(): Promise<void> {
    const state = store.get();
    const key = keyOf(state);
    if (held || isLooking || !hasHandles(state) || !state.fit || key === asked || (key === live()?.key && live()?.handles.length)) return;
    asked = key;
    isLooking = true;
    const parts = partsOf(state);
    const link = state.fit.links.self;
    const late: unknown[] = []; // too many ask just now, or the service is away
    const answers: LiveHandle[] = [];
    /** False where the service refuses it. */
    const handlesIf = async (part: LivePart, question: PatternQuestion): Promise<boolean> => {
      try {
        answers.push(...handlesOf(part, await client.pattern(link, question)));
      } catch (error) {
        if (error instanceof ApiError && error.status === REFUSED) return false;
        late.push(error);
      }
      return true;
    };
    for (const { part, name, values } of parts) {
      if (isHeld() || keyOf(store.get()) !== key) break;
      const parameters = parametersOf(values);
      const isAnswered = await handlesIf(part, { name, parameters });
      // On one side it may fit; why it does not on the other one says the plan.
      if (!isAnswered) for (const side of ["R", "L"] as const) await handlesIf(part, { name, parameters, side });
    }
    isLooking = false;
    if (isHeld()) return;
    if (keyOf(store.get()) !== key) return look();
    if (late.length > 0) {
      setTimeout(() => {
        asked = "";
        void look();
      }, LATER_MS);
      return;
    }
    store.set(({ drawn }) => ({ drawn: { ...drawn, live: { key, handles: answers, held: null, values: null, limit: "", dragged: drawn.live?.dragged ?? null } } }));
  }

  store.select(only("step", "fit", "drawing", "drawn", "meta"), ({ drawn }, before) => {
    if (before.drawn.live && !drawn.live && !held) asked = "";
    queueMicrotask(() => void look());
  });

  function take(answer: PatternOnScan, now: Held): void {
    now.answer = answer;
    const { part } = now.part;
    const fresh = new Map(handlesOf(part, answer).map((handle) => [handle.id, handle]));
    store.set((state) => {
      const { live: before, onScan } = state.drawn;
      if (!before) return {};
      const laid = before.dragged?.over === onScan ? before.dragged.patterns : (laidPatterns(state) as Laid | null);
      return {
        drawn: {
          ...state.drawn,
          live: { ...before, handles: before.handles.map((each) => fresh.get(each.id) ?? each), values: valuesOf(answer), limit: answer.limit, dragged: { patterns: withLinesOf(laid, answer), over: onScan } },
        },
      };
    });
  }

  /** One question after the other, and only the newest of those that waited. */
  function ask(question: () => Promise<PatternOnScan>): void {
    wanted = question;
    busy ??= (async () => {
      while (wanted) {
        const next = wanted;
        wanted = null;
        const now = held;
        try {
          const answer = await next();
          if (held === now && now) take(answer, now);
        } catch (error) {
          if (held === now) put({ limit: messageOf(error) });
        }
      }
      busy = null;
    })();
  }

  return {
    look,

    /** The hand takes a handle; false when it is not there. */
    grab(id: string): boolean {
      const state = store.get();
      const handle = live()?.handles.find((each) => each.id === id);
      const part = partsOf(state).find((each) => each.part === handle?.part);
      if (!handle || !part || !state.fit || held) return held?.handle.id === id;
      held = { handle, part, link: state.fit.links.self, answer: null };
      put({ held: id, limit: "", values: null });
      return true;
    },

    /** To a place of the skin, mm. */
    drag(to: Vector): void {
      if (!held) return;
      const { link, part, handle } = held;
      ask(() => client.pattern(link, { name: part.name, parameters: parametersOf(part.values), drag: { handle: handle.name, to } }));
    },

    /** Its first number by so much, from where it is now; ends at its limits, and says so. */
    step(by: number): void {
      if (!held) return;
      const now = held;
      const current = live()?.handles.find(({ id }) => id === now.handle.id) ?? now.handle;
      const [number] = current.numbers;
      if (!number) return;
      // What the body itself keeps beyond a limit stays there: a nipple that is higher than the field goes.
      const value = number.value > (number.max ?? Infinity) ? number.value : Math.min(number.max ?? Infinity, Math.max(number.min ?? -Infinity, Math.round(2 * (number.value + by)) / 2));
      const before = now.answer ? valuesOf(now.answer) : now.part.values;
      const values = { ...before, [areApart(before) ? nameOn(number.parameter, now.handle.side) : number.parameter]: String(value) };
      const ends = value === number.value + by || Math.abs(value - number.value - by) < 0.5 ? "" : words.ends(number.label, value, number.unit);
      ask(async () => ({ ...(await client.pattern(now.link, { name: now.part.name, parameters: parametersOf(values), side: now.handle.side })), limit: ends }));
      this.releaseSoon();
    },

    /** Keys have no end of their own. */
    releaseSoon(): void {
      clearTimeout(calm);
      calm = setTimeout(() => void this.release(), CALM_MS);
    },

    /** The hand lets go: the numbers are the plan's from now on, one step to undo. */
    async release(): Promise<void> {
      clearTimeout(calm);
      const now = held;
      if (!now) return;
      while (busy) await busy;
      if (held !== now) return;
      held = null;
      const { drawing, fit } = store.get();
      const { answer } = now;
      const handle = live()?.handles.find(({ id }) => id === now.handle.id);
      put({ held: null, values: null });
      if (!answer || !handle || fit?.links.self !== now.link) return;
      const changed = requestText({ ...readRequest(drawing), [now.part.part]: valuesOf(answer) });
      choosePattern(changed);
      store.set({ announcement: [words.says(handle), live()?.limit ?? ""].filter((each) => each !== "").join(". ") });
    },

    /** As if it had never been taken. */
    cancel(): void {
      clearTimeout(calm);
      if (!held) return;
      held = null;
      wanted = null;
      asked = "";
      put({ held: null, values: null, limit: "", key: "", dragged: null }); // the handles come anew
    },

    isHeld,
  };
}

export type HandleActions = ReturnType<typeof handleActions>;
