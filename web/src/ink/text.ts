// Words about lines found on the skin.
import type { FoundLine } from "./state";

const capital = (word: string): string => word.charAt(0).toUpperCase() + word.slice(1);
const lines = (count: number): string => (count === 1 ? "1 line" : `${count} lines`);

export const ink = {
  title: "Lines found on the skin",
  looking: "Looking for lines of a pen in the scan’s colours …",
  none: "No lines of a pen were found in the scan’s colours.",
  late: "Finding lines takes unusually long; open the scan again later.",
  decided: "All lines found on the skin are decided.",
  what: "Read from the scan’s colours, not yet part of the plan. Look at each before you accept it.",
  marksLeft: "All lines are decided. The marks are no lines of the plan; accept one that shall be.",
  kinds: { line: "line", closed: "closed line", dashed: "dashed line", cross: "cross", arrow: "arrow", writing: "writing" } as const satisfies Record<FoundLine["kind"], string>,
  stem: (line: Pick<FoundLine, "kind" | "marker">) => capital(`${line.marker} ${ink.kinds[line.kind]}`),
  length: (mm: number) => `${Math.round(mm)} mm`,
  acceptAll: (count: number) => `Accept ${lines(count)}`,
  accept: (name: string) => `Accept ${name}`,
  drop: (name: string) => `Drop ${name}`,
  dropAll: "Drop the rest",
  bringBack: (count: number) => `Bring back ${count === 1 ? "1 dropped line" : `${count} dropped lines`}`,
  join: (name: string, other: string) => `Join ${name} with ${other}`,
  name: (name: string) => `Name of ${name}`,
  marks: (count: number) => `${count === 1 ? "1 mark" : `${count} marks`} beside the plan (crosses, arrows, writing)`,
  announceFound: (count: number) => `${lines(count)} found on the skin.`,
  announceAccepted: (count: number) => `${lines(count)} accepted into the plan.`,
  announceDropped: (name: string) => `${name} dropped.`,
  announceBroughtBack: "The dropped lines are back.",
  announceJoined: (name: string, other: string) => `${name} joined with ${other}.`,
  add: "Add the other position",
  addNote: "The accepted lines are carried to it as the same skin.",
  fitBoth: "Fit both scans",
  fitOne: "Fit the scan that is left",
  fitNote: "Lines are carried between two fitted scans; landmarks that you place make it surer.",
};
