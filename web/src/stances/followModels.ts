// The models that the fits on the page were made with, once a scan is opened: each is nearly a megabyte, which a list of
// patients does not need.
import type { Client } from "../api/client";
import { type FitSlice, modelHash } from "../fit/state";
import type { ScanSlice } from "../scan/state";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import type { StancesSlice } from "./state";

type State = PageSlice & ScanSlice & FitSlice & StancesSlice;

export function followModels<Whole extends State>(store: Store<Whole>, client: Pick<Client, "model">): void {
  const asked = new Set<string>();
  const set = (change: (state: State) => Partial<State>): void => store.set((state) => change(state) as Partial<Whole>);

  async function load(hash: string): Promise<void> {
    try {
      const model = await client.model(hash);
      set(({ models }) => ({ models: { ...models, [hash]: model } }));
    } catch (error) {
      set((state) => withProblem(state, "model", messageOf(error)));
    }
  }

  store.select(only("meta", "scan", "loading", "fit", "stances"), ({ meta, scan, loading, fit, stances }) => {
    if (!(scan ?? loading)) return;
    for (const hash of [modelHash({ meta, fit }), modelHash({ meta, fit: stances.other?.fit ?? null })]) {
      if (hash === null || asked.has(hash)) continue;
      asked.add(hash);
      void load(hash);
    }
  });
}
