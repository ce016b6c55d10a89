// Files that come together are one patient's: the first scan comes onto the page and is fitted, the others are added to it
// and fitted beside it; lesions of files of their own go to the image that came with them, or that the patient on the page has;
// files of landmarks go to the scan that they lie on, and where that is not clear nobody guesses.
import { ApiError, type Client } from "../../api/client";
import type { Scan, Vector } from "../../api/types";
import type { LandmarkActions } from "../../landmarks/actions";
import { LANDMARK_ENDINGS, picksOf } from "../../landmarks/picks";
import type { ScanActions } from "../../scan/actions";
import { sizeDoubt } from "../../scan/state";
import type { PlanActions } from "../../plan/actions";
import type { StancesActions } from "../../stances/actions";
import { messageOf, withProblem } from "../../store/problems";
import type { Store } from "../../store/store";
import { metresFromMm } from "../../ui/units";
import type { Session } from "../session";
import { bringing as words } from "../text";
import { dicomOf, isVolume } from "./fileKinds";

const SLICES = 5; // DICOM files beside each other that are slices of one series, and no series each
const NEAR_M = 0.03; // a landmark is on or just below the skin

const endsWith = (file: File, endings: readonly string[]): boolean => endings.some((ending) => file.name.toLowerCase().endsWith(ending));

export interface Takers {
  readonly scan: Pick<ScanActions, "upload" | "add" | "addLesions">;
  readonly stances: Pick<StancesActions, "addBeside">;
  readonly landmarks: Pick<LandmarkActions, "importFile">;
  readonly plan: Pick<PlanActions, "takeOver">;
  /** The scan that has just come is fitted, where nothing speaks against it. */
  readonly begin: () => void;
}

/** Loaded with the first files. */
export function createBringing(store: Store<Session>, client: Pick<Client, "landmarkFile" | "saveLandmarks">, others: Takers) {
  const whyNoScan = new Map<File, string>(); // of volumes that may be lesions alone
  const fail = (message: string): void => store.set((state) => withProblem(state, "scan", message));

  async function files(all: readonly File[]): Promise<void> {
    const { meta, scan } = store.get();
    const endings = meta?.scan_files.endings ?? [];
    const landmarks = all.length === 1 && !scan ? [] : all.filter((file) => endsWith(file, LANDMARK_ENDINGS) && !endsWith(file, endings));
    if (landmarks.length === 1 && all.length === 1) return others.landmarks.importFile(landmarks[0]!);
    const rest = all.filter((file) => !landmarks.includes(file));
    const dicom = new Map(await Promise.all(rest.map(async (file) => [file, await dicomOf(file)] as const)));
    if (rest.filter((file) => dicom.get(file) === "image").length > SLICES) {
      fail(words.slices);
      return;
    }
    const known = rest.length === 1 || endings.length === 0 ? rest : rest.filter((file) => endsWith(file, endings) || dicom.get(file)); // one alone is sent whatever its name, and all before the service has said which it takes
    const onPage = imageOnPage();
    const drawn = known.filter((file) => dicom.get(file) === "segments" || /\.seg\.nrrd$/i.test(file.name));
    const isDrawn = (file: File): boolean => drawn.includes(file) && (drawn.length === known.length ? onPage !== null : known.some((each) => isVolume(each) && !drawn.includes(each)));
    const scans = known.filter((file) => !isDrawn(file)).sort((a, b) => Number(isVolume(a)) - Number(isVolume(b)));
    if (scans.length === 0 && drawn.length > 0 && onPage) return lesions(drawn, [onPage]);
    if (scans.length === 0) {
      fail(words.none(all.length));
      return;
    }
    const mayBeDrawn: File[] = []; // volumes that are no scan
    let first = scans.shift()!;
    while (!(await others.scan.upload(first))) {
      const next = scans.findIndex(isVolume);
      if (!isVolume(first) || next < 0 || store.get().problems.scan === undefined) return;
      mayBeDrawn.push(first);
      whyNoScan.set(first, store.get().problems.scan!);
      [first] = scans.splice(next, 1) as [File];
    }
    const patient = store.get().scan!.info;
    const added: Scan[] = [patient];
    const belongings = known.filter(isDrawn);
    if (landmarks.length + belongings.length + mayBeDrawn.length === 0) others.begin(); // the model settles while the others come
    for (const file of scans) {
      try {
        const info = await others.scan.add(file, patient.patient);
        if (info) added.push(info);
      } catch (error) {
        if (!isVolume(file) || !(error instanceof ApiError) || error.status !== 422) fail(messageOf(error));
        else mayBeDrawn.push(file);
        whyNoScan.set(file, messageOf(error));
      }
    }
    await lesions([...belongings, ...mayBeDrawn], added.filter(({ image }) => image));
    const unplaced = await place(landmarks, added);
    others.begin();
    for (const info of added.slice(1)) await others.stances.addBeside(info, store.get().fitsAtOnce && sizeDoubt(info) === "");
    const left = rest.length - known.length;
    const said = [...(left > 0 ? [words.notTaken(left)] : []), ...(unplaced > 0 ? [words.unplaced(unplaced)] : [])];
    if (said.length > 0) fail(said.join(" "));
  }

  /** The image of the patient on the page. */
  function imageOnPage(): Scan | null {
    const { scan, stances } = store.get();
    return [scan?.info, stances.other?.scan?.info].find((info) => info?.image) ?? null;
  }

  /** Into the plan, on the one image that they were drawn on. */
  async function lesions(files: readonly File[], images: readonly Scan[]): Promise<void> {
    const on = images.length === 1 ? images[0]! : null;
    for (const file of files) {
      try {
        if (!on) fail(whyNoScan.get(file) ?? words.noImage(images.length));
        else if (await others.scan.addLesions(file, on)) await others.plan.takeOver();
      } catch (error) {
        fail([whyNoScan.get(file), messageOf(error)].filter((said) => said !== undefined).join(" "));
      }
    }
    whyNoScan.clear();
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

  return files;
}

/** mm, in the box of the scan. */
function isWithin(point: Vector, { bounds_m: { min, max } }: Pick<Scan, "bounds_m">): boolean {
  return point.every((mm, axis) => metresFromMm(mm) > min[axis]! - NEAR_M && metresFromMm(mm) < max[axis]! + NEAR_M);
}
