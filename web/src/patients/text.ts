// Words of the first page.
import { word } from "../languages/words";
import { notice } from "../ui/text";

export const home = {
  title: word("patients.home.title"),
  notice,
  search: word("patients.home.search"),
  order: word("patients.home.order"),
  orders: { newest: word("patients.home.orders.newest"), code: word("patients.home.orders.code"), deletion: word("patients.home.orders.deletion") },
  fresh: word("patients.home.fresh"),
  drop: word("patients.home.drop"),
  limit: (megabytes: string | null, zip: string | null) =>
    word("patients.home.limit", { megabytes: megabytes ?? "…", zip: zip ?? "…" }),
  example: word("patients.home.example"),
  exampleHint: word("patients.home.exampleHint"),
  allExamples: word("patients.home.allExamples"),
  code: word("patients.home.code"),
  noCode: word("patients.home.noCode"),
  none: (search: string) => word("patients.home.none", { search }),
  more: word("patients.home.more"),
  more1: (code: string) => word("patients.home.more1", { code }),
  image: word("patients.home.image"),
  onImage: word("patients.home.onImage"),
  lines: (count: number) => word("patients.home.lines", { count }),
  lesions: (count: number) => word("patients.home.lesions", { count }),
  nothing: word("patients.home.nothing"),
  ready: word("patients.home.ready"),
  notFitted: word("patients.home.notFitted"),
  fitting: word("patients.home.fitting"),
  check: (points: number | undefined, on: string) => (points ? word("patients.home.check", { count: points, on }) : word("patients.home.toLookAt", { on })),
  unusable: (on: string) => word("patients.home.unusable", { on }),
  near: [(time: string) => word("patients.home.near.1", { time }), (time: string) => word("patients.home.near.2", { time })],
  left: (days: number) => (days === 0 ? word("patients.home.leftToday") : word("patients.home.left", { count: days })),
  rename: word("patients.home.rename"),
  remove: word("patients.home.remove"),
  sure: (code: string, scans: number) =>
    word("patients.home.sure", { code, count: scans }),
  yes: word("patients.home.yes"),
  no: word("patients.home.no"),
  going: (code: string) => word("patients.home.going", { code }),
  undo: word("patients.home.undo"),
  announceGone: (code: string) => word("patients.home.announceGone", { code }),
};
