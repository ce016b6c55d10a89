// Visits: what a person says of a scan's day goes to the service, and what changed is put into words.
import { expect, test, vi } from "vitest";
import { page, scanInfo } from "../../fakes";
import type { Client } from "../../../src/api/client";
import type { Patient, VisitsFile } from "../../../src/api/types";
import { daysOf, thumbsOf } from "../../../src/stances/thumbs";
import { saidOf } from "../../../src/stances/visits/VisitsDialog";

const FILE = { stances: [], asked: [], published: [] } as unknown as VisitsFile;
const side = { seen_share: 0.9, half_band_mm: 2.84, said_share: 0.1, largest_mm: -6.2 };
const change = {
  earlier: 0,
  later: 1,
  doubts: [],
  missing: "",
  map: { untouched_spread_mm: 1, left: side, right: { ...side, largest_mm: null } },
  measures: [{ measure: "volume", said: { left: "-50 ±30", difference: "-40 ±40" } }],
} as unknown as VisitsFile["stances"][number]["changes"][number];

test("a change is said with its band, and what is within the band is said to be no change", () => {
  expect(saidOf(change)).toEqual(["Left breast: volume changed by -50 ±30 ml", "Left breast: skin moved by up to −6.2 mm (band 2.8 mm)", "Right breast: no change of the skin beyond the band of 2.8 mm"]);
  expect(saidOf({ ...change, map: null, measures: [] })).toEqual([]);
});

test("a day goes to the service, an empty one as not known, and the strip groups the scans by it", async () => {
  const known: Record<string, { date: string | null; label: string }> = { a: { date: null, label: "" }, b: { date: "2026-03-01", label: "before" } };
  const putVisit = vi.fn<Client["putVisit"]>(async (scan, date, label) => ({ scan, ...(known[scan] = { date, label }) }));
  const visits = async () => ({ scans: Object.entries(known).map(([scan, visit]) => ({ scan, ...visit })) });
  const scans = ["a", "b"].map((id) => ({ id, stance: "standing", created_at: scanInfo(id).created_at, thumbnail: "", kind: "surface", fit: null }));
  const { store, actions } = page({ putVisit, visits, visitsFile: async () => FILE, patient: async (id: string) => ({ id, scans }) as unknown as Patient });
  await actions.scan.open("a", null);
  await actions.visits.open();
  expect(store.get().stances.visits).toMatchObject({ isOpen: true, isBusy: false, file: FILE });
  store.set(({ stances }) => ({ stances: { ...stances, scans: scans as unknown as Patient["scans"] } }));
  const days = (): string[][] => daysOf(thumbsOf(store.get())).map(([, thumbs]) => thumbs.map(({ id }) => id));
  expect(days(), "one on the day on which it came").toEqual([["a"], ["b"]]);
  await actions.visits.say("a", "2026-03-01", "before");
  expect(putVisit).toHaveBeenLastCalledWith("a", "2026-03-01", "before");
  expect(days()).toEqual([["a", "b"]]);
  await actions.visits.say("a", "", "");
  expect(putVisit).toHaveBeenLastCalledWith("a", null, "");
});
