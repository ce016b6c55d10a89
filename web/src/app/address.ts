// What the page shows, kept in the address after "#", so that a reload or a copied link shows the same.
import type { Frame, Patient, Vector } from "../api/types";
import type { Step } from "../store/page";

export interface PageAddress {
  scan: string | null;
  fit: string | null;
  step: Step | null;
  /** Only when the person turned the body: otherwise the service's proposal holds. */
  frame: Frame | null;
  /** The other stance of the same patient. */
  other: { scan: string; fit: string | null; frame: Frame | null } | null;
  /** The page works on the one that came second. */
  isSecond: boolean;
  isComparing: boolean;
}

const STEPS: readonly Step[] = ["body", "points", "plan", "handover"];

const write = (v: Vector): string => v.map((x) => Number(x.toFixed(4))).join("_");

function read(text: string | null): Vector | null {
  const numbers = (text ?? "").split("_").map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) && text ? (numbers as Vector) : null;
}

export function toHash(place: PageAddress): string {
  const words = new URLSearchParams();
  if (place.scan) words.set("scan", place.scan);
  if (place.scan && place.fit) words.set("fit", place.fit);
  if (place.scan && place.step) words.set("step", place.step);
  if (place.scan && place.frame) {
    words.set("up", write(place.frame.up));
    words.set("front", write(place.frame.front));
  }
  if (place.scan && place.other) {
    words.set("other", place.other.scan);
    if (place.other.fit) words.set("otherfit", place.other.fit);
    if (place.other.frame) {
      words.set("otherup", write(place.other.frame.up));
      words.set("otherfront", write(place.other.frame.front));
    }
    if (place.isSecond) words.set("second", "1");
    if (place.isComparing) words.set("compare", "1");
  }
  const text = words.toString();
  return text === "" ? "" : `#${text}`;
}

/** The state of a patient's work: the first two scans with their newest fits, on the older one. */
export function addressOfPatient({ scans: [first, second] }: Pick<Patient, "scans">): string {
  const place = (scan: Patient["scans"][number]): { scan: string; fit: string | null; frame: null } => ({ scan: scan.id, fit: scan.fit?.state === "done" ? scan.fit.id : null, frame: null });
  if (!first) return "#";
  const own = place(first);
  return toHash({ ...own, step: "body", other: second ? place(second) : null, isSecond: false, isComparing: second !== undefined && own.fit !== null });
}

export function fromHash(hash: string): PageAddress {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const frame = (prefix: string): Frame | null => {
    const up = read(words.get(`${prefix}up`));
    const front = read(words.get(`${prefix}front`));
    return up && front ? { up, front } : null;
  };
  const other = words.get("other");
  return {
    scan: words.get("scan"),
    fit: words.get("fit"),
    step: STEPS.find((step) => step === words.get("step")) ?? null,
    frame: frame(""),
    other: other ? { scan: other, fit: words.get("otherfit"), frame: frame("other") } : null,
    isSecond: words.has("second"),
    isComparing: words.has("compare"),
  };
}
