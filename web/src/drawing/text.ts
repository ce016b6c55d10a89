// Drawing on the scan: tools, lines, layers, the model's own drawings.
import { capital, inSentence, word } from "../languages/words";
import { sideOf } from "../landmarks/picks";
import { writtenNumber } from "../ui/NumberField";
import { formatMmWhole, formatUpTo } from "../ui/units";
import type { LiveHandle } from "./state";
import { type Tape, tapeHasHole, tapeLength } from "./tape/tape";

type Unit = LiveHandle["numbers"][number]["unit"];

export const amount = (value: number, unit: string): string => {
  const number = writtenNumber(unit === "mm" ? Math.round(10 * value) / 10 : value, unit);
  return unit === "h" ? word("drawing.hour", { hour: number }) : `${number}${unit === "deg" ? "°" : "\u00a0mm"}`;
};

const several = (names: readonly string[]): string => (names.length > 3 ? word("drawing.lines", { count: names.length }) : names.join(", "));

export const sureness = {
  hint: word("drawing.sureness.hint"),
  least: (label: string, wide: string) => word("drawing.sureness.least", { label, wide }),
  wider: (label: string) => word("drawing.sureness.wider", { label }),
};

export const bands = {
  error: (mm: string) => word("drawing.bands.error", { mm }),
  of: word("drawing.bands.of"),
};

const mm = (length: number | null, hasHole: boolean): string => length === null ? "…" : `${hasHole ? "≈\u00a0" : ""}${formatMmWhole(length)}\u00a0mm`;

export const tape = {
  /** a hole is crossed straight: the skin there is longer */
  length: (length: number | null, hasHole: boolean) => (hasHole ? word("drawing.tape.overHole", { length: mm(length, hasHole) }) : mm(length, hasHole)),
  total: (tape: Tape) => word("drawing.tape.total", { length: mm(tapeLength(tape), tapeHasHole(tape)) }),
  says(tape: Tape): string {
    if (tape.isRefused) return word("drawing.tape.refused");
    return tape.legs.length === 0 ? word("drawing.tape.begins") : this.total(tape);
  },
  end: word("drawing.tape.end"),
};

export const mirrored = {
  title: word("drawing.mirrored.title"),
  deeper: (mm: number) => word("drawing.mirrored.deeper", { mm }),
  farther: (mm: number) => word("drawing.mirrored.farther", { mm }),
  numbers: (median: string, most: string) => word("drawing.mirrored.numbers", { median, most }),
};

export const canvas = {
  undo: word("drawing.canvas.undo"),
  redo: word("drawing.canvas.redo"),
  colours: { black: word("drawing.canvas.colours.black"), red: word("drawing.canvas.colours.red"), blue: word("drawing.canvas.colours.blue"), green: word("drawing.canvas.colours.green"), orange: word("drawing.canvas.colours.orange"), white: word("drawing.canvas.colours.white") },
  open: word("drawing.canvas.open"),
  openHint: word("drawing.canvas.openHint"),
  done: word("drawing.canvas.done"),
  doneHint: word("drawing.canvas.doneHint"),
  opened: word("drawing.canvas.opened"),
  closed: word("drawing.canvas.closed"),
  tools: word("drawing.canvas.tools"),
  views: word("drawing.canvas.views"),
  inks: word("drawing.canvas.inks"),
  recolour: (name: string, ink: string) => word("drawing.canvas.recolour", { name, ink }),
  recolourShort: word("drawing.canvas.recolourShort"),
  noLine: word("drawing.canvas.noLine"),
  pen: word("drawing.canvas.pen"),
  fingers: word("drawing.canvas.fingers"),
  fingersHint: word("drawing.canvas.fingersHint"),
  fingersDraw: word("drawing.canvas.fingersDraw"),
};

