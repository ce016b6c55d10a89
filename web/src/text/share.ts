// The share dialog, and the page behind a link.
import { plural } from "./plural";
import { sideOf } from "../state/landmarks";

export const share = {
  title: "Share this result",
  what: "Whoever has the link sees this one result and can change nothing. No name is in it.",
  shown: "It shows",
  shows: {
    none: "the model, without the scan",
    plain: "the scan's shape, no colours",
    full: "the scan with its colours",
  } satisfies Record<"none" | "plain" | "full", string>,
  expiry: "It ends after",
  days: (days: number) => plural(days, "day", "days"),
  passcode: "Passcode (optional, at least 6 characters; tell it by another way)",
  noPasscode: "none",
  make: "Make a link",
  link: "Address of the link",
  once: "Copy it now: the address is shown only once.",
  copy: "Copy",
  copied: "Copied.",
  copyByHand: "The browser does not allow it: press Ctrl+C, the address is selected.",
  links: "Links to this result",
  none: "None yet.",
  until: (when: string) => `Open until ${when}`,
  revoked: (when: string) => `Revoked on ${when}`,
  expired: (when: string) => `Ended on ${when}`,
  hasPasscode: "passcode",
  opened: (count: number, when: string) => `Opened ${plural(count, "time", "times")}, last on ${when}`,
  neverOpened: "Never opened",
  wrong: (count: number, when: string) => `${plural(count, "wrong passcode", "wrong passcodes")}, the last on ${when}`,
  locked: "Locked: too many wrong passcodes were given",
  unlock: "Unlock",
  revoke: "Revoke",
  announceMade: "The link is made.",
  announceUnlocked: "The link takes passcodes again.",
  announceRevoked: "The link is revoked.",
};

export const shared = {
  title: "Shared result",
  what: "This result was shared with you. It can be looked at from all sides and taken away, but not changed.",
  until: (when: string) => `The link works until ${when}.`,
  opening: "Opening the link …",
  howToOpen: "No link is open here. To see a result, open the link that was sent to you.",
  close: "Close",
  closed: "The result is closed in this browser; files that were taken away stay where they are. To see it again, open the link that was sent to you.",
  /** "breast_L" → "Breast, patient's left": behind a link the model's own labels are not at hand */
  shape(name: string): string {
    const plain = name.replace(/_[LR]$/, "").replaceAll("_", " ");
    const side = { left: ", patient's left", right: ", patient's right", middle: "" }[sideOf(name)];
    return plain.charAt(0).toUpperCase() + plain.slice(1) + side;
  },
  needsPasscode: "This link asks for a passcode. The person who sent it knows it.",
  passcode: "Passcode",
  open: "Open",
  files: [
    { key: "report", name: "report.pdf", what: "pictures, measures" },
    { key: "fitted_glb", name: "fitted.glb", what: "posed rig with drawing" },
    { key: "fitted_ply", name: "fitted.ply", what: "posed model" },
    { key: "drawing", name: "drawing.json", what: "lines on the scan" },
    { key: "result", name: "result.json", what: "numbers, parameters" },
    { key: "mesh", name: "scan.glb", what: "the scan" },
  ] as const,
};
