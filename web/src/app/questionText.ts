// Questions before something goes: another patient, a scan to be deleted.
import { plural } from "../ui/plural";

export const leaving = {
  title: "Not everything is saved",
  what: { landmarks: "The landmarks of this scan", lines: "The lines that you drew" },
  lost: (things: readonly string[]) => `${things.join(" and ")} could not be saved. They are lost if you go on.`,
  again: "Save again",
  stay: "Stay here",
  anyhow: "Go on without saving",
};

export const deletion = {
  title: "Delete this scan?",
  goes: (landmarks: number, lines: number, hasFit: boolean) =>
    `The service deletes the scan and all that was made of it: ${[plural(landmarks, "landmark", "landmarks"), plural(lines, "own line", "own lines"), ...(hasFit ? ["its fits with their files and reports, and every link that shows them"] : [])].join(", ")}.`,
  noWay: "There is no copy. You can take it back for ten seconds.",
  other: "The other stance stays.",
  confirm: "Delete",
  keep: "Keep it",
  soon: (title: string) => `${title}: will be deleted in ten seconds.`,
  undo: "Take it back",
  announceDone: "The scan is deleted.",
};
