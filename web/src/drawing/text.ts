// Drawing on the scan: tools, lines, layers, the model's own drawings.
import { sideOf } from "../landmarks/picks";
import { writtenNumber } from "../ui/NumberField";
import { plural } from "../ui/plural";
import { formatMmWhole } from "../ui/units";
import type { LiveHandle } from "./state";
import { type Tape, tapeHasHole, tapeLength } from "./tape/tape";

type Unit = LiveHandle["numbers"][number]["unit"];

export const amount = (value: number, unit: string): string => `${writtenNumber(unit === "mm" ? Math.round(10 * value) / 10 : value, unit)}${unit === "deg" ? "°" : unit === "h" ? " o'clock" : "\u00a0mm"}`;

const several = (names: readonly string[]): string => (names.length > 3 ? plural(names.length, "line", "lines") : names.join(", "));

export const sureness = {
  hint: "The grey band holds the true line nine times in ten.",
  least: (label: string, wide: string) => `Least sure: ${label}, ${wide}.`,
  wider: (label: string) => `wider: ${label}`,
};

export const bands = {
  error: (mm: string) => `±\u00a0${mm} mm`,
  of: "the line's true place, 90 %",
};

const mm = (length: number | null, hasHole: boolean): string => length === null ? "…" : `${hasHole ? "≈\u00a0" : ""}${formatMmWhole(length)}\u00a0mm`;

export const tape = {
  /** a hole is crossed straight: the skin there is longer */
  length: (length: number | null, hasHole: boolean) => `${mm(length, hasHole)}${hasHole ? ", over a hole" : ""}`,
  total: (tape: Tape) => `${mm(tapeLength(tape), tapeHasHole(tape))} in all`,
  says(tape: Tape): string {
    if (tape.isRefused) return "No scanned skin leads there: measure around the gap.";
    return tape.legs.length === 0 ? "The tape begins here." : this.total(tape);
  },
  end: "End the tape",
};

export const mirrored = {
  title: "Left breast, mirrored onto the right",
  deeper: (mm: number) => `${mm} mm deeper`,
  farther: (mm: number) => `${mm} mm farther out`,
  numbers: (median: string, most: string) => `Differs by ${median} mm (median), 95 % by less than ${most} mm. Nearly everybody is asymmetric.`,
};

export const canvas = {
  open: "Draw on the full screen",
  openHint: "The body alone with floating tools: for a tablet and a stylus",
  done: "Done",
  doneHint: "Back to the page (Esc)",
  opened: "Full canvas. Escape leads back.",
  closed: "Back on the page.",
  tools: "Drawing tools",
  views: "View",
  inks: "Colour of the next line",
  recolour: (name: string, ink: string) => `Draw ${name} in ${ink}`,
  recolourShort: "Use colour",
  noLine: "No line is chosen",
  pen: "The pen draws; fingers turn, move and zoom.",
  fingers: "Fingers",
  fingersHint: "Fingers draw too, though a pen was seen",
  fingersDraw: "The pen and one finger draw; two fingers turn the body.",
};

/** What a step of the history has changed. */
export const changes = {
  drawn: (names: readonly string[]) => `${several(names)} drawn`,
  erased: (names: readonly string[]) => `${several(names)} erased`,
  renamed: (before: string, after: string) => `${before} called ${after}`,
  recoloured: (name: string) => `${name} in another colour`,
  moved: (name: string) => `${name} changed`,
  deep: (name: string, depth: string) => `depth of ${name}: ${depth}`,
  pattern: (before: string, after: string) => (before === "" ? `${after} chosen` : after === "" ? `${before} put aside` : `${after} instead of ${before}`),
  number: (label: string, before: string, after: string) => `${label.toLowerCase()} ${after} instead of ${before}`,
  on: (label: string, side: "R" | "L") => `${label}, ${{ R: "right", L: "left" }[side]}`,
  apart: "right and left set apart",
  together: "one number for right and left",
  depth: "depth below the skin",
  depthOf: (mm: number | null) => (mm === null ? "not known" : amount(mm, "mm")),
  lesions: "lesions changed",
  note: "notes changed",
  ink: "choice among the lines of ink",
  nothing: "the last step",
};

export const lesions = {
  heading: "Lesions",
  name: "Name",
  numbered: (number: number) => `Lesion ${number}`,
  center: "Centre",
  centerHint: "x, y, z in mm, in this scan's frame",
  radius: "Radius",
  add: "Add",
  mark: "Mark it in the slices",
  noPlace: "The centre needs three numbers in millimetres, as 12.5 -80 43.",
  says: (radius: number, depth: number | null) => [`radius ${Number(radius.toFixed(1))}\u00a0mm`, depth === null ? "" : `${Math.round(depth)}\u00a0mm deep`].filter((part) => part !== "").join(", "),
};

