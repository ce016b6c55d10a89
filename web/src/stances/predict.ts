// A stance that was not scanned: predicted from the fit in work, shown beside it, and predicted anew with each other fit.
import { ApiError, type Client } from "../api/client";
import { followFit } from "../api/events";
import type { Stance } from "../api/types";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import type { ViewSlice } from "../viewer/state";
import { loadFit } from "./load";
import { isPredicted, predictedOf, stanceOf, type StancesSlice, type Workspace, workspaceOf } from "./state";
import * as text from "./text";

const words = text.stances.predicted;

type State = PageSlice & ViewSlice & Workspace & StancesSlice & { readonly active: string | null };

export function predictActions<Whole extends State>(store: Store<Whole>, client: Client, flush: () => Promise<unknown>) {
  let stopFollowing: () => void = () => undefined;
  let run = 0; // the prediction that was asked for last

  const set = (change: (state: State) => Partial<State>): void => store.set((state) => change(state) as Partial<Whole>);
  const put = (predicting: Stance | null, more: Partial<State> = {}): void => set((state) => ({ ...more, stances: { ...state.stances, predicting } }));

  /** Nobody waits for it any more. */
  function leave(): void {
    run += 1;
    stopFollowing();
    if (store.get().stances.predicting) put(null);
  }

  async function predict(stance: Stance): Promise<void> {
    const { scan, fit } = store.get();
    if (!scan || fit?.state !== "done") return;
    leave();
    const mine = run;
    const isMine = (): boolean => mine === run && store.get().scan?.info.id === scan.info.id && store.get().fit?.id === fit.id;
    const end = (why: string | null): void => {
      if (isMine()) put(null, withProblem(store.get(), "stances", why));
    };
    put(stance, withProblem(store.get(), "stances", null));
    try {
      await flush();
      const { id, links } = await client.predict(fit.links.predictions, { stance });
      if (!isMine()) return;
      const nothing = (): void => undefined;
      stopFollowing = followFit(links.events, {
        handlers: {
          started: nothing,
          iterated: nothing,
          done: () => void show(id, isMine).catch((error: unknown) => end(messageOf(error))),
          failed: ({ body }) => end(body.reason),
          cancelled: () => end(null),
        },
        whyOver: () => client.fit(id).then(() => null, (error: unknown) => (error instanceof ApiError && error.status === 404 ? words.gone : null)),
      });
    } catch (error) {
      end(messageOf(error));
    }
  }

  async function show(id: string, isMine: () => boolean): Promise<void> {
    const fit = await loadFit(client, id, null, []);
    if (!isMine()) return;
    set((state) => ({
      stances: { ...state.stances, other: predictedOf(workspaceOf(state), fit), predicting: null, isAdding: false, isSecond: false, isComparing: true },
      ...(state.stances.isComparing ? {} : { overlay: "scan", active: null }), // as `compare` begins it
      announcement: words.announce(stanceOf({ ...state, fit })),
    }));
  }

  /** Another fit of the scan: what was predicted from the one before is of another body. */
  store.select(only("fit"), ({ fit }) => {
    const { other } = store.get().stances;
    if (fit?.state !== "done" || !other || !isPredicted(other) || other.fit?.predictedFrom === fit.id) return;
    queueMicrotask(() => void predict(stanceOf(other))); // a listener never sets
  });

  return { predict, leave };
}
