// What a person does with lines found on the skin: look for them, accept, rename, join, drop, bring back.
import type { Client } from "../api/client";
import type { Scan } from "../api/types";
import type { DrawingActions } from "../drawing/actions";
import type { DrawingSlice, InkDecided } from "../drawing/state";
import { cropsOf } from "../scan/crop";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import { mayShowInk } from "../scan/fineColours";
import { asOwn, decidedBefore, nearestJoint, readInk } from "./lines";
import { droppedIds, type FoundLine, type InkSlice, isMark, openLines, type Search } from "./state";
import * as text from "./text";

type State = PageSlice & ScanSlice & DrawingSlice & InkSlice;

const TRIES = 60; // times the service's one second
const pause = (seconds: number): Promise<void> => new Promise((done) => setTimeout(done, 1000 * seconds));

export function inkActions(store: Store<State>, client: Pick<Client, "ink" | "dropInk">, drawing: Pick<DrawingActions, "adopt" | "decide">) {
  let saving: Promise<void> = Promise.resolve();
  let unsaid: string | null = null; // what saving has complained about last

  const search = (): Search | undefined => store.get().ink[store.get().scan?.info.id ?? ""];
  const decided = (): InkDecided => store.get().drawn.decided ?? {};
  const lines = (): readonly FoundLine[] => openLines(search(), store.get().drawn.decided, cropsOf(store.get().scan));

  const put = (scan: string, now: Search, more: Partial<State> = {}): void => store.set((state) => ({ ...more, ink: { ...state.ink, [scan]: now } }));

  /** Renamed or joined, whether decided or not. */
  function write(change: (all: readonly FoundLine[]) => readonly FoundLine[], announcement: string): void {
    const scan = store.get().scan?.info.id;
    const now = search();
    if (scan !== undefined && now?.state === "found") put(scan, { ...now, lines: change(now.lines) }, { announcement, inkPointed: null });
  }

  const as = (what: "accepted" | "dropped", chosen: readonly FoundLine[]): InkDecided => ({ ...decided(), ...Object.fromEntries(chosen.flatMap(({ ids }) => ids.map((id) => [id, what]))) });

  function accept(chosen: readonly FoundLine[]): void {
    if (chosen.length === 0) return;
    store.set({ inkPointed: null });
    drawing.adopt(chosen.map(asOwn), as("accepted", chosen), text.ink.announceAccepted(chosen.length));
  }

  function drop(chosen: readonly FoundLine[], announcement: string): void {
    if (chosen.length === 0) return;
    store.set({ inkPointed: null });
    drawing.decide(as("dropped", chosen), announcement);
  }

  const named = (name: string): FoundLine[] => lines().filter((line) => line.name === name);

  /** A scan that is opened again: what is decided there is what is known of it. */
  function recall(scan: string): void {
    const { drawn, scan: now } = store.get();
    const found = search();
    if (now?.info.id !== scan || found?.state !== "found" || drawn.decided !== null) return;
    store.set((state) => ({ drawn: { ...state.drawn, decided: decidedBefore(found.lines, found.kept, state.drawn.lines.present) } }));
  }

  /** What is dropped now is kept by the service, one change after the other; what could not be kept goes with the next change. */
  async function keep(scan: Scan, wanted: readonly string[]): Promise<void> {
    const before = store.get().ink[scan.id];
    if (before?.state !== "found") return;
    const changed = [...wanted.filter((id) => !before.kept.includes(id)), ...before.kept.filter((id) => !wanted.includes(id))];
    if (changed.length === 0) return;
    try {
      await client.dropInk(scan, Object.fromEntries(changed.map((id) => [id, wanted.includes(id)])));
      const now = store.get().ink[scan.id];
      if (now?.state === "found") put(scan.id, { ...now, kept: wanted }, withoutMessage(store.get(), "drawing", unsaid));
    } catch (error) {
      unsaid = messageOf(error);
      store.set((state) => withProblem(state, "drawing", unsaid));
    }
  }

  store.select(only("scan", "drawn"), ({ scan, drawn }, before) => {
    if (!scan || scan.info.id !== before.scan?.info.id || drawn.decided === null || drawn.decided === before.drawn.decided) return;
    const wanted = droppedIds(drawn.decided);
    saving = saving.then(() => keep(scan.info, wanted));
  });

  return {
    /** Once for each scan that has colours. */
    async look(): Promise<void> {
      const { scan, ink } = store.get();
      if (!scan || !mayShowInk(scan.info)) return;
      const { info } = scan;
      if (ink[info.id]) {
        recall(info.id);
        return;
      }
      put(info.id, { state: "looking" });
      try {
        for (let tried = 0; tried < TRIES; tried += 1) {
          const answer = await client.ink(info);
          if ("shapes" in answer) {
            put(info.id, { state: "found", lines: readInk(answer), kept: answer.shapes.filter(({ dropped }) => dropped).map(({ name }) => name) });
            recall(info.id);
            const open = lines().length;
            if (store.get().scan?.info.id === info.id && open > 0) store.set({ announcement: text.ink.announceFound(open) });
            return;
          }
          await pause(answer.retryAfterS);
        }
        put(info.id, { state: "failed", reason: text.ink.late });
      } catch (error) {
        put(info.id, { state: "failed", reason: messageOf(error) });
      }
    },

    accept: (name: string): void => accept(named(name)),
    /** The lines of the plan; marks beside it are accepted one by one. */
    acceptAll: (): void => accept(lines().filter((line) => !isMark(line))),
    drop: (name: string): void => drop(named(name), text.ink.announceDropped(name)),
    dropAll: (): void => drop(lines(), text.ink.decided),
    /** All that were dropped, also before the page was opened. */
    bringBack(): void {
      const rest = Object.fromEntries(Object.entries(decided()).filter(([, what]) => what !== "dropped"));
      drawing.decide(rest, text.ink.announceBroughtBack);
    },

    /** False when the name is not free. */
    rename(name: string, wanted: string): boolean {
      const to = wanted.trim().slice(0, 100);
      if (to === name) return true;
      const now = search();
      const [line] = named(name);
      if (to === "" || !line || now?.state !== "found" || now.lines.some((each) => each.name === to)) return false;
      write((all) => all.map((each) => (each === line ? { ...line, name: to } : each)), "");
      return true;
    },

    join(name: string): void {
      const [line] = named(name);
      const joint = line && nearestJoint(line, lines());
      if (!line || !joint) return;
      const both: FoundLine = { ...line, ids: [...line.ids, ...joint.other.ids], points: joint.points, bridged: joint.bridged, lengthMm: line.lengthMm + joint.other.lengthMm, kind: line.kind === "dashed" ? "dashed" : "line" };
      write((all) => all.filter((each) => each !== joint.other).map((each) => (each === line ? both : each)), text.ink.announceJoined(name, joint.other.name));
    },

    /** Also while the list is written anew, which takes the row from under the pointer. */
    point: (name: string | null): void =>
      queueMicrotask(() => {
        if (store.get().inkPointed !== name) store.set({ inkPointed: name });
      }),

    /** What waits to be kept is kept. */
    settled: async (): Promise<void> => saving,
  };
}

export type InkActions = ReturnType<typeof inkActions>;
