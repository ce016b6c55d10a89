// The part of the state that belongs to the page as a whole: every feature reads it, and says in it which step is open,
// what went wrong and what a screen reader announces.
import type { Example, Meta, Model } from "../api/types";
import type { Unsaved } from "./outbox";

/** Body, Plan and Hand over are the tabs; `points`, where landmarks are set by hand, is a part of Body. */
export type Step = "body" | "points" | "plan" | "handover";

export type Theme = "system" | "light" | "dark";

/** Where on the page something can go wrong: the message is shown there. */
export type Place = "service" | "scan" | "size" | "landmarks" | "fit" | "model" | "distances" | "drawing" | "stances" | "share" | "page";

export interface PageSlice {
  readonly meta: Meta | null;
  readonly examples: readonly Example[];
  readonly models: Readonly<Record<string, Model>>; // by their hashes: the service's own, and those that older fits were made with
  readonly group: string; // of people, that a new patient is to belong to; empty: none is chosen
  readonly theme: Theme;
  readonly step: Step;
  readonly problems: Readonly<Partial<Record<Place, string>>>;
  readonly announcement: string; // for the live region
  readonly unsaved: { readonly what: readonly Unsaved[]; readonly why: string; readonly isFull: boolean } | null; // what the service would not take when it was asked last
  readonly undone: { readonly says: string } | null; // what undo or redo has just changed: shown, and read out
}

export const initialPage: PageSlice = { meta: null, examples: [], models: {}, group: "", theme: "system", step: "body", problems: {}, announcement: "", unsaved: null, undone: null };
