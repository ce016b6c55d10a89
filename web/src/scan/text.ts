// Bringing a scan in: units, progress, what is known of it.

import { word } from "../languages/words";

export const drop = word("scan.drop");

export const crop = {
  label: word("scan.crop.label"),
  lasso: word("scan.crop.lasso"),
  undo: word("scan.crop.undo"),
  redo: word("scan.crop.redo"),
  all: word("scan.crop.all"),
  part: (number: number) => word("scan.crop.part", { number }),
  how: word("scan.crop.how"),
  corner: (count: number) => word("scan.crop.corner", { count }),
  note: (count: number) => (word(count === 0 ? "scan.crop.note" : "scan.crop.noteCut")),
  hidden: word("scan.crop.hidden"),
  together: word("scan.crop.together"),
  shown: word("scan.crop.shown"),
  tooMany: (most: number) => word("scan.crop.tooMany", { most }),
  unsaved: (why: string) => word("scan.crop.unsaved", { why }),
  nothingLeft: word("scan.crop.nothingLeft"),
};

const labels: Readonly<Record<string, string>> = { standing: word("scan.stanceNames.standing"), supine: word("scan.stanceNames.supine"), prone: word("scan.stanceNames.prone") };
const spoken: Readonly<Record<string, string>> = { standing: word("scan.inStance.standing"), supine: word("scan.inStance.supine"), prone: word("scan.inStance.prone") };

/** "Supine": as a label. */
export const stanceLabel = (stance: string): string => labels[stance] ?? stance;

/** "supine", as it stands beside "scan" in a sentence; in German "in Rückenlage", after it. */
export const inStance = (stance: string): string => spoken[stance] ?? stance;

/** What a scan that came as a file is called: its own name may hold a patient's. */
export const uploaded = word("scan.uploaded");

/** By their names; others go by these themselves. */
export const models: Readonly<Record<string, string>> = { torso: word("scan.models.torso"), male: word("scan.models.male") };

export const units = {
  auto: word("scan.units.auto"),
  mm: word("scan.units.mm"),
  cm: word("scan.units.cm"),
  dm: word("scan.units.dm"),
  m: word("scan.units.m"),
  in: word("scan.units.in"),
  ft: word("scan.units.ft"),
};

export const segments = {
  title: word("scan.segments.title"),
  further: word("scan.segments.further"),
  taken: { lesion: word("scan.segments.taken.lesion"), tissue: word("scan.segments.taken.tissue"), unused: word("scan.segments.taken.unused") },
  takeAs: (name: string) => word("scan.segments.takeAs", { name }),
  own: (label: string) => word("scan.segments.own", { label }),
  across: (mm: string) => word("scan.segments.across", { mm }),
  again: word("scan.segments.again"),
  fixed: word("scan.segments.fixed"),
  none: word("scan.segments.none"),
  noneAnyMore: word("scan.segments.noneAnyMore"),
};

export const loading = {
  sending: (title: string) => word("scan.loading.sending", { title }),
  preparing: (title: string) => word("scan.loading.preparing", { title }),
};

export const scan = {
  triangles: word("scan.triangles"),
  size: word("scan.size"),
  sizeValue: ([wide = "", high = "", deep = ""]: readonly string[]) => word("scan.sizeValue", { wide, high, deep }),
  unit: word("scan.unit"),
  stance: word("scan.stance"),
  surface: word("scan.surface"),
  fromPoints: word("scan.fromPoints"),
  cutAway: word("scan.cutAway"),
  cutAwayHint: word("scan.cutAwayHint"),
  stances: { auto: word("scan.stances.auto"), standing: word("scan.stances.standing"), supine: word("scan.stances.supine"), prone: word("scan.stances.prone") },
  facingFrom: { landmarks: word("scan.facingFrom.landmarks"), fit: word("scan.facingFrom.fit"), person: word("scan.facingFrom.person") },
  why: word("scan.why"),
};

export const errors = {
  alreadyHere: word("scan.errors.alreadyHere"),
  unreadable: word("scan.errors.unreadable"),
  noScan: word("scan.errors.noScan"),
  mesh: word("scan.errors.mesh"),
};
