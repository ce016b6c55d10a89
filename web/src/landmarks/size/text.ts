// The true size of a scan.
import { word } from "../../languages/words";
import { formatFixed } from "../../ui/units";

const cm = (mm: number): string => `${formatFixed(mm / 10, 1)}\u00a0cm`;

export const size = {
  label: word("landmarks.size.label"),
  ask: word("landmarks.size.ask"),
  askUnknown: word("landmarks.size.askUnknown"),
  measure: word("landmarks.size.measure"),
  stop: word("landmarks.size.stop"),
  ends: { from: word("landmarks.size.ends.from"), to: word("landmarks.size.ends.to") },
  clicked: word("landmarks.size.clicked"),
  clickFrom: word("landmarks.size.clickFrom"),
  clickTo: word("landmarks.size.clickTo"),
  inScan: (mm: number) => word("landmarks.size.inScan", { mm: cm(mm) }),
  field: word("landmarks.size.field"),
  hint: word("landmarks.size.hint"),
  apply: word("landmarks.size.apply"),
  applyHint: word("landmarks.size.applyHint"),
  remove: word("landmarks.size.remove"),
  removeHint: word("landmarks.size.removeHint"),
  scaled: (factor: number, from: string, to: string, mm: number) => word("landmarks.size.scaled", { factor: formatFixed(factor, 3), from, to, cm: cm(mm) }),
  places: [word("landmarks.size.places.1"), word("landmarks.size.places.2")] as readonly string[], // as the service calls ends without a name
  protocol: word("landmarks.size.protocol"),
  applied: word("landmarks.size.applied"),
  elsewhere: word("landmarks.size.elsewhere"),
  removed: word("landmarks.size.removed"),
  change: word("landmarks.size.change"),
  undone: (to: { readonly factor: number } | null) => (to ? word("landmarks.size.undoneScaled", { factor: formatFixed(to.factor, 3) }) : word("landmarks.size.undone")),
  redone: (to: { readonly factor: number } | null) => (to ? word("landmarks.size.redoneScaled", { factor: formatFixed(to.factor, 3) }) : word("landmarks.size.redone")),
};
