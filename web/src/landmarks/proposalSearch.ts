// Asks the service once for each scan where the landmarks probably are.  What it says stays a proposal.
import type { Client } from "../api/client";
import type { Proposals } from "./proposals";
import type { Session } from "../app/session";
import type { Store } from "../store/store";
import { text } from "../ui/text";
import { messageOf } from "../store/problems";

const TRIES = 60; // times the service's one second; then something is stuck, and the person can ask again

const pause = (seconds: number): Promise<void> => new Promise((done) => setTimeout(done, 1000 * seconds));

export function createProposalSearch(store: Store<Session>, client: Client) {
  async function look(): Promise<void> {
    const { scan, proposals } = store.get();
    if (!scan || (proposals && proposals.state !== "none")) return;
    const isCurrent = (): boolean => store.get().scan?.info.id === scan.info.id;
    const tell = (told: Proposals, announcement = store.get().announcement): void => {
      if (isCurrent()) store.set({ proposals: told, announcement });
    };
    tell({ state: "looking" });
    try {
      for (let tried = 0; tried < TRIES && isCurrent(); tried += 1) {
        const answer = await client.proposed(scan.info);
        if ("landmarks" in answer) {
          tell({ state: "found", landmarks: answer.landmarks }, text.proposals.announceFound(Object.keys(answer.landmarks).length));
          return;
        }
        await pause(answer.retryAfterS);
      }
      tell({ state: "none", reason: text.proposals.late });
    } catch (error) {
      tell({ state: "none", reason: messageOf(error) });
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
