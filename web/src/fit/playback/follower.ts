// The model follows a landmark while it is dragged: the newest picks go to the service, one question at a time, and its
// answers pose the rig.  Nothing of it stays: the fit that is asked for when the drag has ended takes its place.
import type { Client } from "../../api/client";
import type { Vector } from "../../api/types";
import { placesOf } from "../../landmarks/picks";
import type { LandmarksSlice } from "../../landmarks/state";
import type { Store } from "../../store/store";
import { type FitSlice, isAtRest } from "../state";

type State = Pick<LandmarksSlice, "picks"> & FitSlice;

export interface Follower {
  /** A mark was taken up: the service gets the fit ready. */
  readonly begin: () => void;
  /** Where marks are now that are elsewhere than the picks say. */
  readonly move: (elsewhere: Record<string, Vector>) => void;
  /** The picks as they are now. */
  readonly show: () => void;
  /** The mark is back where it was. */
  readonly giveUp: () => void;
}

export function createFollower(store: Store<State>, client: Pick<Client, "moved">): Follower {
  let newest: Record<string, Vector> | null = null; // that nobody has been asked for yet
  let isAsking = false;
  let run = 0; // answers of a drag that was given up are not shown

  async function ask(): Promise<void> {
    const { fit } = store.get();
    const landmarks = newest;
    newest = null;
    if (!landmarks || fit?.state !== "done") return;
    const mine = run;
    isAsking = true;
    try {
      const { nodes } = await client.moved(fit.links, landmarks);
      const now = store.get().fit;
      if (mine === run && now?.id === fit.id) store.set({ followed: { fit: fit.id, nodes } });
    } catch {
      newest = null; // the fit that is asked for at the end says what is wrong
    } finally {
      isAsking = false;
      void ask(); // what has come meanwhile
    }
  }

  function send(landmarks: Record<string, Vector>): void {
    const { fit } = store.get();
    if (!fit || !isAtRest(fit)) return;
    newest = landmarks;
    if (!isAsking) void ask();
  }

  const present = (): Record<string, Vector> => placesOf(store.get().picks.present).landmarks;

  return {
    begin: () => send(present()),
    move: (elsewhere) => send({ ...present(), ...elsewhere }),
    show: () => send(present()),
    giveUp: () => {
      run += 1;
      newest = null;
      store.set({ followed: null });
    },
  };
}
