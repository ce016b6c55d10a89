// Placing landmarks: each change is one step of the undo history and is saved with the scan soon after.
import type { Client } from "../api/client";
import type { Scan, Vector } from "../api/types";
import { fileName, type ScanSlice } from "../scan/state";
import { record, redo, undo } from "../store/history";
import type { PageSlice } from "../store/page";
import type { Outbox } from "../store/outbox";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import { only, type Store } from "../store/store";
import { saveBlob } from "../ui/dom";
import type { ViewSlice } from "../viewer/state";
import { type Certain, certainAt, certainNames } from "./certain";
import { createPicksKeeper, fileOf, inSize, type Known } from "./keeper";
import { freeMark, listedMarks, type MarksSlice, nextBeside } from "./marks/marks";
import { marks as marksText } from "./marks/text";
import { exchanged, isMark, markCalled, markKey, nextMissing, type Picks, picksOf, placesOf, renamed, withoutPick, withPick } from "./picks";
import { isFelt, onlyAgreed } from "./proposals/agreed";
import { openProposals } from "./proposals/proposals";
import { isRuler, type RulerSlice, withEnd } from "./size/ruler";
import type { LandmarksSlice } from "./state";
import { straightened } from "./straighten";
import * as text from "./text";
import { certainWith, type KeptPicks, together, withTheirs } from "./together";

type State = PageSlice & ViewSlice & ScanSlice & LandmarksSlice & MarksSlice & RulerSlice;

const PAUSE_MS = 400; // a run of quick clicks is one save

/** What follows from a change: landmarks were begun with; one was moved; a question about one was answered. */
interface Followed {
  begun(): void;
  moved(): void;
  answered(): void;
}

interface Placed {
  readonly picks: Picks;
  readonly certain: Certain;
}

/** What the outbox keeps of landmarks that could not be saved: those that they began with, and what was made of them. */
interface Waiting {
  readonly scan: Pick<Scan, "id" | "links">;
  readonly base: Known;
  readonly mine: KeptPicks;
}

