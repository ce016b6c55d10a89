// Bringing a scan in: units, progress, what is known of it.

export const drop = "Let go to load these files";

export const crop = {
  label: "Cut parts of the scan away",
  lasso: "Lasso",
  undo: "Undo the last cut (Z)",
  redo: "Cut it again (Shift+Z)",
  all: "Bring all back",
  part: (number: number) => `Bring cut ${number} back`,
  how: "Draw around what is to go; everything behind it goes too. The second button or two fingers turn the body; Escape puts the lasso down. By keys: arrows on the body move a cross, Enter sets a corner, twice cuts.",
  corner: (count: number) => `Corner ${count} of the lasso. Enter again at the same place cuts away what lies within.`,
  note: (count: number) => (count === 0 ? "What you cut away is no part of fits and proposals; the scan itself stays whole." : "No part of fits and proposals, and kept with the scan until you bring it back. The button for table and loose pieces shows it."),
  hidden: "Cut away.",
  together: "Another tab has cut this scan too: both are cut away now.",
  shown: "Brought back.",
  tooMany: (most: number) => `More than ${most} cuts are not kept: bring some back and draw around larger parts.`,
  unsaved: (why: string) => `What is cut away is not saved yet, and fits do not know of it: ${why}`,
  nothingLeft: "The lasso goes around the whole scan, so nothing would be left: draw around the part that is in the way.",
};

/** What a scan that came as a file is called: its own name may hold a patient's. */
export const uploaded = "Uploaded scan";

/** By their names; others go by these themselves. */
export const models: Readonly<Record<string, string>> = { torso: "Torso of a woman", male: "Chest of a man" };

export const units = {
  auto: "Find out from the size",
  mm: "Millimetres",
  cm: "Centimetres",
  dm: "Decimetres",
  m: "Metres",
  in: "Inches",
  ft: "Feet",
};

export const segments = {
  title: "Segments of this label map",
  further: "Lesions of other files",
  taken: { lesion: "Lesion", tissue: "Tissue", unused: "Not used" },
  takeAs: (name: string) => `Take ${name} as`,
  own: (label: string) => `“${label}”`,
  across: (mm: string) => `${mm} mm across`,
  again: "Read the file again with these choices",
  fixed: "To take its segments otherwise, load the file again.",
  none: "This label map shows no lesion: none of its segments was taken for one. If one is, choose it below.",
  noneAnyMore: "This label map shows no lesion: none of its segments was taken for one. If one is, load the file again and choose it.",
};

export const loading = {
  sending: (title: string) => `Sending ${title}`,
  preparing: (title: string) => `Reading and checking ${title}`,
};

export const scan = {
  triangles: "Triangles",
  size: "Size",
  sizeValue: ([wide, high, deep]: readonly string[]) => `${wide}\u00a0cm wide, ${high} high, ${deep} deep`,
  unit: "Unit",
  stance: "Stance",
  surface: "Surface",
  fromPoints: "made from points",
  cutAway: "Cut away",
  cutAwayHint: "A floor, a wall, or what is beside the body, such as another person's hand: fits and measures do not see it. The button for table and loose pieces shows it.",
  stances: { auto: "Decide from the scan", standing: "Standing", supine: "Supine", prone: "Prone, as in an MRI" },
  facingFrom: { landmarks: "Upright by its landmarks.", fit: "Upright by the fitted model's spine.", person: "Turned by you." },
  why: "How this was found out",
};

export const errors = {
  alreadyHere: "This scan is already here: the same file is one of this patient's scans. Choose it from the list.",
  unreadable: "The browser cannot read this. If it is a folder, pack it into a zip; if it is a file that was moved or changed, choose it again.",
  noScan: "This scan is no longer kept by the service. Load it again.",
  mesh: "The scan cannot be drawn: the service sent a mesh that is not valid glTF.",
};
