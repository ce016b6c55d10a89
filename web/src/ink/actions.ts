// What a person does with lines found on the skin: look for them, accept, rename, join, drop.
import type { Client } from "../api/client";
import type { DrawingActions } from "../drawing/actions";
import type { DrawingSlice } from "../drawing/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf } from "../store/problems";
import type { Store } from "../store/store";
import { asOwn, nearestJoint, readInk } from "./lines";
import { type FoundLine, foundOn, type InkSlice, isMark, mayShowInk, type Search } from "./state";
import * as text from "./text";

type State = PageSlice & ScanSlice & DrawingSlice & InkSlice;

const TRIES = 60; // times the service's one second
const pause = (seconds: number): Promise<void> => new Promise((done) => setTimeout(done, 1000 * seconds));

export function inkActions(store: Store<State>, client: Pick<Client, "ink">, drawing: Pick<DrawingActions, "adopt">) {
  const lines = (): readonly FoundLine[] => foundOn(store.get().ink, store.get().scan?.info.id);

  const put = (scan: string, search: Search, announcement = store.get().announcement): void => store.set((state) => ({ ink: { ...state.ink, [scan]: search }, announcement }));

  /** Those that are still to be decided. */
  function keep(rest: readonly FoundLine[], announcement: string): void {
    const scan = store.get().scan?.info.id;
    const search = scan === undefined ? undefined : store.get().ink[scan];
    if (scan !== undefined && search?.state === "found") put(scan, { ...search, lines: rest }, announcement);
    store.set({ inkPointed: null });
  }

  function accept(chosen: readonly FoundLine[]): void {
    if (chosen.length === 0) return;
    const announcement = text.ink.announceAccepted(chosen.length);
    drawing.adopt(chosen.map(asOwn), announcement);
    keep(lines().filter((line) => !chosen.includes(line)), announcement);
  }

  const named = (name: string): FoundLine[] => lines().filter((line) => line.name === name);

  return {
    /** Once for each scan that has colours. */
    async look(): Promise<void> {
      const { scan, ink } = store.get();
      if (!scan || !mayShowInk(scan.info) || ink[scan.info.id]) return;
      const { info } = scan;
      put(info.id, { state: "looking" });
      try {
        for (let tried = 0; tried < TRIES; tried += 1) {
          const answer = await client.ink(info);
          if ("shapes" in answer) {
            const { scan: now, drawn } = store.get();
            const found = readInk(answer, now?.info.id === info.id ? drawn.lines.present : []);
            put(info.id, { state: "found", lines: found, count: answer.shapes.length }, found.length > 0 ? text.ink.announceFound(found.length) : store.get().announcement);
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
    drop: (name: string): void => keep(lines().filter((line) => line.name !== name), text.ink.announceDropped(name)),
    dropAll: (): void => keep([], text.ink.decided),

    /** False when the name is not free. */
    rename(name: string, wanted: string): boolean {
      const to = wanted.trim().slice(0, 100);
      if (to === name) return true;
      if (to === "" || named(to).length > 0) return false;
      keep(lines().map((line) => (line.name === name ? { ...line, name: to } : line)), "");
      return true;
    },

    join(name: string): void {
      const [line] = named(name);
      const joint = line && nearestJoint(line, lines());
      if (!line || !joint) return;
      const both: FoundLine = { ...line, points: joint.points, lengthMm: line.lengthMm + joint.other.lengthMm, kind: line.kind === "dashed" ? "dashed" : "line" };
      keep(lines().filter((each) => each !== joint.other).map((each) => (each === line ? both : each)), text.ink.announceJoined(name, joint.other.name));
    },

    /** Also while the list is written anew, which takes the row from under the pointer. */
    point: (name: string | null): void =>
      queueMicrotask(() => {
        if (store.get().inkPointed !== name) store.set({ inkPointed: name });
      }),
  };
}

export type InkActions = ReturnType<typeof inkActions>;
