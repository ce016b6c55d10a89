// Whether two scans are of one patient: the question, and what holds while it is open.
import { word } from "../languages/words";

export const samePatient = {
  title: word("stances.samePatient.title"),
  says: (why: string, code: string) => word("stances.samePatient.says", { why, code }),
  same: (code: string) => word("stances.samePatient.same", { code }),
  another: (name: string) => word("stances.samePatient.another", { name }),
  anotherHint: word("stances.samePatient.anotherHint"),
  unsure: word("stances.samePatient.unsure"),
  unsureHint: word("stances.samePatient.unsureHint"),
  left: word("stances.samePatient.left"),
  answer: word("stances.samePatient.answer"),
  further: word("stances.samePatient.further"),
  announce: (name: string, code: string) => word("stances.samePatient.announce", { name, code }),
};
