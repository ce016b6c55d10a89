// Questions before something goes: another patient, a scan to be deleted.
import { plural } from "../ui/plural";

export const leaving = {
  title: "Not everything is saved",
  what: { landmarks: "The landmarks of this scan", lines: "Lines, patterns, lesions or notes", cuts: "What you cut away" },
  lost: (things: readonly string[]) => `${things.join(" and ")} could not be saved. They are lost if you go on.`,
  again: "Save again",
  stay: "Stay here",
  anyhow: "Go on without saving",
};

const WHAT = { landmarks: "landmarks", lines: "the plan (lines, patterns, tumour, notes)", cuts: "cuts" };

export const unsaved = {
  says: (what: readonly (keyof typeof WHAT)[], why: string, isFull: boolean) =>
    `Not saved yet: ${what.map((each) => WHAT[each]).join(", ")}. ${why} ${isFull ? "The browser has no room to keep it: leave this page open." : "It is kept in this tab, also over a reload or a sign-in, and saved as soon as that works."}`,
  now: "Save now",
  saved: "Everything is saved.",
};

export const deletion = {
  title: "Delete this scan?",
  goes(landmarks: number, lines: number, planned: readonly string[], hasFit: boolean): string {
    const made = [
      ...(landmarks > 0 ? [plural(landmarks, "landmark", "landmarks")] : []),
      ...(lines > 0 ? [plural(lines, "line of yours", "lines of yours")] : []),
      ...planned,
      ...(hasFit ? ["its fits with their files and reports, and every link that shows them"] : []),
    ];
    return made.length === 0 ? "The service deletes the scan; nothing was made of it yet." : `The service deletes the scan and all that was made of it: ${made.join(", ")}.`;
  },
  noWay: "There is no copy. You can take it back for ten seconds.",
  note: "the note",
  other: (isDrawn: boolean) => (isDrawn ? "The patient's other scans stay, without what was drawn on this one." : "The patient's other scans stay."),
  confirm: "Delete",
  keep: "Keep it",
  soon: (title: string) => `${title} will be deleted in ten seconds.`,
  undo: "Take it back",
  announceDone: "The scan is deleted.",
};
