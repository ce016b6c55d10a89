// Landmarks and their proposals.
import { plural } from "../ui/plural";
import { marks } from "./marks/text";
import { isMark, markCalled, type Picks, picksChanged, plainLabel, sideOf } from "./picks";

const several = (labels: readonly string[]): string => (labels.length > 3 ? plural(labels.length, "point", "points") : labels.join("; ")); // landmarks and marks of the skin

export const landmarks = {
  /** "nipple, patient's left": as it stands inside a sentence */
  spoken({ name, label }: { name: string; label: string }): string {
    const plain = plainLabel(label);
    const side = { left: ", patient's left", right: ", patient's right", middle: "" }[sideOf(name)];
    return plain.charAt(0).toLowerCase() + plain.slice(1) + side;
  },
  sides: { left: "patient's LEFT", right: "patient's RIGHT", middle: "midline" },
  sideWords: { left: "LEFT", right: "RIGHT", middle: "" },
  sideShort: { left: "L", right: "R", middle: "" },
  placed: "placed",
  skippedState: "skipped",
  missing: "not placed",
  exchange: (label: string) => `Exchange left and right: ${label.charAt(0).toLowerCase()}${label.slice(1)}`,
  exchangeAll: "Exchange left and right of all pairs",
  skip: "Skip",
  remove: (label: string) => `Remove ${label}`,
  stop: "Stop",
  importFile: "Import",
  importHint: "Read landmarks from JSON, a table (CSV), MeshLab .pp, 3D Slicer .mrk.json or .fcsv, or Landmark Editor .pts",
  exportHint: "Save the placed landmarks",
  exported: {
    json: "for this page and the command line, in mm",
    csv: "for spreadsheets, in the scan's unit",
    pp: "for MeshLab",
    "mrk.json": "for 3D Slicer",
  },
  useExample: "Use the example's landmarks",
  again: "Try again",
  how: "A click on the body places the point, dragging turns the view.",
  guideTitle: "Place this point",
  guideCaption: "Shown on the model",
  announcePlaced: (label: string, next: string | null) =>
    next === null ? `Placed: ${label}. All landmarks are done.` : `Placed: ${label}. Next: ${next}.`,
  announceMoved: (label: string) => `Moved: ${label}.`,
  noSkin: "There is no skin under the cross: move it with the arrow keys.",
  undone: (changes: string) => `Undone: ${changes}.`,
  redone: (changes: string) => `Redone: ${changes}.`,
  changes: {
    placed: (labels: readonly string[]) => `placed ${several(labels)}`,
    moved: (labels: readonly string[]) => `moved ${several(labels)}`,
    removed: (labels: readonly string[]) => `removed ${several(labels)}`,
  },
  changedElsewhere: (taken: readonly string[], overruled: readonly string[]) =>
    [
      ...(taken.length === 0 ? [] : [`Changed in another tab or by somebody else, and shown here now: ${taken.join("; ")}.`]),
      ...(overruled.length === 0 ? [] : [`Changed in another tab or by somebody else as well: ${overruled.join("; ")}. What was done here last counts.`]),
    ].join(" "),
  announceImported: (landmarks: number, marks: number) => `${plural(landmarks, "landmark", "landmarks")}${marks > 0 ? ` and ${plural(marks, "mark", "marks")}` : ""} read.`,
  inTrueSize: (factor: number) =>
    `The file's places were taken in the true size of this scan, ${factor.toFixed(3)} times that of its own file. If they were picked on that file, take the length out, read them again, then give the length.`,
};

/** What a step of the history has changed. */
export function picksSaid(before: Picks, after: Picks, list: readonly { readonly name: string; readonly label: string }[]): string {
  const { placed, moved, removed } = picksChanged(before, after);
  const spoken = (name: string): string => {
    if (isMark(name)) return marks.spoken(markCalled(name));
    const entry = list.find((each) => each.name === name);
    return entry ? landmarks.spoken(entry) : name;
  };
  const said = ([[placed, landmarks.changes.placed], [moved, landmarks.changes.moved], [removed, landmarks.changes.removed]] as const).filter(([names]) => names.length > 0);
  return said.map(([names, says]) => says(names.map(spoken))).join(", ");
}

export const questions = {
  keep: "Keep it",
  keepAll: "Keep them",
  takeOut: "Take it out",
  exchange: "Exchange left and right",
  exchangeTwo: "Exchange the two",
  allSides: "all sides",
  state: "placed, to be checked",
  wrongSide: (isSeveral: boolean) => (isSeveral ? "Are left and right swapped? Left points lie on the right side of the body, and right ones on the left." : "Are left and right swapped? Each of the two lies on the other's side of the body."),
  kept: "kept",
  keptState: "placed, kept as picked",
  keptHint: (label: string) => `Kept as picked, whatever the fit says: ${label}. Press to have it judged again.`,
  announceAsked: (sentences: readonly string[]) => `Please check: ${sentences.join(" ")}`,
  announceKept: (labels: string) => `Kept: ${labels}.`,
  announceUnkept: (label: string) => `Judged again: ${label}.`,
  announceTakenOut: (label: string) => `Taken out: ${label}.`,
  announceExchanged: (labels: string) => `Exchanged: ${labels}.`,
};

export const proposals = {
  looking: "Looking for the landmarks on this scan …",
  found: (count: number, rough: number) => {
    const doubtful = rough === 0 ? "" : rough === 1 ? " One is a rough guess: check it by itself." : ` ${rough} are rough guesses: check each.`;
    return `${plural(count, "proposal", "proposals")}, dashed; ± mm holds 90 of 100 true places. One that you agree to keeps its error until you move it, or confirm it close up.${doubtful}`;
  },
  notProposed: (labels: readonly string[], reason: string) => `Not proposed: ${labels.join("; ")}. ${reason}`,
  none: (reason: string) => `No proposals: ${reason}`,
  late: "The service is still busy with it.",
  again: "Ask again",
  confirm: (label: string) => `Confirm the proposed ${label}`,
  confirmSeen: (count: number) => (count === 1 ? "Confirm the point seen" : `Confirm the ${count} points seen`),
  fit: "Fit as proposed",
  check: "Check them one by one",
  error: (mm: string) => `±\u00a0${mm}\u00a0mm`,
  errorHint: (mm: string, reason: string | null | undefined) =>
    `${reason ? `Found on the skin: ${reason}. ` : ""}The true place lies within ${mm} mm of the proposal in 90 of 100 cases.`,
  offScanHint: "The scan shows no skin here: the model alone says where it would be.",
  unknown: "?",
  take: "Take the proposal",
  looked: "It is right, seen close up",
  nearer: "Zoom in until single millimetres show, then confirm it; or click where it belongs.",
  felt: "This point is felt, not seen: feel for it on the patient, and click there.",
  agreed: "agreed",
  agreedHint: (label: string, mm: string | null) => `Only agreed to, so it keeps the proposal's error${mm ? ` of ± ${mm} mm` : ""}: ${label}. Press to look closely.`,
  agreedState: "proposed, only agreed to",
  errorShort: (mm: string) => `±\u00a0${mm}`,
  rowState: (mm: string, reason: string | null | undefined) => `proposed${reason ? ` (${reason})` : ""}, within ${mm} millimetres`,
  announceFound: (count: number) => `${plural(count, "landmark is", "landmarks are")} proposed.`,
  announceConfirmed: (labels: readonly string[]) =>
    labels.length === 1 ? `Confirmed: ${labels[0]}.` : `${labels.length} proposed landmarks confirmed.`,
};
