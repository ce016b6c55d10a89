// What the page shows, kept in the address after "#", so that a reload or a copied link tells the same story.
import type { Frame, Vector } from "../api/types";

export interface Place {
  scan: string | null;
  fit: string | null;
  /** Only when the person turned the body: otherwise the service's proposal holds. */
  frame: Frame | null;
}

const write = (v: Vector): string => v.map((x) => Number(x.toFixed(4))).join("_");

function read(text: string | null): Vector | null {
  const numbers = (text ?? "").split("_").map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) && text ? (numbers as Vector) : null;
}

export function toHash(place: Place): string {
  const words = new URLSearchParams();
  if (place.scan) words.set("scan", place.scan);
  if (place.scan && place.fit) words.set("fit", place.fit);
  if (place.scan && place.frame) {
    words.set("up", write(place.frame.up));
    words.set("front", write(place.frame.front));
  }
  const text = words.toString();
  return text === "" ? "" : `#${text}`;
}

export function fromHash(hash: string): Place {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const up = read(words.get("up"));
  const front = read(words.get("front"));
  return { scan: words.get("scan"), fit: words.get("fit"), frame: up && front ? { up, front } : null };
}