/** What a step of the history has changed. */
export const changes = {
  drawn: (names: readonly string[]) => word("drawing.changes.drawn", { names: several(names) }),
  erased: (names: readonly string[]) => word("drawing.changes.erased", { names: several(names) }),
  renamed: (before: string, after: string) => word("drawing.changes.renamed", { before, after }),
  recoloured: (name: string) => word("drawing.changes.recoloured", { name }),
  moved: (name: string) => word("drawing.changes.moved", { name }),
  deep: (name: string, depth: string) => word("drawing.changes.deep", { name, depth }),
  pattern: (before: string, after: string) => (before === "" ? word("drawing.changes.chosen", { after }) : after === "" ? word("drawing.changes.putAside", { before }) : word("drawing.changes.instead", { after, before })),
  number: (label: string, before: string, after: string) => word("drawing.changes.number", { label: inSentence(label), after, before }),
  on: (label: string, side: "R" | "L") => word(side === "L" ? "drawing.changes.onLeft" : "drawing.changes.onRight", { label }),
  apart: word("drawing.changes.apart"),
  together: word("drawing.changes.together"),
  depth: word("drawing.changes.depth"),
  depthOf: (mm: number | null) => (mm === null ? word("drawing.changes.depthUnknown") : amount(mm, "mm")),
  lesions: word("drawing.changes.lesions"),
  note: word("drawing.changes.note"),
  ink: word("drawing.changes.ink"),
  nothing: word("drawing.changes.nothing"),
};

export const lesions = {
  heading: word("drawing.lesions.heading"),
  name: word("drawing.lesions.name"),
  numbered: (number: number) => word("drawing.lesions.numbered", { number }),
  center: word("drawing.lesions.center"),
  centerHint: word("drawing.lesions.centerHint"),
  radius: word("drawing.lesions.radius"),
  add: word("drawing.lesions.add"),
  mark: word("drawing.lesions.mark"),
  noPlace: word("drawing.lesions.noPlace"),
  says: (radius: number, depth: number | null) => (depth === null ? word("drawing.lesions.says", { radius: formatUpTo(radius, 1) }) : word("drawing.lesions.saysDeep", { radius: formatUpTo(radius, 1), deep: formatMmWhole(depth) })),
};

