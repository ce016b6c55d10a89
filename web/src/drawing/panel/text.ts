// The sentences of the plan's panel, which come with it.
import { formatMmWhole } from "../../ui/units";
import { amount } from "../text";

const mm = (value: number): string => `${formatMmWhole(value)}\u00a0mm`;
const SIDES = { L: "left", R: "right" } as const;
export type Side = keyof typeof SIDES;

export const planPanel = {
  title: "The plan",
  none: "Nothing is planned yet.",
  carrying: "What is planned is being carried here …",
  both: "both",
  image: "MRI",
  onScans: (sides: string, names: readonly string[]) => (sides === "" || names.length < 2 ? sides : `${sides}, on ${names.slice(0, -1).join(", ")} and ${names.at(-1)}`),
  sides: SIDES,
  letters: { L: "L", R: "R" } as const,
  breast: { L: "left breast", R: "right breast" } as const,
  length: (value: number) => `${(value / 10).toFixed(1)}\u00a0cm`,
  ring: "ring",
  deep: (value: number) => `${mm(value)} deep`,
  across: (value: number) => `${mm(value)} across`,
  from: (stance: string) => `from ${stance}`,
  given: "as given",
  mirrored: "mirrored",
  carried: "carried here",
  busy: "being carried here …",
  hidden: "hidden",
  tumour: "Tumour",
  pattern: "Pattern",
  note: "Note",
  asDrawn: "mm, as drawn",

  add: "+ Add",
  addHint: "Add to the plan",
  instead: (label: string) => `${label} instead`,
  pen: "Line",
  penHint: "Drawn on the skin with the pen (P)",
  circle: "Circle on the skin",
  circleHint: "A tumour that is felt: click where it lies (T)",
  clock: "Tumour by the clock",
  clockHint: "Side, hour and distance from the nipple",
  lesion: "Lesion in an image",
  lesionHint: "By its centre in this scan's frame",
  noteHint: "For the report: what is wanted, in words. No names.",
  importHint: "A drawing file (JSON), added to these",
  importFile: "Lines of a file",

  // the chosen item
  show: (name: string) => `Show ${name}`,
  showShort: "Show on the body",
  lines: (count: number) => `${count} ${count === 1 ? "line" : "lines"}`,
  remove: (name: string) => `Take ${name} out of the plan`,
  elsewhere: (from: string) => `Planned on the ${from} scan, and changed there.`,
  numberOf: (label: string, side: string) => (side === "" ? label : `${label}, ${side}`),
  more: (parts: readonly string[]) => parts.join(", "),
  parts: { side: "side", angles: "angles", position: "position", fold: "new fold" },
  setApart: "Set right and left apart",
  bothAs: (side: string) => `Both as ${side}`,
  auto: "auto",
  dashed: ([first = "", ...more]: readonly string[]) => ["Dashed:", `${first.charAt(0).toLowerCase()}${first.slice(1)}`, ...more].join(" "),
  reasons: {
    nipple_above_fold_mm: "The nipple is already above the fold, and this pattern never lowers it.",
    limb_mm: "Limbs are shortened to stay clear of the fold.",
    other: (label: string, asked: number, unit: string) => `${label}: ${amount(asked, unit)} asked, drawn otherwise on this skin.`,
  },
};
