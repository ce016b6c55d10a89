// Marks of the patient's skin.
import { word } from "../../languages/words";

export const marks = {
  title: word("landmarks.marks.title"),
  hint: word("landmarks.marks.hint"),
  add: word("landmarks.marks.add"),
  sign: "\u00d7",
  spoken: (called: string) => word("landmarks.marks.spoken", { called }),
  nameOf: (called: string) => word("landmarks.marks.nameOf", { called }),
  remove: (called: string) => word("landmarks.marks.remove", { called }),
  takeOut: word("landmarks.marks.takeOut"),
  again: word("landmarks.marks.again"),
  missing: word("landmarks.marks.missing"),
  placed: (isPaired: boolean) => (word(isPaired ? "landmarks.marks.placedOnBoth" : "landmarks.marks.placed")),
  how: word("landmarks.marks.how"),
  pair: word("landmarks.marks.pair"),
  pairUnknown: word("landmarks.marks.pairUnknown"),
  announcePlaced: (called: string, next: string | null) => (next === null ? word("landmarks.marks.announcePlaced", { called }) : word("landmarks.marks.announcePlacedNext", { called, next })),
  isLandmark: (called: string) => word("landmarks.marks.isLandmark", { called }),
  isTaken: (called: string) => word("landmarks.marks.isTaken", { called }),
  isEmpty: word("landmarks.marks.isEmpty"),
};
