// How much a file may unpack to: what the service allows, so that nothing is decoded only to be refused.
import * as text from "./text";

export const MEBIBYTE = 2 ** 20;
export const MOST_BYTES = 400 * MEBIBYTE;
export const MOST_TRIANGLES = 2_000_000;
export const MOST_SECONDS = 120; // a scan of a million triangles takes two

/** Something is wrong with the file; the message is a sentence for the person who chose it. */
export class BadContainer extends Error {}

export function checkTriangles(count: number): void {
  if (!(count <= MOST_TRIANGLES)) throw new BadContainer(text.tooLarge(MOST_TRIANGLES.toLocaleString("en-GB")));
}

/** Counts what is unpacked, and refuses when it becomes too much. */
export class Budget {
  private left = MOST_BYTES;

  take(bytes: number): void {
    this.left -= bytes;
    if (!(bytes >= 0 && this.left >= 0)) throw new BadContainer(text.unpacksTooLarge(MOST_BYTES / MEBIBYTE));
  }
}
