// Landmarks and their proposals.
import { inSentence, listed, word } from "../languages/words";
import { formatFixed } from "../ui/units";
import { marks } from "./marks/text";
import { isMark, markCalled, type Picks, picksChanged, plainLabel, sideOf } from "./picks";

const several = (labels: readonly string[]): string => (labels.length > 3 ? word("landmarks.points", { count: labels.length }) : labels.join("; ")); // landmarks and marks of the skin

export const landmarks = {
  /** "nipple, patient's left": as it stands inside a sentence */
  spoken({ name, label }: { name: string; label: string }): string {
    const plain = inSentence(plainLabel(label));
    const side = sideOf(name);
    return side === "middle" ? plain : word(side === "left" ? "landmarks.spokenLeft" : "landmarks.spokenRight", { label: plain });
  },
  sides: { left: word("landmarks.sides.left"), right: word("landmarks.sides.right"), middle: word("landmarks.sides.middle") },
  sideWords: { left: word("landmarks.sideWords.left"), right: word("landmarks.sideWords.right"), middle: "" },
  sideShort: { left: word("landmarks.sideShort.left"), right: word("landmarks.sideShort.right"), middle: "" },
  placed: word("landmarks.placed"),
  skippedState: word("landmarks.skippedState"),
  missing: word("landmarks.missing"),
  exchange: (label: string) => word("landmarks.exchange", { label: inSentence(label) }),
  exchangeAll: word("landmarks.exchangeAll"),
  skip: word("landmarks.skip"),
  remove: (label: string) => word("landmarks.remove", { label }),
  stop: word("landmarks.stop"),
  importFile: word("landmarks.importFile"),
  importHint: word("landmarks.importHint"),
  exportHint: word("landmarks.exportHint"),
  exported: {
    json: word("landmarks.exported.json"),
    csv: word("landmarks.exported.csv"),
    pp: word("landmarks.exported.pp"),
    "mrk.json": word("landmarks.exported.mrk.json"),
  },
  useExample: word("landmarks.useExample"),
  again: word("landmarks.again"),
  how: word("landmarks.how"),
  guideTitle: word("landmarks.guideTitle"),
  guideCaption: word("landmarks.guideCaption"),
  announcePlaced: (label: string, next: string | null) =>
    next === null ? word("landmarks.announcePlacedLast", { label }) : word("landmarks.announcePlaced", { label, next }),
  announceMoved: (label: string) => word("landmarks.announceMoved", { label }),
  noSkin: word("landmarks.noSkin"),
  undone: (changes: string) => word("landmarks.undone", { changes }),
  redone: (changes: string) => word("landmarks.redone", { changes }),
  changes: {
    placed: (labels: readonly string[]) => word("landmarks.changes.placed", { labels: several(labels) }),
    moved: (labels: readonly string[]) => word("landmarks.changes.moved", { labels: several(labels) }),
    removed: (labels: readonly string[]) => word("landmarks.changes.removed", { labels: several(labels) }),
  },
  changedElsewhere: (taken: readonly string[], overruled: readonly string[]) =>
    [
      ...(taken.length === 0 ? [] : [word("landmarks.changedElsewhere", { changes: taken.join("; ") })]),
      ...(overruled.length === 0 ? [] : [word("landmarks.changedBoth", { changes: overruled.join("; ") })]),
    ].join(" "),
  announceImported: (landmarks: number, marks: number) => word("landmarks.announceImported", { what: listed([word("landmarks.landmarks", { count: landmarks }), ...(marks > 0 ? [word("landmarks.ofMarks", { count: marks })] : [])]) }),
  inTrueSize: (factor: number) =>
    word("landmarks.inTrueSize", { factor: formatFixed(factor, 3) }),
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
  keep: word("landmarks.questions.keep"),
  keepAll: word("landmarks.questions.keepAll"),
  takeOut: word("landmarks.questions.takeOut"),
  exchange: word("landmarks.questions.exchange"),
  exchangeTwo: word("landmarks.questions.exchangeTwo"),
  allSides: word("landmarks.questions.allSides"),
  state: word("landmarks.questions.state"),
  wrongSide: (isSeveral: boolean) => (word(isSeveral ? "landmarks.questions.wrongSides" : "landmarks.questions.wrongSide")),
  kept: word("landmarks.questions.kept"),
  keptState: word("landmarks.questions.keptState"),
  keptHint: (label: string) => word("landmarks.questions.keptHint", { label }),
  announceAsked: (sentences: readonly string[]) => word("landmarks.questions.announceAsked", { sentences: sentences.join(" ") }),
  announceKept: (labels: string) => word("landmarks.questions.announceKept", { labels }),
  announceUnkept: (label: string) => word("landmarks.questions.announceUnkept", { label }),
  announceTakenOut: (label: string) => word("landmarks.questions.announceTakenOut", { label }),
  announceExchanged: (labels: string) => word("landmarks.questions.announceExchanged", { labels }),
};

export const proposals = {
  looking: word("landmarks.proposals.looking"),
  found: (count: number, rough: number) => [word("landmarks.proposals.found", { count }), ...(rough > 0 ? [word("landmarks.proposals.rough", { count: rough })] : [])].join(" "),
  notProposed: (labels: readonly string[], reason: string) => word("landmarks.proposals.notProposed", { labels: labels.join("; "), reason }),
  none: (reason: string) => word("landmarks.proposals.none", { reason }),
  late: word("landmarks.proposals.late"),
  again: word("landmarks.proposals.again"),
  confirm: (label: string) => word("landmarks.proposals.confirm", { label }),
  confirmSeen: (count: number) => word("landmarks.proposals.confirmSeen", { count }),
  fit: word("landmarks.proposals.fit"),
  check: word("landmarks.proposals.check"),
  error: (mm: string) => word("landmarks.proposals.error", { mm }),
  errorHint: (mm: string, reason: string | null | undefined) =>
    reason ? word("landmarks.proposals.errorHintFound", { reason, mm }) : word("landmarks.proposals.errorHint", { mm }),
  offScanHint: word("landmarks.proposals.offScanHint"),
  unknown: "?",
  take: word("landmarks.proposals.take"),
  looked: word("landmarks.proposals.looked"),
  nearer: word("landmarks.proposals.nearer"),
  felt: word("landmarks.proposals.felt"),
  agreed: word("landmarks.proposals.agreed"),
  agreedHint: (label: string, mm: string | null) => (mm ? word("landmarks.proposals.agreedHintOf", { label, mm }) : word("landmarks.proposals.agreedHint", { label })),
  agreedState: word("landmarks.proposals.agreedState"),
  errorShort: (mm: string) => `±\u00a0${mm}`,
  rowState: (mm: string, reason: string | null | undefined) => (reason ? word("landmarks.proposals.rowStateFound", { reason, mm }) : word("landmarks.proposals.rowState", { mm })),
  announceFound: (count: number) => word("landmarks.proposals.announceFound", { count }),
  announceConfirmed: (labels: readonly string[]) =>
    word("landmarks.proposals.announceConfirmed", { count: labels.length, label: labels[0] ?? "" }),
};
