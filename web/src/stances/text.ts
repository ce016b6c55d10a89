// Two stances of one patient: the second scan, the two panes, the drawing in both, the table of measures.
import { capital, listed, word } from "../languages/words";
import { inStance, stanceLabel } from "../scan/text";

export const strip = {
  label: word("stances.strip.label"),
  names: { standing: word("stances.strip.names.standing"), supine: word("stances.strip.names.supine"), prone: word("stances.strip.names.prone") }, // short: a picture is not wider
  today: word("stances.strip.today"),
  image: word("stances.strip.image"),
  predicted: word("stances.strip.predicted"),
  lines: (wide: string) => word("stances.strip.lines", { wide }),
  points: (count: number) => word("stances.strip.points", { count }),
  pane: (pane: number) => word("stances.strip.pane", { pane }),
  add: word("stances.strip.add"),
  addHint: word("stances.strip.addHint"),
  visits: word("stances.strip.visits"),
  visitsHint: word("stances.strip.visitsHint"),
};

export const stances = {
  here: (name: string) => capital(name),
  called: (stance: string, isPredicted: boolean) => (isPredicted ? word("stances.called", { stance }) : stance),
  work: word("stances.work"),
  following: word("stances.following"),
  canvas: (name: string) => word("stances.canvas", { name }),

  predicted: {
    badge: word("stances.predicted.badge"),
    picture: (name: string) => word("stances.predicted.picture", { name }),
    sure: (lines: string, wide: string) => word("stances.predicted.sure", { lines: capital(lines), wide }),
    offer: word("stances.predicted.offer"),
    offerWhat: word("stances.predicted.offerWhat"),
    predict: (stance: string) => word("stances.predicted.predict", { stance: inStance(stance) }),
    needsFit: word("stances.predicted.needsFit"),
    busy: (stance: string) => word("stances.predicted.busy", { stance: inStance(stance) }),
    gone: word("stances.predicted.gone"),
    announce: (stance: string) => word("stances.predicted.announce", { stance: inStance(stance) }),
  },

  dialog: {
    title: word("stances.dialog.title"),
    what: word("stances.dialog.what"),
    upload: word("stances.dialog.upload"),
    examples: word("stances.dialog.examples"),
    elsewhere: word("stances.dialog.elsewhere"),
    code: word("stances.dialog.code"),
    find: word("stances.dialog.find"),
    nobody: (code: string) => word("stances.dialog.nobody", { code }),
    moves: (code: string, there: string) => word("stances.dialog.moves", { there, code }),
    at: (stance: string, when: string) => word("stances.dialog.at", { stance: stanceLabel(stance), when }),
    busy: word("stances.dialog.busy"),
  },

  carry: {
    title: word("stances.carry.title"),
    needsFits: (names: string) => word("stances.carry.needsFits", { names }),
    needsLines: word("stances.carry.needsLines"),
    busy: word("stances.carry.busy"),
    done: (names: readonly string[]) => word("stances.carry.done", { count: names.length, names: listed(names) }),
    donePredicted: (name: string) => word("stances.carry.donePredicted", { name }),
    error: (wide: string) => word("stances.carry.error", { wide }),
    bridged: (bridged: number, points: number) => word("stances.carry.bridged", { bridged, points }),
  },

  announceAdded: word("stances.announceAdded"),
  announceSwapped: (name: string) => word("stances.announceSwapped", { name }),
};
