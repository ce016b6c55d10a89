// The frame of the page: tabs, top bar, the one button that says what comes next.
import type { Step, Theme } from "../store/page";
import { plural } from "../ui/plural";

export * from "./exportText";
export * from "./questionText";

export const page = {
  steps: { body: "Body", points: "Set points", plan: "Plan", handover: "Hand over" } satisfies Record<Step, string>,
  stepsLabel: "Body, plan, hand over",
  setPoints: "Set points myself",
  details: "Details",
  side: "What is known and planned",
};

export const top = {
  patients: "All patients",
  code: "The patient's code",
  scans: (scans: string, day: string) => `${scans} ${day === "Today" ? "today" : `on ${day}`}`,
  undo: (what: string) => `Undo “${what}”`,
  undoPlain: "Undo",
  redo: "Redo (Shift+Z)",
  saved: "Saved",
  saving: "Saving …",
  unsaved: "Not saved yet",
  menu: "More",
  picture: "Picture of this view",
  pictureHint: "PNG, twice the size, with scale and colours",
  remove: "Delete this scan …",
  theme: (theme: Theme) => ({ system: "Theme: as the system", light: "Theme: light", dark: "Theme: dark" })[theme],
  fitsAtOnce: (isOn: boolean) => `New scans are fitted ${isOn ? "at once" : "when asked to"}`,
  fitsAtOnceHint: "Press to change it, on this browser",
  signOut: "Sign out",
  help: "Keyboard and mouse",
  helpHint: "All keys, and what this is (?)",
};

export const handover = {
  share: "Make a link",
  shareHint: "A page for a colleague, for some days; the model, and what else you choose",
  measures: "Measures",
  measuresHint: "Lengths, symmetry and volumes",
  ofPlan: {
    template: ["Template", "The plan in true size, laid flat: print it, cut it out, lay it on the skin"],
    right: ["guide, right (STL)", "A shell to print in 3D, with slots along the lines; its name says how far the arrow is from the notch"],
    left: ["guide, left (STL)", "A shell to print in 3D, with slots along the lines; its name says how far the arrow is from the notch"],
  } as const,
  files: "Files for programs",
  none: "Fit the model to the scan first.",
  before: "Before you print",
  handOn: "Hand it on",
  pages: "The printed pages",
  page: (number: number, count: number) => `Page ${number} of ${count}`,
  making: "The pages are being made: some seconds.",
  ready: "ready",
  doubtful: (wide: string) => `lines are ${wide}; its doubts and notes say why`,
  open: (count: number) => `${plural(count, "point", "points")} not checked`,
  predicted: "predicted, not scanned",
  notFitted: "the model is not fitted",
  unusable: "cannot be used",
  unseen: (lesion: string) => `no skin is seen over ${lesion}`,
  ink: (count: number) => `${plural(count, "line", "lines")} found on the skin, not decided`,
  ways: { check: "Check", points: "Set points", plan: "Plan", scan: "Add the scan" },
  print: "Print",
};

export const next = {
  start: (label: string) => `Place ${label}`,
  armed: (label: string) => `Click on ${label}`,
  correct: "Look at the landmarks again",
  ink: (count: number, on: string | null) => `Look at the ${plural(count, "line", "lines")} found on the ${on === null ? "skin" : `${on} scan`}`,
  plan: "Draw the plan",
  draw: "Draw with the pen",
  drawing: "Put the pen down",
  add: (stance: string) => `Add the ${stance} scan`,
  changeOver: (to: string) => `Go on with the ${to} scan`,
  print: "Print the plan",
  wait: "Looking for points to check …",
};

/** "Standing, 53 cm tall, facing you": each word is a button that corrects itself. */
export const sentence = {
  label: "What was read; press a word to correct it",
  stances: { standing: "Standing", supine: "Supine", prone: "Prone" },
  stance: "How the patient stands or lies",
  size: (cm: string, lies: boolean) => `${cm}\u00a0cm ${lies ? "long" : "tall"}`,
  unit: "Size: the unit of the file",
  asUnit: (cm: string, lies: boolean) => `then it is ${cm}\u00a0cm ${lies ? "long" : "tall"}`,
  otherFile: "To read it in another unit, load its file again: this page does not keep it.",
  imageUnit: "The image itself says how large it is.",
  facing: { standing: "facing you", supine: "face up", prone: "face down" },
  turned: "turned by you",
  direction: "Which way the body faces: turn the picture by 90°",
  turns: { around: "Turn about its long axis", sideways: "Roll in the plane of the picture", forwards: "Tip forwards, over the feet" },
  models: { torso: "a woman", male: "a man" } as Readonly<Record<string, string>>,
  guess: (who: string) => `${who}?`,
  guessed: "nobody has said so",
  model: "Whose model is fitted",
  modelFile: "To fit another model, load its file again: this page does not keep it.",
};

export const bringing = {
  none: (count: number) => (count === 1 ? "This file is no scan that can be read." : `None of these ${count} files is a scan that can be read. Pack files that belong together, as an OBJ and its pictures do, into one zip.`),
  slices: "These are single slices of an image: pack the whole folder of DICOM files into one zip and drop that.",
  noImage: (images: number) => (images === 0 ? "This file shows lesions alone: drop it together with the image that they were drawn on." : "Lesions were not taken, as several images came with them: open the patient's image and drop them there."),
  notTaken: (count: number) => `${plural(count, "file was", "files were")} not taken: no scan, and no landmarks. Pack files that belong together, as an OBJ and its pictures do, into one zip.`,
  unplaced: (count: number) => `${plural(count, "file of landmarks was", "files of landmarks were")} not taken, as it is not clear on which of the scans they lie: open that scan, press Set points myself, and import it there.`,
};
