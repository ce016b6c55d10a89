// Bringing a scan in: from a file, from the example, from the address; and turning it upright.
import { ApiError, type Client } from "../api/client";
import type { ExampleScan, Frame, LandmarkFile, UnitChoice, Vector } from "../api/types";
import { fromDrawing } from "../drawing/files";
import { startDrawn } from "../drawing/lines";
import { tidyFrame, turned, type Turn } from "../viewer/frame";
import { startHistory } from "../store/history";
import { frameFromPicks, type Picks } from "../landmarks/picks";
import { initialStances } from "../stances/state";
import type { Session } from "../app/session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import { isUnit, mmFrom } from "../ui/units";
import { messageOf, withProblem } from "../store/problems";

export const READABLE = /\.(ply|obj|stl|glb|zip)$/i;

export function scanActions(store: Store<Session>, client: Client, stopFit: () => void, onLandmarks: () => void) {
  let generation = 0; // the scan asked for last wins over slower, earlier ones

  /** Shows `info` as the page's scan; everything that belonged to the one before is dropped. */
  async function adopt(info: ExampleScan, title: string, file: File | null, own: Frame | null, isNew: boolean, mine: number): Promise<void> {
    const [mesh, saved, drawing] = await Promise.all([client.mesh(info), client.landmarks(info).catch(() => null), isNew ? null : client.ownDrawing(info)]);
    if (mine !== generation) return;
    stopFit();
    const picks = saved ? picksOf(saved) : {};
    const straight = own ? null : frameFromPicks(picks);
    store.set((state) => ({
      loading: null,
      scan: {
        info,
        title,
        mesh,
        file,
        frame: straight ?? tidyFrame(own ?? info.frame),
        frameFrom: own ? "person" : straight ? "landmarks" : "service",
        example: info.example_landmarks ?? null,
      },
      picks: startHistory<Picks>(picks),
      drawn: startDrawn(drawing ? fromDrawing(drawing) : []),
      proposals: null,
      skipped: new Set<string>(),
      active: null,
      saving: "saved",
      fit: null,
      isStarting: false,
      step: "scan",
      overlay: "both",
      stance: "auto",
      view: { name: "front", asked: state.view.asked + 1 },
      problems: {},
    }));
  }

  async function bring(title: string, ask: () => Promise<{ info: ExampleScan; file: File | null; own: Frame | null; isNew?: boolean }>): Promise<boolean> {
    const mine = ++generation;
    store.set((state) => ({ loading: { phase: "preparing", share: 0, title }, ...withProblem(state, "scan", null) }));
    try {
      const { info, file, own, isNew = false } = await ask();
      if (mine === generation) await adopt(info, title, file, own, isNew, mine);
      return mine === generation;
    } catch (error) {
      if (mine === generation) {
        const gone = error instanceof ApiError && error.status === 404;
        const message = gone ? text.errors.noScan : messageOf(error);
        store.set((state) => ({ loading: null, step: "scan", active: null, ...withProblem(state, "scan", message) }));
      }
      return false;
    }
  }

  return {
    upload(file: File, units: UnitChoice = store.get().units): Promise<boolean> {
      if (!READABLE.test(file.name)) {
        store.set((state) => ({ step: "scan", active: null, ...withProblem(state, "scan", text.errors.notAScan(file.name)) }));
        return Promise.resolve(false);
      }
      const title = text.top.uploaded;
      store.set({ units });
      return bring(title, async () => {
        const mine = generation;
        const progress = (share: number): void => {
          const phase = share < 1 ? "sending" : "preparing";
          if (mine === generation) store.set({ loading: { phase, share, title } });
        };
        progress(0);
        return { info: await client.upload(file, units, progress), file, own: null, isNew: true };
      });
    },

    takeExample(name: string): Promise<boolean> {
      const label = store.get().examples.find((example) => example.name === name)?.label ?? name;
      return bring(label, async () => ({ info: await client.importExample(name), file: null, own: null, isNew: true }));
    },

    /** The scan that the address names. */
    open(scan: string, own: Frame | null): Promise<boolean> {
      return bring(text.top.uploaded, async () => ({ info: await client.scan(scan), file: null, own }));
    },

    /** Size and direction are right: on to the landmarks. */
    confirm(): void {
      store.set((state) => ({ confirmed: state.scan?.info.id ?? null, step: "landmarks" }));
      onLandmarks();
    },

    turn(turn: Turn): void {
      store.set((state) =>
        state.scan
          ? {
              scan: { ...state.scan, frame: turned(state.scan.frame, turn), frameFrom: "person" },
              view: { name: "front", asked: state.view.asked + 1 },
            }
          : {},
      );
    },

    /** Back to the empty page; the scan itself stays with the service. */
    leave(): void {
      generation += 1;
      stopFit();
      store.set({ scan: null, fit: null, isStarting: false, stances: initialStances, loading: null, picks: startHistory<Picks>({}), drawn: startDrawn(), proposals: null, active: null, step: "scan", problems: {} });
    },

    chooseUnits: (units: UnitChoice): void => store.set({ units }),
    showColours: (showColours: boolean): void => store.set({ showColours }),
  };
}

/** A landmark file's points in millimetres. */
export function picksOf(file: { landmarks: LandmarkFile["landmarks"]; unit?: string }): Picks {
  const unit = isUnit(file.unit) ? file.unit : "mm";
  const entries = Object.entries(file.landmarks);
  return Object.fromEntries(entries.map(([name, point]) => [name, point.map((value) => mmFrom(value, unit)) as Vector]));
}
