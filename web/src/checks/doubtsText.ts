// The sentences of questions that have to be answered first.
export { samePatient as patient } from "../stances/samePatientText";

/** By what a file leaves open. */
export const file = {
  frame: {
    title: "Which side is the patient's left?",
    how: "The patient faces you in each picture, lesions are ringed. Choose the picture that shows this patient. If you do not know, cancel and look at the original images.",
    left: "left",
    right: "right",
    cancel: "Cancel, upload nothing",
  },
  series: {
    title: "Which series?",
    how: "Choose one that shows the skin all around both breasts, and the lesion. One series is read; the others are not kept.",
    cancel: "Cancel, upload nothing",
  },
  same_place: {
    title: "Do these lesions lie in this image?",
    how: "Ringed: where the first of them would lie, from the feet. If you do not know, cancel and look at the original images.",
    cancel: "Cancel, take no lesions",
  },
};

export const drawing = {
  title: "Another patient's drawing?",
  says: (theirs: string | null, ours: string) => `This file was made for ${theirs === null ? "another scan" : `patient ${theirs}`}. The patient on the page is ${ours}. Nothing has been imported.`,
  leave: "Do not import",
  take: (ours: string) => `Import: it is of ${ours}`,
};

export const size = {
  title: "Is the size right?",
  right: "Yes, the size is right",
  measure: "Give a length measured on the patient",
  as: (unit: string, cm: string) => `${unit}: ${cm}\u00a0cm`,
  otherFile: "To read it in another unit, load its file again: this page does not keep it.",
  anotherFile: "Choose another file",
};
