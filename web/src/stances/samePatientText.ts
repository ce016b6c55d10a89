// Whether two scans are of one patient: the question, and what holds while it is open.
export const samePatient = {
  title: "Scans of one patient?",
  says: (why: string, code: string) => `${why} They are filed as those of ${code}. Until you say which it is, nothing is carried from one to the other.`,
  same: (code: string) => `Yes, both are ${code}`,
  another: (name: string) => `No, the ${name} scan is another patient's`,
  anotherHint: "It is filed by itself under a new code, with what was planned on it",
  unsure: "I cannot say",
  unsureHint: "Both stay filed as they are; nothing is carried between them",
  left: "Nothing is carried between these two scans: it is open whether both are this patient's.",
  answer: "Say whose scans they are",
  further: "further",
  announce: (name: string, code: string) => `The ${name} scan is filed as patient ${code}, by itself.`,
};
