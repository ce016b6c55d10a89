// Files that come together are one patient's: the first scan comes onto the page and is fitted, the others are added to it
// and fitted beside it; files of landmarks go to the scan that they lie on, and where that is not clear nobody guesses.
import type { Client } from "../api/client";
import type { Scan, Vector } from "../api/types";
import type { FitActions } from "../fit/actions";
import type { LandmarkActions } from "../landmarks/actions";
import { LANDMARK_ENDINGS, picksOf } from "../landmarks/picks";
import type { ScanActions } from "../scan/actions";
import { isSizeAsked, sizeDoubt } from "../scan/state";
import type { StancesActions } from "../stances/actions";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { metresFromMm } from "../ui/units";
import type { Session } from "./session";
import { bringing as words } from "./text";

const NEAR_M = 0.03; // a landmark is on or just below the skin

const endsWith = (file: File, endings: readonly string[]): boolean => endings.some((ending) => file.name.toLowerCase().endsWith(ending));
const isImage = (file: File): boolean => /\.(nii|nii\.gz|dcm)$/i.test(file.name);

interface Others {
  readonly scan: Pick<ScanActions, "upload" | "takeExample" | "add" | "confirm" | "confirmModel" | "readAgain" | "takeSegments">;
  readonly stances: Pick<StancesActions, "addBeside" | "takeExampleBeside">;
  readonly fit: Pick<FitActions, "start">;
  readonly landmarks: Pick<LandmarkActions, "importFile">;
}

export function bringActions(store: Store<Session>, client: Pick<Client, "landmarkFile" | "saveLandmarks">, others: Others) {
  const fail = (message: string): void => store.set((state) => withProblem(state, "scan", message));

  /** A scan that has just come is fitted at once, unless something about it is asked first. */
  function begin(): void {
    const { scan, fit, fitsAtOnce } = store.get();
    if (scan && fit === null && fitsAtOnce && !isSizeAsked(store.get())) void others.fit.start();
  }

  async function files(all: readonly File[]): Promise<void> {
    const { meta, scan } = store.get();
    const endings = meta?.scan_files.endings ?? [];
    const landmarks = all.length === 1 && !scan ? [] : all.filter((file) => endsWith(file, LANDMARK_ENDINGS) && !endsWith(file, endings));
    if (landmarks.length === 1 && all.length === 1) return others.landmarks.importFile(landmarks[0]!);
    const rest = all.filter((file) => !landmarks.includes(file));
    const scans = rest.length === 1 ? rest : rest.filter((file) => endsWith(file, endings)); // one alone is sent whatever its name
    scans.sort((a, b) => Number(isImage(a)) - Number(isImage(b)));
    const [first, ...further] = scans;
    if (!first) fail(words.none(all.length));
    if (!first) return;
    if (!(await others.scan.upload(first))) return;
    const patient = store.get().scan!.info;
    if (landmarks.length === 0) begin(); // the model settles while the others come
    const added: Scan[] = [patient];
    for (const file of further) {
      try {
        const info = await others.scan.add(file, patient.patient);
        if (info) added.push(info);
      } catch (error) {
        fail(messageOf(error));
      }
    }
    const unplaced = await place(landmarks, added);
    begin();
    for (const info of added.slice(1)) await others.stances.addBeside(info, store.get().fitsAtOnce && sizeDoubt(info) === "");
    const left = rest.length - scans.length;
    const said = [...(left > 0 ? [words.notTaken(left)] : []), ...(unplaced > 0 ? [words.unplaced(unplaced)] : [])];
    if (said.length > 0) fail(said.join(" "));
  }

  /** How many of the files lie on none, or on several of the scans. */
  async function place(landmarks: readonly File[], scans: readonly Scan[]): Promise<number> {
    let unplaced = 0;
    for (const file of landmarks) {
      try {
        const read = await client.landmarkFile(scans[0]!, file);
        const points = Object.values(picksOf(read));
        const on = scans.filter((scan) => points.every((point) => isWithin(point, scan)));
        if (on.length !== 1) unplaced += 1;
        else if (on[0]!.id === store.get().scan?.info.id) await others.landmarks.importFile(file);
        else await client.saveLandmarks(on[0]!, await client.landmarkFile(on[0]!, file), null);
      } catch (error) {
        fail(messageOf(error));
      }
    }
    return unplaced;
  }

  return {
    files,
    begin,

    /** The file of the scan on the page, read otherwise. */
    async again(how: Parameters<ScanActions["readAgain"]>[0]): Promise<void> {
      if (!(await others.scan.readAgain(how))) return;
      if (how.model !== undefined) await others.scan.confirmModel();
      begin();
    },

    takeSegments: async (chosen: Parameters<ScanActions["takeSegments"]>[0]): Promise<boolean> => {
      const isThere = await others.scan.takeSegments(chosen);
      if (isThere) begin();
      return isThere;
    },

    /** Scans of the example patient, of whom there is one. */
    async examples([first, ...further]: readonly string[]): Promise<void> {
      if (first === undefined || !(await others.scan.takeExample(first))) return;
      begin();
      for (const name of further) await others.stances.takeExampleBeside(name, store.get().fitsAtOnce);
    },

    /** Somebody says that the size which looked wrong is right. */
    sizeIsRight: (): void => {
      others.scan.confirm();
      begin();
    },

    chooseFitsAtOnce: (fitsAtOnce: boolean): void => store.set({ fitsAtOnce }),
  };
}

/** mm, in the box of the scan. */
function isWithin(point: Vector, { bounds_m: { min, max } }: Pick<Scan, "bounds_m">): boolean {
  return point.every((mm, axis) => metresFromMm(mm) > min[axis]! - NEAR_M && metresFromMm(mm) < max[axis]! + NEAR_M);
}
