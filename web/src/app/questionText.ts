// Questions before something goes: another patient, a scan to be deleted.
import { listed, word } from "../languages/words";

export const leaving = {
  title: word("app.leaving.title"),
  what: { landmarks: word("app.leaving.what.landmarks"), lines: word("app.leaving.what.lines"), cuts: word("app.leaving.what.cuts") },
  lost: (things: readonly string[]) => word("app.leaving.lost", { things: listed(things) }),
  again: word("app.leaving.again"),
  stay: word("app.leaving.stay"),
  anyhow: word("app.leaving.anyhow"),
};

const WHAT = { landmarks: word("app.WHAT.landmarks"), lines: word("app.WHAT.lines"), cuts: word("app.WHAT.cuts") };

export const unsaved = {
  says: (what: readonly (keyof typeof WHAT)[], why: string, isFull: boolean) =>
    word(isFull ? "app.unsaved.full" : "app.unsaved.kept", { what: what.map((each) => WHAT[each]).join(", "), why }),
  now: word("app.unsaved.now"),
  saved: word("app.unsaved.saved"),
};

export const deletion = {
  title: word("app.deletion.title"),
  goes(landmarks: number, lines: number, planned: readonly string[], hasFit: boolean): string {
    const made = [
      ...(landmarks > 0 ? [word("app.deletion.landmarks", { count: landmarks })] : []),
      ...(lines > 0 ? [word("app.deletion.lines", { count: lines })] : []),
      ...planned,
      ...(hasFit ? [word("app.deletion.fits")] : []),
    ];
    return made.length === 0 ? word("app.deletion.alone") : word("app.deletion.all", { made: made.join(", ") });
  },
  noWay: word("app.deletion.noWay"),
  note: word("app.deletion.note"),
  other: (isDrawn: boolean) => (word(isDrawn ? "app.deletion.otherDrawn" : "app.deletion.other")),
  confirm: word("app.deletion.confirm"),
  keep: word("app.deletion.keep"),
  soon: (title: string) => word("app.deletion.soon", { title }),
  undo: word("app.deletion.undo"),
  announceDone: word("app.deletion.announceDone"),
};
