// Words of the first page.
import { plural } from "../ui/plural";
import { notice } from "../ui/text";

export const home = {
  title: "Patients",
  notice,
  search: "Find a code",
  order: "Order",
  orders: { newest: "Newest first", code: "By code", deletion: "Deleted soonest" },
  fresh: "New patient",
  drop: "Drop the patient's scans anywhere on this page",
  limit: (megabytes: string | null, zip: string | null) =>
    `Standing, lying, and the MRI with its lesions, together or one by one. 3D scans, NIfTI, NRRD up to ${megabytes ?? "…"} MB, a zip of DICOM up to ${zip ?? "…"} MB. They stay on this service; no names.`,
  example: "Try the example",
  exampleHint: "A synthetic patient: nobody's scan",
  allExamples: "All scans of the example patient",
  code: "Code, never a name",
  noCode: "the patient without a code",
  none: (search: string) => `No code holds “${search}”.`,
  more: "Show more",
  more1: (code: string) => `More about ${code}`,
  image: "MRI",
  lines: (count: number) => plural(count, "line", "lines"),
  lesions: (count: number) => plural(count, "lesion", "lesions"),
  nothing: "Nothing planned yet",
  ready: "ready to draw",
  notFitted: "no model yet",
  fitting: "the model is being fitted",
  check: (points: number | undefined, on: string) => (points ? `${plural(points, "point", "points")} to check on ${on}` : `${on} to be looked at`),
  unusable: (on: string) => `${on} cannot be used`,
  near: [(time: string) => `today, ${time}`, (time: string) => `yesterday, ${time}`],
  left: (days: number) => (days === 0 ? "deleted today" : `deleted in ${plural(days, "day", "days")}`),
  rename: "Change the code",
  remove: "Delete this patient …",
  sure: (code: string, scans: number) =>
    `Delete ${code}: ${plural(scans, "scan", "scans")} with landmarks, fits, plan, reports and every link that shows them?`,
  yes: "Delete",
  no: "Keep",
  going: (code: string) => `${code} will be deleted in ten seconds.`,
  undo: "Take it back",
  announceGone: (code: string) => `${code} is deleted.`,
};