export function landmarkActions(store: Store<State>, client: Client, followed: Followed, outbox: Outbox) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let waiting: ({ scan: Scan } & Placed) | null = null;
  let onItsWay: Promise<unknown> = Promise.resolve();
  let unsaid: string | null = null; // what saving has complained about last
  const savers: ((scan: string) => void)[] = [];
  const adopted = new WeakMap<Picks, Picks>(); // the same picks, and the same certain ones, with somebody else's
  let isClose: (point: Vector) => boolean = () => false; // whether it is looked at closely on the stage
  const answers = new WeakSet<Picks>(); // picks that an answer has made: undoing it asks for another fit as well

  const list = () => store.get().meta?.landmarks ?? [];
  function labelOf(name: string | null): string | null {
    if (name !== null && isMark(name)) return marksText.spoken(markCalled(name));
    const entry = list().find((each) => each.name === name);
    return entry ? text.landmarks.spoken(entry) : name;
  }

  const spoken = (name: string): string => labelOf(name) ?? name;

  const keeper = createPicksKeeper(client, (of, base, theirs, both) => {
    if (store.get().scan?.info.id !== of.id) return false;
    const { taken, overruled } = both;
    if (taken.length + overruled.length === 0) return true; // both did the same
    const step = (picks: Picks): Picks => {
      const after = withTheirs(picks, base, theirs);
      if (answers.has(picks)) answers.add(after);
      return after;
    };
    const announcement = text.landmarks.changedElsewhere(taken.map(spoken), overruled.map(spoken));
    store.set((state) => {
      const { past, present, future } = state.picks;
      const certain = certainWith(state.certain, both);
      const picks = { past: past.map(step), present: step(present), future: future.map(step) };
      const active = state.active !== null && taken.includes(state.active) && state.active in picks.present ? nextMissing(list(), picks.present, state.skipped, state.active) : state.active;
      adopted.set(present, picks.present).set(state.certain, certain);
      return { picks, certain, active, announcement, ...withProblem(state, "landmarks", announcement) };
    });
    return true;
  });

  const keptOf = ({ picks, certain }: Placed): KeptPicks => ({ picks, certain: certainNames(picks, certain) });
  const placed = (): Placed => ({ picks: store.get().picks.present, certain: store.get().certain });

  /** As the page shows the scan by now: what somebody else has placed may have come since it was to be saved. */
  const shownOf = (scan: Scan, otherwise: Placed): Placed => (store.get().scan?.info.id === scan.id ? placed() : otherwise);

  /** What is shown about saving concerns the scan on the screen; another one is saved all the same. */
  async function save(scan: Scan, asked: Placed, isLast = false): Promise<void> {
    const show = (part: (state: State) => Partial<State>): void =>
      store.set((state) => (state.scan?.info.id === scan.id ? part(state) : {}));
    show(() => ({ saving: "saving" }));
    try {
      let now = asked;
      const mine = (): KeptPicks => {
        now = shownOf(scan, asked);
        return keptOf(now);
      };
      await (isLast ? keeper.saveLast : keeper.save)(scan, mine);
      const isAll = (state: State): boolean => state.picks.present === (adopted.get(now.picks) ?? now.picks) && state.certain === (adopted.get(now.certain) ?? now.certain);
      if (store.get().scan?.info.id !== scan.id || isAll(store.get())) saved(scan.id);
      show((state) => (isAll(state) ? { saving: "saved", ...withoutMessage(state, "landmarks", unsaid) } : {}));
    } catch (error) {
      unsaid = messageOf(error);
      show((state) => ({ saving: "unsaved", ...withProblem(state, "landmarks", unsaid) }));
      outbox.failed("landmarks", scan.id, error);
    }
  }

  function saved(scan: string): void {
    outbox.saved("landmarks", scan);
    for (const follow of savers) follow(scan);
  }

  /** Keeps them until the service has them. */
  function remember(scan: Scan, its = placed()): void {
    const { self, landmarks } = scan.links;
    const waits = { scan: { id: scan.id, links: { self, landmarks } as Scan["links"] }, base: keeper.base(scan.id), mine: keptOf(its) };
    outbox.keep("landmarks", scan.id, scan.patient, waits satisfies Waiting);
  }

  /** A scan that is opened with landmarks that could not be saved. */
  store.select(only("scan"), ({ scan }, before) => {
    if (scan && scan.info.id !== before.scan?.info.id && outbox.kept("landmarks", scan.info.id)) queueMicrotask(() => void saveNow());
  });

  /** With what could not be saved of it before. */
  async function read(scan: Scan): Promise<KeptPicks & Pick<LandmarksSlice, "saving">> {
    const now = await keeper.read(scan);
    const waiting = outbox.kept("landmarks", scan.id) as Waiting | null;
    if (!waiting) return { ...now, saving: "saved" };
    const base = inSize(waiting.base, now.scale);
    const { picks, certain } = inSize({ ...waiting.base, ...waiting.mine }, now.scale);
    const both = together(base, { picks, certain }, now);
    outbox.keep("landmarks", scan.id, scan.patient, { ...waiting, base: keeper.base(scan.id), mine: { picks: both.picks, certain: both.certain } } satisfies Waiting);
    if (both.taken.length + both.overruled.length > 0) {
      const announcement = text.landmarks.changedElsewhere(both.taken.map(spoken), both.overruled.map(spoken));
      setTimeout(() => store.set((state) => (state.scan?.info.id === scan.id ? { announcement, ...withProblem(state, "landmarks", announcement) } : {})), PAUSE_MS); // when it is shown
    }
    return { picks: both.picks, certain: both.certain, saving: "unsaved" };
  }

  /** Tries again to save what waits, of every scan. */
  async function retry(): Promise<void> {
    for (const id of outbox.scans("landmarks")) {
      const waiting = outbox.kept("landmarks", id) as Waiting | null;
      if (store.get().scan?.info.id === id) await saveNow();
      else if (waiting) {
        keeper.base(id, waiting.base);
        await keeper.save(waiting.scan, () => (outbox.kept("landmarks", id) as Waiting | null)?.mine ?? waiting.mine).then(
          () => saved(id),
          (error: unknown) => outbox.failed("landmarks", id, error),
        );
      }
    }
  }

  /** Sends at once what still waits, and waits for what is on its way: before another scan takes the page, or the page goes away. */
  async function flush(isLast = false): Promise<void> {
    clearTimeout(timer);
    const last = waiting;
    waiting = null;
    if (last) onItsWay = Promise.all([onItsWay, save(last.scan, last, isLast)]);
    await onItsWay;
  }

  function saveSoon(): void {
    const { scan } = store.get();
    if (!scan) return;
    if (waiting && waiting.scan.id !== scan.info.id) void flush();
    clearTimeout(timer);
    waiting = { scan: scan.info, ...placed() };
    remember(scan.info);
    store.set({ saving: "unsaved" });
    timer = setTimeout(() => void flush(), PAUSE_MS);
  }

  async function saveNow(): Promise<void> {
    const { scan } = store.get();
    if (scan) await save(scan.info, placed());
  }

  /** The same landmarks elsewhere, and nothing else: what a fit can go on from. */
  function noticeMoves(before: Picks): void {
    const after = store.get().picks.present;
    const names = Object.keys(after);
    if (names.length === Object.keys(before).length && names.every((name) => name in before) && names.some((name) => after[name] !== before[name])) followed.moved();
  }

  function change(picks: Picks, more: Partial<State> = {}): void {
    const before = store.get().picks.present;
    store.set((state) => ({ ...more, picks: record(state.picks, picks) }));
    saveSoon();
    noticeMoves(before);
  }

  const importedSaid = (picks: Picks): string => {
    const { landmarks, marks } = placesOf(picks);
    return text.landmarks.announceImported(Object.keys(landmarks).length, Object.keys(marks).length);
  };

  const spokenOf = (names: readonly string[]): string => names.map((name) => labelOf(name) ?? name).join(", ");

  /** An answer to a question: one step of the history, and at once the fit that belongs to it. */
  function answer(picks: Picks, announcement: string): void {
    answers.add(picks);
    store.set((state) => ({ ...straightened(state, picks), picks: record(state.picks, picks), announcement }));
    saveSoon();
    followed.answered();
  }

  function setCertain(certain: Certain, announcement: string): void {
    store.set({ certain, announcement });
    saveSoon();
    followed.answered();
  }

  /** The picks changed from `before` by going back or forth in the history. */
  function follow(before: Picks, isAnswer: boolean): void {
    saveSoon();
    if (isAnswer) followed.answered();
    else noticeMoves(before);
  }

  return {
    /** The click that places the wanted landmark, and goes on to the next one. */
    place(point: Vector): void {
      const state = store.get();
      const name = state.active;
      if (name === null) return;
      if (isRuler(name)) return store.set(withEnd(state, name, point));
      const picks = withPick(state.picks.present, name, point);
      if (isMark(name)) {
        const next = name in state.beside && !(name in state.picks.present) ? nextBeside(state.beside, picks, name) : null;
        change(picks, { active: next, announcement: marksText.announcePlaced(markCalled(name), next && markCalled(next)) });
        return;
      }
      const skipped = new Set([...state.skipped].filter((other) => other !== name));
      const active = nextMissing(list(), picks, skipped, name);
      change(picks, {
        active,
        skipped,
        announcement: text.landmarks.announcePlaced(labelOf(name) ?? "", labelOf(active)),
      });
    },

    /** A placed landmark goes elsewhere; what is wanted stays wanted. */
    move(name: string, point: Vector): void {
      change(withPick(store.get().picks.present, name, point), { announcement: text.landmarks.announceMoved(labelOf(name) ?? name) });
    },

    want(name: string | null): void {
      store.set({ active: name, ...(name === null ? {} : { step: "points" as const }) });
      if (name !== null) followed.begun();
    },

    /** A mark of the skin under a name that neither scan has. */
    addMark(): void {
      const { picks, beside } = store.get();
      this.want(freeMark(listedMarks(picks.present, beside)));
    },

    /** Marks (by their keys) that were found on the skin and accepted. */
    adopt(found: Picks, announcement: string): void {
      change({ ...store.get().picks.present, ...found }, { announcement });
    },

    /** The picks of a scan that waits have become these. */
    saveWaiting(scan: Scan, its: Placed): Promise<void> {
      remember(scan, its);
      return save(scan, its);
    },

    /** False where it cannot be called so; the page says why. */
    renameMark(name: string, called: string): boolean {
      const { picks } = store.get();
      if (markKey(called) === name) return true;
      const isLandmark = list().some((entry) => entry.name === called);
      const why = called === "" ? marksText.isEmpty : isLandmark ? marksText.isLandmark(called) : markKey(called) in picks.present ? marksText.isTaken(called) : null;
      store.set((state) => withProblem(state, "landmarks", why));
      if (why === null) change(renamed(picks.present, name, markKey(called)));
      return why === null;
    },

    /** The stage says what is looked at closely. */
    seenBy(judge: (point: Vector) => boolean): void {
      isClose = judge;
    },

    /** Proposals become picks, in one step of the history: the person's own where viewed closely, else only agreed to. */
    confirm(names: readonly string[]): void {
      const state = store.get();
      const taken = openProposals(state.proposals, state.picks.present).filter(({ name }) => names.includes(name));
      if (taken.length === 0) return;
      const picks = { ...state.picks.present, ...Object.fromEntries(taken.map(({ name, point }) => [name, point])) };
      const skipped = new Set([...state.skipped].filter((name) => !(name in picks)));
      const wasWanted = state.active !== null && state.active in picks;
      const active = wasWanted ? nextMissing(list(), picks, skipped, state.active) : state.active;
      const looked = taken.filter(({ name, point }) => isClose(point) && !isFelt(name)).map(({ name }) => name);
      const announcement = text.proposals.announceConfirmed(taken.map(({ name }) => labelOf(name) ?? name));
      change(picks, { ...straightened(state, picks), certain: { ...state.certain, ...certainAt(picks, looked) }, active, skipped, announcement });
    },

    /** The proposal for the wanted landmark, or the pick that was only agreed to before. */
    confirmWanted(): void {
      const state = store.get();
      const { active, picks } = state;
      if (active === null) return;
      if (!(active in onlyAgreed(state))) this.confirm([active]);
      else if (isFelt(active)) store.set({ announcement: text.proposals.felt });
      else if (!isClose(picks.present[active]!)) store.set({ announcement: text.proposals.nearer });
      else this.keep([active]);
    },

    wantNext(): void {
      const state = store.get();
      if (!state.scan) return;
      const name = nextMissing(list(), state.picks.present, state.skipped, state.active);
      if (name !== null) this.want(name);
    },

    skip(): void {
      const state = store.get();
      if (state.active === null) return;
      const skipped = new Set([...state.skipped, state.active]);
      store.set({ skipped, active: nextMissing(list(), state.picks.present, skipped, state.active) });
    },

    /** What is asked about stays as it was picked; from now on every fit follows it. */
    keep(names: readonly string[]): void {
      const { picks, certain } = store.get();
      setCertain({ ...certain, ...certainAt(picks.present, names) }, text.questions.announceKept(spokenOf(names)));
    },

    /** It may be asked about again. */
    unkeep(name: string): void {
      setCertain(withoutPick(store.get().certain, name), text.questions.announceUnkept(labelOf(name) ?? name));
    },

    /** Places that a person has looked at closely: one step of the history, and at once the fit that knows them. */
    check(places: Picks, announcement: string): void {
      const { picks, certain } = store.get();
      const all = { ...picks.present, ...places };
      store.set({ certain: { ...certain, ...certainAt(all, Object.keys(places)) } });
      answer(all, announcement);
    },

    takeOut: (name: string): void => answer(withoutPick(store.get().picks.present, name), text.questions.announceTakenOut(labelOf(name) ?? name)),
    exchange: (names: readonly string[]): void => answer(exchanged(store.get().picks.present, names), text.questions.announceExchanged(names.length > 2 ? text.questions.allSides : spokenOf(names))),

    /** Other picks instead, as one step to undo. */
    restore: (picks: Picks, certain: readonly string[] = []): void => change(picks, { certain: certainAt(picks, certain) }),
    remove: (name: string): void => change(withoutPick(store.get().picks.present, name)),

    undo(): void {
      if (store.get().picks.past.length === 0) return;
      const before = store.get().picks.present;
      const picks = undo(store.get().picks);
      store.set({ picks, announcement: "", undone: { says: text.landmarks.undone(text.picksSaid(picks.present, before, list())) } });
      follow(before, answers.has(before));
    },

    redo(): void {
      if (store.get().picks.future.length === 0) return;
      const before = store.get().picks.present;
      const picks = redo(store.get().picks);
      store.set({ picks, announcement: "", undone: { says: text.landmarks.redone(text.picksSaid(before, picks.present, list())) } });
      follow(before, answers.has(store.get().picks.present));
    },

    useExample(): void {
      const example = store.get().scan?.example;
      if (!example) return;
      const picks = picksOf(example);
      const announcement = importedSaid(picks);
      change(picks, { ...straightened(store.get(), picks), active: null, step: "points", announcement });
    },

    async importFile(file: File): Promise<void> {
      const scan = store.get().scan;
      if (!scan) return;
      try {
        const read = await client.landmarkFile(scan.info, file);
        if (store.get().scan?.info.id !== scan.info.id) return;
        const picks = picksOf(read);
        const certain = { ...store.get().certain, ...certainAt(picks, read.certain ?? []) };
        const { scale } = scan.info;
        const sizeSaid = scale ? text.landmarks.inTrueSize(scale.factor) : null;
        const announcement = [importedSaid(picks), ...(sizeSaid ? [sizeSaid] : [])].join(" ");
        store.set((state) => withProblem(state, "landmarks", sizeSaid));
        const all = { ...store.get().picks.present, ...picks };
        change(all, { ...straightened(store.get(), all), certain, active: null, announcement });
      } catch (error) {
        store.set((state) => withProblem(state, "landmarks", messageOf(error)));
      }
    },

    /** `kind`: the ending of one of the files that the service writes. */
    async exportFile(kind: string): Promise<void> {
      const state = store.get();
      if (!state.scan) return;
      try {
        const file = { ...fileOf(keptOf(placed())), confidence: onlyAgreed(state) };
        saveBlob(fileName(state.scan, `landmarks.${kind}`), await client.writeLandmarks(state.scan.info, kind, file));
      } catch (error) {
        store.set((now) => withProblem(now, "landmarks", messageOf(error)));
      }
    },

    saveNow,
    flush,
    /** As the service has them now; from here on what is saved of this scan is a change of these. */
    read,
    retry,
    /** Called when what waited of a scan is saved. */
    followSaved: (follow: (scan: string) => void): void => void savers.push(follow),
    /** Whether somebody else has placed landmarks since they were read here; then the page has them too. */
    async look(): Promise<void> {
      const { scan } = store.get();
      if (scan) await keeper.look(scan.info, () => (store.get().scan?.info.id === scan.info.id && store.get().saving === "saved" ? keptOf(placed()) : null)).catch(() => undefined); // the next save will say what is wrong
    },
  };
}

export type LandmarkActions = ReturnType<typeof landmarkActions>;