export const drawing = {
  stem: word("drawing.stem"),
  tools: word("drawing.tools"),
  toolNames: { none: word("drawing.toolNames.none"), pen: word("drawing.toolNames.pen"), points: word("drawing.toolNames.points"), tumour: word("drawing.toolNames.tumour"), tape: word("drawing.toolNames.tape"), erase: word("drawing.toolNames.erase") },
  toolHints: {
    none: word("drawing.toolHints.none"),
    pen: word("drawing.toolHints.pen"),
    points: word("drawing.toolHints.points"),
    tumour: word("drawing.toolHints.tumour"),
    tape: word("drawing.toolHints.tape"),
    erase: word("drawing.toolHints.erase"),
  },
  hints: {
    none: word("drawing.hints.none"),
    pen: word("drawing.hints.pen"),
    points: word("drawing.hints.points"),
    tape: word("drawing.hints.tape"),
    erase: word("drawing.hints.erase"),
    tumour: word("drawing.hints.tumour"),
  },
  radius: word("drawing.radius"),
  tumourName: (mm: string) => word("drawing.tumourName", { mm }),
  undo: word("drawing.undo"),
  redo: word("drawing.redo"),
  finish: word("drawing.finish"),
  again: word("drawing.again"),
  name: (name: string) => word("drawing.name", { name }),
  nameTaken: word("drawing.nameTaken"),
  depth: word("drawing.depth"),
  depthHint: word("drawing.depthHint"),
  announceDepth: (name: string, mm: number | null) => (mm === null ? word("drawing.announceNoDepth", { name }) : word("drawing.announceDepth", { name, mm })),
  length: (cm: string) => word("drawing.length", { cm }),
  close: (name: string) => word("drawing.close", { name }),
  open: (name: string) => word("drawing.open", { name }),
  closeShort: word("drawing.closeShort"),
  openShort: word("drawing.openShort"),
  erase: (name: string) => word("drawing.erase", { name }),
  mirror: (name: string) => word("drawing.mirror", { name }),
  mirrored: (name: string) => word("drawing.mirroredName", { name: name.slice(0, 85) }),
  noOtherSide: (name: string) => word("drawing.noOtherSide", { name }),
  corner: (number: number, count: number) => word("drawing.corner", { number, count }),
  noCorner: (count: number) => word("drawing.noCorner", { count }),
  previous: word("drawing.previous"),
  next: word("drawing.next"),
  remove: word("drawing.remove"),
  nudge: word("drawing.nudge"),
  arrows: { ArrowLeft: word("drawing.arrows.ArrowLeft"), ArrowUp: word("drawing.arrows.ArrowUp"), ArrowDown: word("drawing.arrows.ArrowDown"), ArrowRight: word("drawing.arrows.ArrowRight") },
  arrowSigns: { ArrowLeft: "←", ArrowUp: "↑", ArrowDown: "↓", ArrowRight: "→" },
  dashed: word("drawing.dashed"),
  elsewhere: (name: string, mm: number) => word("drawing.elsewhere", { name, mm: Math.round(mm) }),
  imported: (count: number, mm: number, out: readonly string[]) =>
    [word("drawing.imported", { count }), ...(mm > 0 ? [word("drawing.importedMoved", { mm: Math.round(mm) })] : []), ...(out.length > 0 ? [word("drawing.importedOut", { names: out.join(", ") })] : [])].join("; ") + ".",
  pattern: {
    stillNeeded: (labels: readonly string[]) => word("drawing.pattern.stillNeeded", { labels: labels.join(", ") }),
    depth: word("drawing.pattern.depth"),
    depthHint: word("drawing.pattern.depthHint"),
    note: word("drawing.pattern.note"),
    needsFit: word("drawing.pattern.needsFit"),
    mirror: word("drawing.pattern.mirror"),
    byItself: word("drawing.pattern.byItself"),
    choices: { "": word("drawing.pattern.choices.none"), L: word("drawing.pattern.choices.L"), R: word("drawing.pattern.choices.R"), both: word("drawing.pattern.choices.both") } as Record<string, string>,
    range: (min: number, max: number, unit: string) => word("drawing.pattern.range", { min, max, unit }).trim(),
  },
  handles: {
    says: ({ label, side, numbers }: LiveHandle) =>
      numbers.length === 1 ? `${label}: ${amount(numbers[0]!.value, numbers[0]!.unit)}` : word(side === "L" ? "drawing.changes.onLeft" : "drawing.changes.onRight", { label: numbers.map((each) => `${each.label} ${amount(each.value, each.unit)}`).join(", ") }),
    ends: (label: string, value: number, unit: Unit) => word("drawing.handles.ends", { label, amount: amount(value, unit) }),
    keys: word("drawing.handles.keys"),
  },
  /** "breast_L" → "Breast, patient's left": for shapes whose label is not at hand */
  shapeName(name: string): string {
    const label = capital(name.replace(/_[LR]$/, "").replaceAll("_", " "));
    const side = sideOf(name);
    return side === "middle" ? label : word(side === "left" ? "drawing.onPatientsLeft" : "drawing.onPatientsRight", { label });
  },
  announceCorner: (number: number) => word("drawing.announceCorner", { number }),
  announceDrawn: (name: string) => word("drawing.announceDrawn", { name }),
  announceClosed: (name: string) => word("drawing.announceClosed", { name }),
  announceRenamed: (name: string) => word("drawing.announceRenamed", { name }),
  announceRecoloured: (name: string) => word("drawing.announceRecoloured", { name }),
  announceErased: (name: string) => word("drawing.announceErased", { name }),
  merged: word("drawing.merged"),
  nothingEarlier: word("drawing.nothingEarlier"),
  announceMoved: word("drawing.announceMoved"),
  announceCornerGone: word("drawing.announceCornerGone"),
};