export const drawing = {
  stem: "Line",
  tools: "Tool",
  toolNames: { none: "Turn", pen: "Pen", points: "Points", tumour: "Tumour", tape: "Tape", erase: "Erase" },
  toolHints: {
    none: "Put the tool down: dragging turns the body (Esc)",
    pen: "Draw on the skin (P). By keys: arrows on the body move a cross, Enter sets a corner, twice ends the line.",
    points: "Move the points of a line (E); a chosen one also by arrow keys on the body",
    tumour: "Mark a tumour by a circle on the skin (T)",
    tape: "Measure along the skin (M); nothing is saved",
    erase: "Erase a line by touching it",
  },
  hints: {
    none: "Dragging turns the body.",
    pen: "Drag to draw, or click corner after corner; a click on the start closes the line, Enter ends it. The second button or two fingers turn the body.",
    points: "Click a line, then drag its points; click on the line for a new one, Delete takes one away. The second button or two fingers turn the body.",
    tape: "Click from place to place: each length is along the skin. Escape ends the tape; nothing is saved. The second button or two fingers turn the body.",
    erase: "Touch a line to erase it. The second button or two fingers turn the body.",
    tumour: "Click where the tumour is; the radius is along the skin. The second button or two fingers turn the body.",
  },
  radius: "Radius",
  tumourName: (mm: string) => `Tumour ${mm} mm`,
  undo: "Undo (Z)",
  redo: "Redo (Shift+Z)",
  finish: "End the line",
  again: "Save again",
  name: (name: string) => `Name of ${name}`,
  nameTaken: "Another line has this name.",
  depth: "Depth",
  depthHint: "How deep it is to be cut, below the nearest skin: the report says what that takes. Left empty where it is not decided.",
  announceDepth: (name: string, mm: number | null) => (mm === null ? `${name} has no depth.` : `${name}: ${mm} mm deep.`),
  length: (cm: string) => `${cm} cm`,
  close: (name: string) => `Close ${name} to a ring`,
  open: (name: string) => `Open the ring ${name}`,
  closeShort: "Close",
  openShort: "Open",
  erase: (name: string) => `Erase ${name}`,
  mirror: (name: string) => `Mirror ${name} to the other side`,
  mirrored: (name: string) => `${name.slice(0, 85)}, mirrored`,
  noOtherSide: (name: string) => `The other side of “${name}” is not on this scan, so it was not mirrored.`,
  corner: (number: number, count: number) => `Point ${number} of ${count}`,
  noCorner: (count: number) => plural(count, "point", "points"),
  previous: "Previous point",
  next: "Next point",
  remove: "Delete point",
  nudge: "Move the point along the skin",
  arrows: { ArrowLeft: "To the left", ArrowUp: "Up", ArrowDown: "Down", ArrowRight: "To the right" },
  arrowSigns: { ArrowLeft: "←", ArrowUp: "↑", ArrowDown: "↓", ArrowRight: "→" },
  dashed: "Dashed and paler where the scan shows no skin: a guess of the model.",
  elsewhere: (name: string, mm: number) => `“${name}” lies ${Math.round(mm)} mm off this scan: it was drawn on another one, or in another unit.`,
  imported: (count: number, mm: number, out: readonly string[]) =>
    [`${plural(count, "line", "lines")} read`, ...(mm > 0 ? [`moved onto the skin by up to ${Math.round(mm)} mm`] : []), ...(out.length > 0 ? [`left out, more than 10 mm off this scan: ${out.join(", ")}`] : [])].join("; ") + ".",
  pattern: {
    stillNeeded: (labels: readonly string[]) => `Nothing is entered yet: say ${labels.join(", ")}.`,
    depth: "Depth below the skin",
    depthHint: "of the tumour; leave it empty where it is not known",
    note: "Notes",
    needsFit: "Drawn on the body as soon as the model is fitted.",
    mirror: "Mirror to the other side",
    byItself: "auto",
    choices: { "": "choose", L: "Patient's left", R: "Patient's right", both: "Both" } as Record<string, string>,
    range: (min: number, max: number, unit: string) => `${min} to ${max} ${unit}`.trim(),
  },
  handles: {
    says: ({ label, side, numbers }: LiveHandle) =>
      numbers.length === 1 ? `${label}: ${amount(numbers[0]!.value, numbers[0]!.unit)}` : `${numbers.map((each) => `${each.label} ${amount(each.value, each.unit)}`).join(", ")}, ${side === "L" ? "left" : "right"}`,
    ends: (label: string, value: number, unit: Unit) => `${label} stops at ${amount(value, unit)}.`,
    keys: "Drag it on the skin, or move it by the arrow keys: 1 mm, with Shift 5 mm.",
  },
  /** "breast_L" → "Breast, patient's left": for shapes whose label is not at hand */
  shapeName(name: string): string {
    const plain = name.replace(/_[LR]$/, "").replaceAll("_", " ");
    const side = { left: ", patient's left", right: ", patient's right", middle: "" }[sideOf(name)];
    return plain.charAt(0).toUpperCase() + plain.slice(1) + side;
  },
  announceCorner: (number: number) => `Corner ${number}.`,
  announceDrawn: (name: string) => `${name} is drawn.`,
  announceClosed: (name: string) => `${name} is closed.`,
  announceRenamed: (name: string) => `Now called ${name}.`,
  announceRecoloured: (name: string) => `${name} has another colour.`,
  announceErased: (name: string) => `${name} is erased.`,
  merged: "The plan was changed in another tab or by somebody else: both are kept, look at the lines.",
  nothingEarlier: "There is nothing earlier to go back to.",
  announceMoved: "The point is moved.",
  announceCornerGone: "The point is deleted.",
};
