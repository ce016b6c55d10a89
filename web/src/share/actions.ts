// Links that show one result to somebody: made, listed and revoked in the share dialog.
import type { Client } from "../api/client";
import type { ShareRequest } from "../api/types";
import type { FitSlice } from "../fit/state";
import type { PageSlice } from "../store/page";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import type { ShareSlice } from "./state";
import * as text from "./text";

type State = PageSlice & FitSlice & ShareSlice;

export function shareActions(store: Store<State>, client: Client) {
  /** Runs for the fit that the dialog was opened for; an answer for another one is dropped. */
  async function forFit(work: (link: string) => Promise<Partial<State>>): Promise<void> {
    const fit = store.get().fit;
    if (!fit || store.get().share.isBusy) return;
    const show = (part: (state: State) => Partial<State>): void =>
      store.set((state) => (state.fit?.id === fit.id ? part(state) : {}));
    show((state) => ({ share: { ...state.share, isBusy: true }, ...withProblem(state, "share", null) }));
    try {
      const done = await work(fit.links.shares);
      const { shares } = await client.shares(fit.links.shares);
      const isDead = (id: string): boolean => shares.some((each) => each.id === id && each.revoked_at !== null);
      show((state) => {
        const share = { ...state.share, ...done.share, isBusy: false, list: shares };
        return { ...done, share: { ...share, made: share.made && !isDead(share.made.id) ? share.made : null } }; // nobody copies a revoked address
      });
    } catch (error) {
      show((state) => ({ share: { ...state.share, isBusy: false }, ...withProblem(state, "share", messageOf(error)) }));
    }
  }

  return {
    async open(): Promise<void> {
      if (store.get().fit?.state !== "done") return;
      store.set((state) => ({ share: { isOpen: true, isBusy: false, list: null, made: null }, ...withProblem(state, "share", null) }));
      await forFit(() => Promise.resolve({}));
    },

    close: (): void => store.set((state) => ({ share: { ...state.share, isOpen: false, made: null } })),

    make: (request: ShareRequest): Promise<void> =>
      forFit(async (link) => {
        const { id, url } = await client.makeShare(link, request);
        return { share: { ...store.get().share, made: { id, url } }, announcement: text.share.announceMade };
      }),

    unlock: (link: string): Promise<void> =>
      forFit(async () => {
        await client.unlockShare(link);
        return { announcement: text.share.announceUnlocked };
      }),

    refresh: (link: string): Promise<void> =>
      forFit(async () => {
        await client.refreshShare(link);
        return { announcement: text.share.announceRefreshed };
      }),

    revoke: (link: string): Promise<void> =>
      forFit(async () => {
        await client.revokeShare(link);
        return { announcement: text.share.announceRevoked };
      }),
  };
}

export type ShareActions = ReturnType<typeof shareActions>;
