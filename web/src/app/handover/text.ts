// What is said of sending to an archive.
import { word } from "../../languages/words";

export const toArchive = {
  send: (archive: string): string => word("app.handover.toArchive", { archive }),
  hint: word("app.handover.toArchiveHint"),
  archived: (archive: string, notes: string): string => word("app.handover.archived", { archive, notes }),
  archiving: word("app.handover.archiving"),
};
