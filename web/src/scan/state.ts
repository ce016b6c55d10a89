// The scan on the page, and how it came there.
import type { Frame, LandmarkFile, Question, Scan, TakenLesions, UnitChoice, VolumeAnswers } from "../api/types";
import type { History } from "../store/history";
import { type Crops, cropsOf } from "./crop";

export interface ScanState {
  readonly info: Scan;
  readonly title: string;
  readonly mesh: ArrayBuffer | null; // glTF binary, metres, the scan's own axes; null behind a link that does not show it
  readonly frame: Frame;
  readonly frameFrom: "service" | "landmarks" | "fit" | "person"; // who says so; the last of these wins
  readonly file: File | null; // kept, so that another unit needs no second choosing
  readonly units?: UnitChoice; // with which that file was read, and the answers
  readonly answers?: VolumeAnswers;
  readonly example: LandmarkFile | null;
  readonly crops?: History<Crops>; // what is cut away by hand
  readonly cuts?: string | null; // which cuts the service keeps, as fits say with which they were made; null: not known yet
}

export interface ScanSlice {
  readonly loading: { readonly phase: "sending" | "preparing"; readonly share: number; readonly title: string } | null;
  readonly asked: Question | null; // what its file does not say: nothing is uploaded before a person has
  readonly scan: ScanState | null;
  readonly lesionFiles: Readonly<Record<string, TakenLesions>>; // by scan: what files that were drawn on its image had, as long as the page is open
  readonly confirmed: string | null; // the scan whose doubtful size a person has called right
  readonly showColours: boolean;
  readonly showLoose: boolean; // the table and loose pieces as well
  readonly showRelief: boolean; // folds darker where a scan has no colours
  readonly isCropping: boolean; // the lasso is in the hand
  readonly pointedCut: number | null; // which of the cuts its button is pointed at
}

export const initialScan: ScanSlice = { loading: null, asked: null, scan: null, lesionFiles: {}, confirmed: null, showColours: true, showLoose: false, showRelief: true, isCropping: false, pointedCut: null };

/** Of an image or a label map: its axes are the patient's, its unit is its own. */
export const isVolume = (scan: Pick<Scan, "segments" | "image">): boolean => (scan.segments ?? []).length > 0 || scan.image != null;

/** What speaks against its size; an image says itself how large it is, and often shows a part of the torso. */
export const sizeDoubt = (scan: Pick<Scan, "size_doubt" | "segments" | "image">): string => (isVolume(scan) ? "" : (scan.size_doubt ?? ""));

/** Its size may be wrong, and nobody has said that it is right: nothing is made of it before. */
export const isSizeAsked = ({ scan, confirmed }: Pick<ScanSlice, "scan" | "confirmed">): boolean => scan !== null && sizeDoubt(scan.info) !== "" && confirmed !== scan.info.id;

const plain = (words: string): string => words.normalize("NFKD").replace(/[^\x20-\x7e]/g, "").replace(/[^A-Za-z0-9]+/g, "-").replace(/^-|-$/g, "");

/** K7M-4QX_standing_2026-11-25_landmarks.csv: code, stance and day of the scan, as the service names its files. */
export const fileName = ({ info }: Pick<ScanState, "info">, what: string, stance: string = info.stance.proposed): string =>
  [plain(info.patient_code) || "no-code", plain(stance), info.created_at.slice(0, "2026-11-25".length), what].join("_");

/** A table or loose pieces are in it, or something was cut away by hand. */
export const hasLoose = (scan: Pick<ScanState, "info" | "crops"> | null | undefined): boolean => scan != null && ((scan.info.body_triangles ?? scan.info.triangles) < scan.info.triangles || cropsOf(scan).length > 0);

/** The lasso is the scan step's. */
export const withoutLasso = <State extends Pick<ScanSlice, "isCropping" | "scan"> & { readonly step: string }>(state: State): State =>
  state.isCropping && (state.step !== "body" || state.scan === null) ? { ...state, isCropping: false } : state;
