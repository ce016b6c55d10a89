// Asks the service once for each scan where the landmarks probably are.  What it says stays a proposal.
import type { Client } from "../../api/client";
import type { ScanSlice } from "../../scan/state";
import type { PageSlice } from "../../store/page";
import { messageOf } from "../../store/problems";
import type { Store } from "../../store/store";
import { openProposals, type Proposals } from "./proposals";
import type { LandmarksSlice } from "../state";
import * as text from "../text";

type State = PageSlice & ScanSlice & LandmarksSlice;

const TRIES = 60; // times the service's one second; then something is stuck, and the person can ask again

const pause = (seconds: number): Promise<void> => new Promise((done) => setTimeout(done, 1000 * seconds));

export function createProposalSearch(store: Store<State>, client: Client) {
  async function look(): Promise<void> {
    const { scan, proposals } = store.get();
    if (!scan || (proposals && proposals.state !== "none")) return;
    const isCurrent = (): boolean => store.get().scan?.info.id === scan.info.id;
    const show = (proposals: Proposals, announcement = store.get().announcement): void => {
      if (isCurrent()) store.set({ proposals, announcement });
    };
    show({ state: "looking" });
    try {
      for (let tried = 0; tried < TRIES && isCurrent(); tried += 1) {
        const answer = await client.proposed(scan.info);
        if ("landmarks" in answer) {
          const found: Proposals = { state: "found", landmarks: answer.landmarks, not_proposed: answer.not_proposed };
          const open = openProposals(found, store.get().picks.present);
          show(found, open.length > 0 ? text.proposals.announceFound(open.length) : undefined); // what is placed is no news
          return;
        }
        await pause(answer.retryAfterS);
      }
      show({ state: "none", reason: text.proposals.late });
    } catch (error) {
      show({ state: "none", reason: messageOf(error) });
    }
  }
  return {
    look,
    /** Without being asked: once for each scan, and not again after a refusal. */
    lookOnce: (): void => {
      if (store.get().proposals === null) void look();
    },
  };
}

export type ProposalSearch = ReturnType<typeof createProposalSearch>;
