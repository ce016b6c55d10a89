// Marks found by colour.
import { word } from "../../languages/words";
import { formatMmWhole } from "../../ui/units";

const kinds: Readonly<Record<string, string>> = { dot: word("stances.found.kinds.dot"), cross: word("stances.found.kinds.cross"), mole: word("stances.found.kinds.mole") };

export const found = {
  title: word("stances.found.title"),
  hint: word("stances.found.hint"),
  noColours: word("stances.found.noColours"),
  find: word("stances.found.find"),
  looking: word("stances.found.looking"),
  row: (name: string, kind: string, offMm: number) => word("stances.found.row", { name, kind: kinds[kind] ?? kind, mm: formatMmWhole(offMm) }),
  accept: (name: string) => word("stances.found.accept", { name }),
  dismiss: (name: string) => word("stances.found.dismiss", { name }),
  acceptAll: (count: number) => word("stances.found.acceptAll", { count }),
  dismissAll: word("stances.found.dismissAll"),
  announceAccepted: (names: readonly string[]) => word("stances.found.announceAccepted", { names: names.join(", ") }),
};
