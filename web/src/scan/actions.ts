// Bringing a scan in: from a file, from the example, from the address; and turning it upright.
import { ApiError, type Client, type UploadFields } from "../api/client";
import type { Cut, Cuts, ExampleScan, Frame, Question, Scan, TakenAs, TakenLesions, UnitChoice, VolumeAnswers } from "../api/types";
import { type History, record, redo, startHistory, undo } from "../store/history";
import type { PageSlice } from "../store/page";
import type { Outbox } from "../store/outbox";
import { messageOf, withoutMessage, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { tidyFrame, type Turn, turned } from "../viewer/frame";
import { fromFront, type ViewSlice } from "../viewer/state";
import { type Crop, type Crops, cropsFrom, cropsOf, cutsOf, mergedCrops, MOST, NO_CROPS } from "./crop";
import type { ScanSlice, ScanState } from "./state";
import * as text from "./text";

type State = PageSlice & ViewSlice & ScanSlice;

const ASKED: readonly string[] = ["frame", "series", "same_place"]; // what a person can answer here

/** What the other features keep with a scan, and do when another one is opened. */
export interface ScanContents {
  /** Reads what the service keeps of it: the state that the page starts with, and how the body stands. */
  read(info: ExampleScan, isNew: boolean): Promise<{ readonly state: object; readonly stands: Pick<ScanState, "frame" | "frameFrom"> }>;
  /** The state of a page without a scan. */
  none(): object;
  /** What is given up when a scan could not be brought and the page goes back to this step. */
  interrupted(): object;
  /** Nothing goes on with the scan that was open. */
  stop(): void;
  /** What was found on it does not hold any more, because something was cut away. */
  cut(): object;
}

/** A folder, or a file that was moved meanwhile, would break off the sending as a service does that does not answer. */
async function checkReadable(file: File): Promise<void> {
  try {
    await file.slice(0, 1).arrayBuffer();
  } catch {
    throw new ApiError(text.errors.unreadable, 0);
  }
}

/** What the outbox keeps of cuts that could not be saved. */
interface Waiting {
  readonly scan: Pick<Scan, "id" | "links" | "patient">;
  readonly before: Cuts; // that they were made from
  readonly cuts: readonly Cut[];
}

/** What has been brought, and what else is known of it. */
interface Brought {
  readonly info: ExampleScan;
  readonly file: File | null;
  readonly own: Frame | null;
  readonly units?: UnitChoice;
  readonly answers?: VolumeAnswers;
  readonly isNew?: boolean;
}

export function scanActions(store: Store<State>, client: Client, contents: ScanContents, outbox: Outbox) {
  let saving = Promise.resolve(); // one after the other: the last one stays
  let known: Cuts = { cuts: [], digest: "" }; // what the service was last seen to keep of the scan's cuts
  let unsaid: string | null = null; // what saving cuts has complained about last
  let generation = 0; // the scan asked for last wins over slower, earlier ones

  /** Shows `info` as the page's scan; everything that belonged to the one before is dropped. */
  async function adopt({ info, file, own, units = "auto", answers = {}, isNew = false }: Brought, title: string, mine: number): Promise<void> {
    const before = store.get().meta;
    const ofModel = before !== null && before.model.name !== info.model ? client.meta(info.model) : before;
    const [mesh, kept, { cuts, digest }, meta] = await Promise.all([client.mesh(info), contents.read(info, isNew), client.cuts(info), ofModel]);
    if (mine !== generation) return;
    contents.stop();
    known = { cuts, digest };
    const waiting = outbox.kept("cuts", info.id) as Waiting | null;
    const crops = waiting ? mergedCrops(cropsFrom(waiting.before.cuts), cropsFrom(waiting.cuts), cropsFrom(cuts)) : cropsFrom(cuts);
    store.set((state) => ({
      ...kept.state,
      meta,
      loading: null,
      scan: {
        info,
        title,
        mesh,
        file,
        units,
        answers,
        ...(own ? { frame: tidyFrame(own), frameFrom: "person" } : kept.stands),
        example: info.example_landmarks ?? null,
        crops: startHistory(crops),
        cuts: waiting ? null : digest,
      },
      step: "body",
      overlay: "scan",
      ...fromFront(state),
      problems: {},
    }));
    const { scan } = store.get();
    if (waiting && scan) saving = saving.then(() => saveCrops(scan));
  }

  /** `ask` gives null when a person has called it off. */
  async function bring(title: string, ask: () => Promise<Brought | null>): Promise<boolean> {
    answer(null); // of what was being brought until now
    const mine = ++generation;
    store.set((state) => ({ loading: { phase: "preparing", share: 0, title }, ...withProblem(state, "scan", null) }));
    try {
      const brought = await ask();
      if (mine !== generation) return false;
      if (brought) await adopt(brought, title, mine);
      else store.set({ ...contents.interrupted(), loading: null });
      return brought !== null && mine === generation;
    } catch (error) {
      if (mine === generation) {
        const gone = error instanceof ApiError && error.status === 404;
        const message = gone ? text.errors.noScan : messageOf(error);
        store.set((state) => ({ ...contents.interrupted(), loading: null, step: "body", ...withProblem(state, "scan", message) }));
      }
      return false;
    }
  }

  function changeCrops(change: (crops: History<Crops>) => History<Crops>, announcement: string): void {
    const before = cropsOf(store.get().scan);
    store.set((state) => (state.scan ? { scan: { ...state.scan, crops: change(state.scan.crops ?? startHistory(NO_CROPS)) }, showLoose: false, pointedCut: null, announcement, ...withProblem(state, "scan", null) } : {}));
    const { scan } = store.get();
    if (!scan || cropsOf(scan) === before) return;
    store.set({ scan: { ...scan, cuts: null } });
    const { id, links, patient } = scan.info;
    outbox.keep("cuts", id, patient, { scan: { id, links, patient }, before: known, cuts: cutsOf(cropsOf(scan)) } satisfies Waiting);
    saving = saving.then(() => saveCrops(scan));
  }

  /** Unless they have been changed again meanwhile: the next saving has them all. */
  async function saveCrops(of: ScanState): Promise<void> {
    const crops = cropsOf(of);
    const { scan } = store.get();
    const isNow = (): boolean => store.get().scan?.info.id === of.info.id && cropsOf(store.get().scan) === crops;
    if (scan?.info.id === of.info.id && !isNow()) return;
    const before = known;
    try {
      const kept = await client.saveCuts(of.info, cutsOf(crops), before.digest);
      if (store.get().scan?.info.id === of.info.id) known = kept;
      if (isNow() || store.get().scan?.info.id !== of.info.id) outbox.saved("cuts", of.info.id); // else the next saving has more
      if (isNow()) store.set((state) => ({ scan: { ...state.scan!, cuts: kept.digest }, ...contents.cut(), ...withoutMessage(state, "scan", unsaid) }));
    } catch (error) {
      if (error instanceof ApiError && error.status === 412 && isNow()) await bringTogether(of, before);
      else {
        unsaid = text.crop.unsaved(messageOf(error));
        if (isNow()) store.set((state) => withProblem(state, "scan", unsaid));
        outbox.failed("cuts", of.info.id, error);
      }
    }
  }

  /** Tries again to save cuts that wait, of every scan. */
  async function retry(): Promise<void> {
    for (const id of outbox.scans("cuts")) {
      const { scan } = store.get();
      const waiting = outbox.kept("cuts", id) as Waiting | null;
      if (scan?.info.id === id) {
        saving = saving.then(() => saveCrops(scan));
        await saving;
      } else if (waiting) await saveWaiting(waiting);
    }
  }

  /** Of a scan that is not on the page: brought together with what is there now. */
  async function saveWaiting({ scan, before, cuts }: Waiting): Promise<void> {
    try {
      const now = await client.cuts(scan);
      const both = mergedCrops(cropsFrom(before.cuts), cropsFrom(cuts), cropsFrom(now.cuts));
      await client.saveCuts(scan, cutsOf(both), now.digest);
      outbox.saved("cuts", scan.id);
    } catch (error) {
      outbox.failed("cuts", scan.id, error);
    }
  }

  /** Another tab has cut the same scan: its cuts are seen here too, and kept together with those made here. */
  async function bringTogether(of: ScanState, before: Cuts): Promise<void> {
    try {
      const theirs = await client.cuts(of.info);
      if (store.get().scan?.info.id !== of.info.id) return;
      known = theirs;
      const both = mergedCrops(cropsFrom(before.cuts), cropsOf(store.get().scan), cropsFrom(theirs.cuts));
      changeCrops((crops) => record(crops, both), text.crop.together);
    } catch (error) {
      store.set((state) => withProblem(state, "scan", text.crop.unsaved(messageOf(error))));
    }
  }

  let chosen = Promise.resolve(); // until the model of what is brought next is known

  let answered: (value: string | null) => void = () => undefined; // whoever waits for the answer to what is asked

  function answer(value: string | null): void {
    store.set({ asked: null });
    answered(value);
  }

  const askPerson = (asked: Question): Promise<string | null> =>
    new Promise((done) => {
      answered = done;
      store.set({ asked });
    });

  /** With what a person answers where the file leaves something open; null when that is called off. */
  async function send(file: File, said: UploadFields, progress: (share: number) => void, mine: number): Promise<Brought | null> {
    try {
      const info = await client.upload(file, said, progress);
      const { units, model: _model, patient: _patient, again: _again, group: _group, ...answers } = said;
      return { info, file, own: null, units, answers, isNew: true };
    } catch (error) {
      if (error instanceof ApiError && error.status === 409) throw new ApiError(text.errors.alreadyHere, 409);
      const answers = mine === generation ? await answersTo(error) : undefined;
      if (answers === undefined) throw error;
      return answers && send(file, { ...said, ...answers }, progress, mine);
    }
  }

  /** What a person says to a question of the service; null when that is called off, undefined for what asks nothing. */
  async function answersTo(error: unknown): Promise<VolumeAnswers | null | undefined> {
    const question = error instanceof ApiError ? error.question : null;
    if (!question || !ASKED.includes(question.field)) return undefined;
    const answer = await askPerson(question);
    return answer === null ? null : { [question.field]: answer };
  }

  /** `instead`: that scan, with which nothing has been done, is read anew and deleted.  `patient`: whose it is. */
  function upload(file: File, units: UnitChoice = "auto", answers: VolumeAnswers = {}, instead: Scan | null = null, patient = instead?.patient): Promise<boolean> {
    const title = text.uploaded;
    return bring(title, async () => {
      const mine = generation;
      const progress = (share: number): void => {
        const phase = share < 1 ? "sending" : "preparing";
        if (mine === generation) store.set({ loading: { phase, share, title } });
      };
      progress(0);
      await chosen;
      await checkReadable(file);
      const said: UploadFields = { units, model: store.get().meta?.model.name, patient, group: patient === undefined ? store.get().group || undefined : undefined, again: instead ? "true" : undefined, ...answers };
      const brought = await send(file, said, progress, mine);
      if (brought && instead && mine === generation) await client.deleteScan(instead);
      return brought;
    });
  }

  function chooseModel(name: string): Promise<void> {
    chosen = client.meta(name).then(
      (meta) => store.set({ meta }),
      (error: unknown) => store.set((state) => withProblem(state, "scan", messageOf(error))),
    );
    return chosen;
  }

  return {
    upload,

    /** What the file does not say, as a person knows it; null calls the upload off. */
    answer,

    /** By their numbers, as what segments of the label map are to be taken: its file is read again so. */
    takeSegments(chosen: Readonly<Record<number, TakenAs>>): Promise<boolean> {
      const { scan } = store.get();
      if (!scan?.file) return Promise.resolve(false);
      const segments = { ...scan.answers?.segments, ...chosen };
      return upload(scan.file, scan.units, { ...scan.answers, segments }, scan.info);
    },

    takeExample(name: string): Promise<boolean> {
      const label = store.get().examples.find((example) => example.name === name)?.label ?? name;
      return bring(label, async () => ({ info: await client.importExample(name, store.get().group), file: null, own: null, isNew: true }));
    },

    /** The scan that the address names. */
    open(scan: string, own: Frame | null): Promise<boolean> {
      return bring(text.uploaded, async () => ({ info: await client.scan(scan), file: null, own }));
    },

    /** Its size is right, whatever speaks against it. */
    confirm: (): void => store.set((state) => ({ confirmed: state.scan?.info.id ?? null })),

    /** It is of whom its model is: the service keeps the answer. */
    async confirmModel(): Promise<void> {
      const { scan } = store.get();
      if (!scan) return;
      const say = (model_said: boolean, problem: string | null): void =>
        store.set((state) => (state.scan?.info.id === scan.info.id ? { scan: { ...state.scan, info: { ...state.scan.info, model_said } }, ...withProblem(state, "scan", problem) } : {}));
      say(true, null);
      await client.sayModel(scan.info).catch((error: unknown) => say(false, messageOf(error)));
    },

    /** Another scan of this patient, which does not come onto the page; null when a person has called it off. */
    async add(file: File, patient: string): Promise<Scan | null> {
      await checkReadable(file);
      const said: UploadFields = { units: "auto", model: store.get().meta?.model.name, patient };
      return (await send(file, said, () => undefined, generation))?.info ?? null;
    },

    /** Lesions of a file that was drawn on the image of this scan; null when a person has called it off. */
    async addLesions(file: File, scan: Scan, said: VolumeAnswers = {}): Promise<TakenLesions | null> {
      try {
        const taken = await client.addLesions(scan, file, said);
        store.set(({ lesionFiles: { [scan.id]: before, ...others } }) => ({ lesionFiles: { ...others, [scan.id]: { lesions: taken.lesions, segments: [...(before?.segments ?? []), ...taken.segments], notes: [...(before?.notes ?? []), ...taken.notes] } } }));
        return taken;
      } catch (error) {
        const answers = await answersTo(error);
        if (answers === undefined) throw error;
        return answers && this.addLesions(file, scan, { ...said, ...answers });
      }
    },

    /** The same file, read in another unit or for another model; the scan that is there gives way. */
    async readAgain({ units, model }: { units?: UnitChoice; model?: string }): Promise<boolean> {
      const { scan } = store.get();
      if (!scan?.file) return false;
      if (model !== undefined) await chooseModel(model);
      return upload(scan.file, units ?? scan.units, scan.answers, scan.info);
    },

    turn(turn: Turn): void {
      store.set((state) =>
        state.scan
          ? {
              scan: { ...state.scan, frame: turned(state.scan.frame, turn), frameFrom: "person" },
              ...fromFront(state),
            }
          : {},
      );
    },

    /** Back to the empty page; the scan itself stays with the service. */
    leave(): Promise<boolean> {
      answer(null);
      generation += 1;
      contents.stop();
      store.set({ ...contents.none(), scan: null, loading: null, step: "body", problems: {} });
      return Promise.resolve(true);
    },

    /** While it is in the hand the scan is seen alone. */
    takeLasso: (isCropping: boolean): void => store.set((state) => ({ isCropping, ...(isCropping ? { step: "body", overlay: "scan", showLoose: false } : {}), announcement: isCropping ? text.crop.how : "", ...withProblem(state, "scan", null) })),

    /** Cuts away what the lasso went around. */
    crop(crop: Crop): void {
      if (cropsOf(store.get().scan).length < MOST.cuts) changeCrops((crops) => record(crops, [...crops.present, crop]), text.crop.hidden);
      else store.set((state) => withProblem(state, "scan", text.crop.tooMany(MOST.cuts)));
    },
    /** Brings one part back, whichever of them. */
    bringBack: (which: number): void => changeCrops((crops) => record(crops, crops.present.filter((_, i) => i !== which)), text.crop.shown),
    /** It is seen where it was while its button is pointed at. */
    pointAtCut: (pointedCut: number | null): void => store.set({ pointedCut }),
    uncrop: (): void => changeCrops((crops) => record(crops, NO_CROPS), text.crop.shown),
    undoCrop: (): void => changeCrops(undo, text.crop.shown),
    redoCrop: (): void => changeCrops(redo, text.crop.hidden),
    cropRefused: (): void => store.set((state) => withProblem(state, "scan", text.crop.nothingLeft)),

    /** Of the scans that are brought from now on. */
    chooseModel,

    /** The grey values of its image. */
    volume: (scan: Scan): Promise<ArrayBuffer> => client.volume(scan),

    retry,
    /** When the cuts that were made are saved. */
    settled: (): Promise<void> => saving,
    showRelief: (showRelief: boolean): void => store.set({ showRelief }),
    showLoose: (showLoose: boolean): void => store.set({ showLoose }),
    showColours: (showColours: boolean): void => store.set({ showColours }),
  };
}

export type ScanActions = ReturnType<typeof scanActions>;
