// The table of measures, loaded when it is opened.
import { word } from "../../languages/words";

const kinds: Readonly<Record<string, string>> = { straight: word("stances.measures.table.kinds.straight"), "along the skin": word("stances.measures.table.kinds.alongSkin"), "in height": word("stances.measures.table.kinds.inHeight"), volume: word("stances.measures.table.kinds.volume"), ratio: word("stances.measures.table.kinds.ratio") };

export const table = {
  /** by what the file has, which stays English */
  kindSaid: (kind: string) => kinds[kind] ?? kind,
  title: word("stances.measures.table.title"),
  one: word("stances.measures.table.one"),
  measure: word("stances.measures.table.measure"),
  left: word("stances.measures.table.left"),
  right: word("stances.measures.table.right"),
  difference: word("stances.measures.table.difference"),
  change: (second: string, first: string) => word("stances.measures.table.change", { second, first }),
  hint: word("stances.measures.table.hint"),
  method: word("stances.measures.table.method"),
  landmarks: word("stances.measures.table.landmarks"),
  kind: word("stances.measures.table.kind"),
  copy: word("stances.measures.table.copy"),
  copied: word("stances.measures.table.copied"),
  copyFailed: word("stances.measures.table.copyFailed"),
  csv: "measures.csv",
  report: "report.pdf",
  busy: word("stances.measures.table.busy"),
  vague: word("stances.measures.table.vague"),
  vagueHint: (value: string) => word("stances.measures.table.vagueHint", { value }),
  notSeen: word("stances.measures.table.notSeen"),
  notKnown: word("stances.measures.table.notKnown"),
  notKnownHint: word("stances.measures.table.notKnownHint"),
  notSeenHint: word("stances.measures.table.notSeenHint"),
};
