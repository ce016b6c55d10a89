// Words about lines found on the skin.
import { capital, word } from "../languages/words";
import type { FoundLine } from "./state";

const lines = (count: number): string => word("ink.lines", { count });

export const ink = {
  title: word("ink.title"),
  looking: word("ink.looking"),
  none: word("ink.none"),
  late: word("ink.late"),
  decided: word("ink.decided"),
  what: word("ink.what"),
  marksLeft: word("ink.marksLeft"),
  kinds: { line: word("ink.kinds.line"), closed: word("ink.kinds.closed"), dashed: word("ink.kinds.dashed"), cross: word("ink.kinds.cross"), arrow: word("ink.kinds.arrow"), writing: word("ink.kinds.writing") } as const satisfies Record<FoundLine["kind"], string>,
  markers: { violet: word("ink.markers.violet"), black: word("ink.markers.black"), blue: word("ink.markers.blue"), green: word("ink.markers.green"), red: word("ink.markers.red") } as const satisfies Record<FoundLine["marker"], string>,
  stem: (line: Pick<FoundLine, "kind" | "marker">) => capital(word("ink.stem", { marker: ink.markers[line.marker], kind: ink.kinds[line.kind] })),
  length: (mm: number) => word("ink.length", { mm: Math.round(mm) }),
  acceptAll: (count: number) => word("ink.acceptAll", { count: lines(count) }),
  accept: (name: string) => word("ink.accept", { name }),
  drop: (name: string) => word("ink.drop", { name }),
  dropAll: word("ink.dropAll"),
  bringBack: (count: number) => word("ink.bringBack", { count }),
  join: (name: string, other: string) => word("ink.join", { name, other }),
  name: (name: string) => word("ink.name", { name }),
  marks: (count: number) => word("ink.marks", { count }),
  announceFound: (count: number) => word("ink.announceFound", { count: lines(count) }),
  announceAccepted: (count: number) => word("ink.announceAccepted", { count: lines(count) }),
  announceDropped: (name: string) => word("ink.announceDropped", { name }),
  announceBroughtBack: word("ink.announceBroughtBack"),
  announceJoined: (name: string, other: string) => word("ink.announceJoined", { name, other }),
  add: word("ink.add"),
  addNote: word("ink.addNote"),
  fitBoth: word("ink.fitBoth"),
  fitOne: word("ink.fitOne"),
  fitNote: word("ink.fitNote"),
};
