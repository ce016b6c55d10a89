// The sentences of the plan's panel, which come with it.
import { inSentence, listed, word } from "../../languages/words";
import { formatFixed, formatMmWhole } from "../../ui/units";
import { amount } from "../text";

const mm = (value: number): string => word("drawing.panel.mm", { value: formatMmWhole(value) });
const SIDES = { L: word("drawing.panel.SIDES.L"), R: word("drawing.panel.SIDES.R") } as const;
export type Side = keyof typeof SIDES;

export const planPanel = {
  title: word("drawing.panel.planPanel.title"),
  none: word("drawing.panel.planPanel.none"),
  carrying: word("drawing.panel.planPanel.carrying"),
  both: word("drawing.panel.planPanel.both"),
  image: word("drawing.panel.planPanel.image"),
  onScans: (sides: string, names: readonly string[]) => (sides === "" || names.length < 2 ? sides : word("drawing.panel.planPanel.onScans", { sides, names: listed(names) })),
  sides: SIDES,
  letters: { L: word("drawing.panel.planPanel.letters.L"), R: word("drawing.panel.planPanel.letters.R") } as const,
  breast: { L: word("drawing.panel.planPanel.breast.L"), R: word("drawing.panel.planPanel.breast.R") } as const,
  length: (value: number) => `${formatFixed(value / 10, 1)}\u00a0cm`,
  ring: word("drawing.panel.planPanel.ring"),
  deep: (value: number) => word("drawing.panel.planPanel.deep", { value: mm(value) }),
  across: (value: number) => word("drawing.panel.planPanel.across", { value: mm(value) }),
  /** of "": of more than one other scan */
  from: (stance: string) => (stance === "" ? word("drawing.panel.planPanel.fromOthers") : word("drawing.panel.planPanel.from", { stance })),
  given: word("drawing.panel.planPanel.given"),
  mirrored: word("drawing.panel.planPanel.mirrored"),
  carried: word("drawing.panel.planPanel.carried"),
  busy: word("drawing.panel.planPanel.busy"),
  hidden: word("drawing.panel.planPanel.hidden"),
  tumour: word("drawing.panel.planPanel.tumour"),
  pattern: word("drawing.panel.planPanel.pattern"),
  note: word("drawing.panel.planPanel.note"),
  asDrawn: word("drawing.panel.planPanel.asDrawn"),

  add: word("drawing.panel.planPanel.add"),
  addHint: word("drawing.panel.planPanel.addHint"),
  instead: (label: string) => word("drawing.panel.planPanel.instead", { label }),
  pen: word("drawing.panel.planPanel.pen"),
  penHint: word("drawing.panel.planPanel.penHint"),
  circle: word("drawing.panel.planPanel.circle"),
  circleHint: word("drawing.panel.planPanel.circleHint"),
  clock: word("drawing.panel.planPanel.clock"),
  clockHint: word("drawing.panel.planPanel.clockHint"),
  lesion: word("drawing.panel.planPanel.lesion"),
  lesionHint: word("drawing.panel.planPanel.lesionHint"),
  noteHint: word("drawing.panel.planPanel.noteHint"),
  importHint: word("drawing.panel.planPanel.importHint"),
  importFile: word("drawing.panel.planPanel.importFile"),

  // the chosen item
  show: (name: string) => word("drawing.panel.planPanel.show", { name }),
  showShort: word("drawing.panel.planPanel.showShort"),
  lines: (count: number) => word("drawing.panel.planPanel.lines", { count }),
  remove: (name: string) => word("drawing.panel.planPanel.remove", { name }),
  elsewhere: (from: string) => (from === "" ? word("drawing.panel.planPanel.elsewhereOthers") : word("drawing.panel.planPanel.elsewhere", { from })),
  numberOf: (label: string, side: string) => (side === "" ? label : `${label}, ${side}`),
  more: (parts: readonly string[]) => parts.join(", "),
  parts: { side: word("drawing.panel.planPanel.parts.side"), angles: word("drawing.panel.planPanel.parts.angles"), position: word("drawing.panel.planPanel.parts.position"), fold: word("drawing.panel.planPanel.parts.fold") },
  setApart: word("drawing.panel.planPanel.setApart"),
  bothAs: (side: string) => word("drawing.panel.planPanel.bothAs", { side }),
  auto: word("drawing.panel.planPanel.auto"),
  dashed: ([first = "", ...more]: readonly string[]) => word("drawing.panel.planPanel.dashed", { why: [inSentence(first), ...more].join(" ") }),
  reasons: {
    nipple_above_fold_mm: word("drawing.panel.planPanel.reasons.nipple_above_fold_mm"),
    limb_mm: word("drawing.panel.planPanel.reasons.limb_mm"),
    other: (label: string, asked: number, unit: string) => word("drawing.panel.planPanel.reasons.other", { label, asked: amount(asked, unit) }),
  },
};
