// The sentences of the tour.
import { plural } from "../ui/plural";
import { formatMmWhole } from "../ui/units";

const capital = (words: string): string => words.charAt(0).toUpperCase() + words.slice(1);

export const checks = {
  begin: (count: number, on: string) => `Check ${plural(count, on === "" ? "point" : `${on} point`, on === "" ? "points" : `${on} points`)}`,
  lasts: (count: number) => `${10 * count}\u00a0s`,
  progress: (at: number, count: number) => `Point ${at} of ${count}`,
  title: capital,
  ask: "Is the dot there?",
  askMoved: "Is it here?",
  now: "lines now",
  then: "then about",
  why: "Of all points, these narrow the lines most. The lines follow the dot.",
  whyMoved: "The lines have followed the dot.",
  yes: "Yes, it is here",
  move: "Move it",
  how: "Click where it is, drag the dot, or press the arrow keys: 1 mm, with Shift 5 mm.",
  unseen: "I cannot see it",
  leave: "Leave the check",
  look: "Look at the point",
  ways: { below: "From below", side: "From the side" } as const,
  disc: "guessed: it may lie anywhere in the disc",
  inset: "The same place on the model",
  next: (label: string) => `Next: ${label}`,
  fitting: (count: number) => `Fitting with ${plural(count, "checked point", "checked points")} …`,
  stance: "Is the patient standing or lying?",
  stances: { standing: "Standing", supine: "Lying on the back", prone: "Lying on the front" } as const,
  narrowed: (from: string, to: string) => `The lines have narrowed: they were ${from} and are ${to}.`,
  notNarrowed: (to: string) => `The lines have not narrowed: they are ${to}, as before. The points were where they were expected.`,
  nothing: "Nothing was checked; the lines are as they were.",
  announce: (at: number, count: number, label: string, question: string, from: string, to: string) => `Point ${at} of ${count}: ${label}. ${question} Lines are ${from}; then about ${to}. Enter: yes. Arrow keys move it by a millimetre. Escape leaves.`,
  announceMoved: (mm: number) => `Moved by ${formatMmWhole(mm)} mm.`,
  noSkin: "There is no skin there.",
};
