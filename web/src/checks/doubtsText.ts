// The sentences of questions that have to be answered first.
import { word } from "../languages/words";

export { samePatient as patient } from "../stances/samePatientText";

/** By what a file leaves open. */
export const file = {
  frame: {
    title: word("checks.file.frame.title"),
    how: word("checks.file.frame.how"),
    left: word("checks.file.frame.left"),
    right: word("checks.file.frame.right"),
    cancel: word("checks.file.frame.cancel"),
  },
  series: {
    title: word("checks.file.series.title"),
    how: word("checks.file.series.how"),
    cancel: word("checks.file.series.cancel"),
  },
  same_place: {
    title: word("checks.file.same_place.title"),
    how: word("checks.file.same_place.how"),
    cancel: word("checks.file.same_place.cancel"),
  },
};

export const drawing = {
  title: word("checks.drawing.title"),
  says: (theirs: string | null, ours: string) => (theirs === null ? word("checks.drawing.saysScan", { ours }) : word("checks.drawing.saysPatient", { theirs, ours })),
  leave: word("checks.drawing.leave"),
  take: (ours: string) => word("checks.drawing.take", { ours }),
};

export const size = {
  title: word("checks.size.title"),
  right: word("checks.size.right"),
  measure: word("checks.size.measure"),
  as: (unit: string, cm: string) => word("checks.size.as", { unit, cm }),
  otherFile: word("checks.size.otherFile"),
  anotherFile: word("checks.size.anotherFile"),
};
