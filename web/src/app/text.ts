// The frame of the page: tabs, top bar, the one button that says what comes next.
import { word } from "../languages/words";
import type { Step, Theme } from "../store/page";

export * from "./exportText";
export * from "./questionText";

export const page = {
  steps: { body: word("app.page.steps.body"), points: word("app.page.steps.points"), plan: word("app.page.steps.plan"), handover: word("app.page.steps.handover") } satisfies Record<Step, string>,
  stepsLabel: word("app.page.stepsLabel"),
  setPoints: word("app.page.setPoints"),
  details: word("app.page.details"),
  side: word("app.page.side"),
};

export const top = {
  patients: word("app.top.patients"),
  code: word("app.top.code"),
  scans: (count: number, day: string | null) => (day === null ? word("app.top.scansToday", { count }) : word("app.top.scansOn", { count, day })),
  undo: (what: string) => word("app.top.undo", { what }),
  undoPlain: word("app.top.undoPlain"),
  redo: word("app.top.redo"),
  saved: word("app.top.saved"),
  saving: word("app.top.saving"),
  unsaved: word("app.top.unsaved"),
  menu: word("app.top.menu"),
  picture: word("app.top.picture"),
  pictureHint: word("app.top.pictureHint"),
  remove: word("app.top.remove"),
  theme: (theme: Theme) => ({ system: word("app.top.theme.system"), light: word("app.top.theme.light"), dark: word("app.top.theme.dark") })[theme],
  fitsAtOnce: (isOn: boolean) => word(isOn ? "app.top.fitsAtOnce" : "app.top.fitsWhenAsked"),
  fitsAtOnceHint: word("app.top.fitsAtOnceHint"),
  signOut: word("app.top.signOut"),
  audit: word("app.top.audit"),
  auditHint: word("app.top.auditHint"),
  help: word("app.top.help"),
  helpHint: word("app.top.helpHint"),
};

export const handover = {
  share: word("app.handover.share"),
  shareHint: word("app.handover.shareHint"),
  measures: word("app.handover.measures"),
  measuresHint: word("app.handover.measuresHint"),
  ofPlan: {
    template: [word("app.handover.ofPlan.template.1"), word("app.handover.ofPlan.template.2")],
    right: [word("app.handover.ofPlan.right.1"), word("app.handover.ofPlan.right.2")],
    left: [word("app.handover.ofPlan.left.1"), word("app.handover.ofPlan.left.2")],
    dicom: [word("app.handover.ofPlan.dicom.1"), word("app.handover.ofPlan.dicom.2")],
  } as const,
  files: word("app.handover.files"),
  none: word("app.handover.none"),
  before: word("app.handover.before"),
  handOn: word("app.handover.handOn"),
  pages: word("app.handover.pages"),
  page: (number: number, count: number) => word("app.handover.page", { number, count }),
  making: word("app.handover.making"),
  ready: word("app.handover.ready"),
  doubtful: (wide: string) => word("app.handover.doubtful", { wide }),
  open: (count: number) => word("app.handover.open", { count }),
  predicted: word("app.handover.predicted"),
  notFitted: word("app.handover.notFitted"),
  unusable: word("app.handover.unusable"),
  unseen: (lesion: string) => word("app.handover.unseen", { lesion }),
  ink: (count: number) => word("app.handover.ink", { count }),
  ways: { check: word("app.handover.ways.check"), points: word("app.handover.ways.points"), plan: word("app.handover.ways.plan"), scan: word("app.handover.ways.scan") },
  print: word("app.handover.print"),
};

export const next = {
  start: (label: string) => word("app.next.start", { label }),
  armed: (label: string) => word("app.next.armed", { label }),
  correct: word("app.next.correct"),
  ink: (count: number, on: string | null) => (on === null ? word("app.next.ink", { count }) : word("app.next.inkOn", { count, on })),
  plan: word("app.next.plan"),
  draw: word("app.next.draw"),
  drawing: word("app.next.drawing"),
  add: (stance: string) => word("app.next.add", { stance }),
  changeOver: (to: string) => word("app.next.changeOver", { to }),
  print: word("app.next.print"),
  wait: word("app.next.wait"),
};

/** "Standing, 53 cm tall, facing you": each word is a button that corrects itself. */
export const sentence = {
  label: word("app.sentence.label"),
  stances: { standing: word("app.sentence.stances.standing"), supine: word("app.sentence.stances.supine"), prone: word("app.sentence.stances.prone") },
  stance: word("app.sentence.stance"),
  size: (cm: string, lies: boolean) => word(lies ? "app.sentence.long" : "app.sentence.tall", { cm }),
  unit: word("app.sentence.unit"),
  asUnit: (cm: string, lies: boolean) => word(lies ? "app.sentence.asUnitLong" : "app.sentence.asUnitTall", { cm }),
  otherFile: word("app.sentence.otherFile"),
  imageUnit: word("app.sentence.imageUnit"),
  facing: { standing: word("app.sentence.facing.standing"), supine: word("app.sentence.facing.supine"), prone: word("app.sentence.facing.prone") },
  turned: word("app.sentence.turned"),
  direction: word("app.sentence.direction"),
  turns: { around: word("app.sentence.turns.around"), sideways: word("app.sentence.turns.sideways"), forwards: word("app.sentence.turns.forwards") },
  models: { torso: word("app.sentence.models.torso"), male: word("app.sentence.models.male") } as Readonly<Record<string, string>>,
  guess: (who: string) => `${who}?`,
  guessed: word("app.sentence.guessed"),
  model: word("app.sentence.model"),
  modelFile: word("app.sentence.modelFile"),
};

export const bringing = {
  none: (count: number) => word("app.bringing.none", { count }),
  slices: word("app.bringing.slices"),
  noImage: (images: number) => (word(images === 0 ? "app.bringing.noImage" : "app.bringing.severalImages")),
  notTaken: (count: number) => word("app.bringing.notTaken", { count }),
  unplaced: (count: number) => word("app.bringing.unplaced", { count }),
};
