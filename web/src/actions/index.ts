// All that a person or the address can ask of the page; panels get this and nothing else to act with.
import type { Client } from "../api/client";
import type { Session } from "../state/session";
import type { Store } from "../state/store";
import { fitActions } from "./fit";
import { landmarkActions } from "./landmarks";
import { pageActions } from "./page";
import { createPlayer } from "./playback";
import { createProposalSearch } from "./proposals";
import { scanActions } from "./scan";

export function createActions(store: Store<Session>, client: Client, prefersStill: () => boolean) {
  const player = createPlayer(store, prefersStill);
  const fit = fitActions(store, client, player);
  const proposals = createProposalSearch(store, client);
  return {
    page: pageActions(store, proposals.lookOnce),
    scan: scanActions(store, client, fit.stop),
    landmarks: landmarkActions(store, client, proposals.lookOnce),
    proposals,
    fit,
    player,
  };
}

export type Actions = ReturnType<typeof createActions>;
