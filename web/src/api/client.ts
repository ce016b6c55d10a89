// One function per route.  Whatever goes wrong becomes an ApiError whose message a person can act on.
import * as text from "./text";
import type { Checks,
  Cut,
  Cuts,
  DrawingFile,
  EventPage,
  EventRecord,
  Example,
  ExampleScan,
  Fit,
  FitLinks,
  FitRequest,
  GivenLength,
  Ink,
  LandmarkFile,
  Archived,
  MeasuresFile,
  Meta,
  Model,
  ModelSide,
  Patient,
  MovedModel,
  PatientPage,
  Lengths,
  PatternOnScan,
  PatternQuestion,
  PlanItem,
  PlanOnScan,
  PredictionRequest,
  Problem,
  ProposedLandmarks, ProposedMarks,
  Question,
  Result,
  Scan,
  Share,
  ShareMade,
  SharePage,
  ShareRequest,
  StoredLandmarks,
  StoredPlan,
  TakenLesions,
  UnitChoice,
  Vector,
  ScanVisit,
  VisitsFile,
  VolumeAnswers,
} from "./types";

/** What is sent with a scan's file: its unit, for which model, of which patient where it is no new one. */
export interface UploadFields extends VolumeAnswers {
  readonly units: UnitChoice;
  readonly model: string | undefined;
  readonly patient?: string | undefined;
  readonly group?: string | undefined; // that a new patient belongs to
  readonly again?: "true" | undefined; // the patient has this file already, and shall have it twice
}

export class ApiError extends Error {
  constructor(
    message: string,
    readonly status: number,
    readonly question: Question | null = null, // what a person has to say before it is taken
  ) {
    super(message);
  }
}

let whenSignedOut: () => void = () => undefined;

/** Called when the service no longer knows who asks: the session has ended, or somebody signed out in another tab. */
export function onSignedOut(action: () => void): void {
  whenSignedOut = action;
}

/** The service's own sentence where it sent one. */
function problemOf(status: number, body: string): ApiError {
  try {
    const problem = JSON.parse(body) as Partial<Problem>;
    const sentence = problem.detail ?? problem.title;
    if (sentence) return new ApiError(problem.errors?.length ? text.notTaken(sentence) : sentence, status, problem.question ?? null);
  } catch {
    // not JSON: a proxy or a crash answered, and its page would help nobody
  }
  return new ApiError(status === 413 ? text.tooLarge : text.refused(status), status);
}

export async function ask(path: string, request: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, request);
  } catch {
    throw new ApiError(text.noService, 0);
  }
  if (answer.status === 401) whenSignedOut();
  if (!answer.ok) throw problemOf(answer.status, await answer.text());
  return answer;
}

export async function askJson<Body>(path: string, method = "GET", body?: unknown, keepalive = false): Promise<Body> {
  const request: RequestInit = { method, keepalive }; // kept alive: arrives although the page is being closed
  if (body !== undefined) {
    request.body = JSON.stringify(body);
    request.headers = { "Content-Type": "application/json" };
  }
  return (await (await ask(path, request)).json()) as Body;
}

const bytes = async (path: string): Promise<ArrayBuffer> => (await ask(path)).arrayBuffer();
const id = encodeURIComponent;

// A scan changes with its size alone, and no browser keeps what shows a patient: the last two, both stances of one patient, stay in memory.
const KEPT_MESHES = 2;
const meshes = new Map<string, Promise<ArrayBuffer>>();

function mesh({ links, scale }: Scan): Promise<ArrayBuffer> {
  const key = `${links.mesh} ${scale?.factor ?? 1}`;
  const found = meshes.get(key) ?? bytes(links.mesh);
  meshes.delete(key);
  meshes.set(key, found); // the one that was asked for last stands last
  for (const link of [...meshes.keys()].slice(0, -KEPT_MESHES)) meshes.delete(link);
  found.catch(() => meshes.delete(key));
  return found;
}

const KEPT_ALIVE_BYTES = 60_000; // the standard allows 64 kB for all of a page together

/** Proxies that compress make the tag a weak one. */
const tagged = async <Stored>(answer: Response): Promise<Stored & { readonly seen: string | null }> => ({
  ...((await answer.json()) as Stored),
  seen: /^(?:W\/)?"(.*)"$/.exec(answer.headers.get("ETag") ?? "")?.[1] ?? null,
});

const tagging = (seen: string | null): Record<string, string> => ({ "Content-Type": "application/json", ...(seen === null ? {} : { "If-Match": `"${seen}"` }) });

export const client = {
  /** With what the model of that name has; without a name with what the first one has. */
  meta: (model?: string) => askJson<Meta>(model === undefined ? "/api/meta" : `/api/meta?model=${id(model)}`),
  examples: async () => (await askJson<{ examples: Example[] }>("/api/examples")).examples,
  importExample: (name: string, group = "") => askJson<ExampleScan>(`/api/examples/${id(name)}${group === "" ? "" : `?group=${id(group)}`}`, "POST"),
  model: async (sha256: string): Promise<Model> => {
    const place = `/api/models/${id(sha256)}`;
    const [glb, side] = await Promise.all([bytes(`${place}/torso.glb`), askJson<ModelSide>(`${place}/torso.json`)]);
    return { glb, side };
  },
  scan: (scan: string) => askJson<ExampleScan>(`/api/scans/${id(scan)}`),
  /** With all that was made of it; arrives although the page is being closed. */
  deleteScan: async (scan: Scan): Promise<void> => {
    meshes.clear();
    await ask(scan.links.self, { method: "DELETE", keepalive: true });
  },
  /** The newest first; `address` is that of a further page. */
  patients: (address: string | null, search: string, order: "newest" | "code" | "deletion") =>
    askJson<PatientPage>(address ?? `/api/patients?limit=50&sort=${order}${search === "" ? "" : `&search=${id(search)}`}`),
  patient: (patient: string) => askJson<Patient>(`/api/patients/${id(patient)}`),
  giveToGroup: (patient: string, group: string | null) => askJson<Patient>(`/api/patients/${id(patient)}/group`, "PUT", { group }),
  renamePatient: (patient: string, code: string) => askJson<Patient>(`/api/patients/${id(patient)}`, "PATCH", { code }),
  deletePatient: async (patient: string): Promise<void> => {
    meshes.clear();
    await ask(`/api/patients/${id(patient)}`, { method: "DELETE", keepalive: true });
  },
  mesh,
  /** Grey values of its image, i fastest; kept nowhere. */
  volume: ({ links }: Scan) => bytes(links.volume ?? `${links.self}/volume`),
  /** Into the plan, of a file that was drawn on the scan's image. */
  addLesions: async (scan: Scan, file: File, answers: VolumeAnswers): Promise<TakenLesions> =>
    (await (await ask(`${scan.links.self}/lesions`, { method: "POST", body: formOf(file, answers) })).json()) as TakenLesions,
  /** What a file says of the scan's landmarks; nothing of it is kept yet. */
  landmarkFile: async (scan: Scan, file: File): Promise<LandmarkFile> => {
    const body = new FormData();
    body.append("file", file);
    return (await (await ask(`${scan.links.landmarks}/file`, { method: "POST", body })).json()) as LandmarkFile;
  },
  writeLandmarks: async (scan: Scan, kind: string, file: LandmarkFile): Promise<Blob> =>
    (await ask(`${scan.links.landmarks}/file/${kind}`, { method: "POST", body: JSON.stringify(file), headers: tagging(null) })).blob(),
  landmarks: async (scan: Pick<Scan, "id" | "links">): Promise<StoredLandmarks> => tagged(await ask(scan.links.landmarks)),
  /** 412 when those that are kept are not the ones of this tag any more; without one they are replaced whatever they are.  Arrives although the page is being closed. */
  saveLandmarks: async (scan: Pick<Scan, "id" | "links">, file: LandmarkFile, seen: string | null): Promise<StoredLandmarks> => {
    return tagged(await ask(scan.links.landmarks, { method: "PUT", body: JSON.stringify(file), headers: tagging(seen), keepalive: true }));
  },
  cuts: (scan: Pick<Scan, "id" | "links">) => askJson<Cuts>(scan.links.cuts),
  /** 412 when those that are kept are not the ones of this digest any more. */
  saveCuts: async (scan: Pick<Scan, "id" | "links">, cuts: readonly Cut[], seen: string): Promise<Cuts> => {
    const body = JSON.stringify({ cuts });
    return (await (await ask(scan.links.cuts, { method: "PUT", body, headers: tagging(seen), keepalive: body.length < KEPT_ALIVE_BYTES })).json()) as Cuts;
  },
  /** Its true size by a straight length that was measured on the patient. */
  putLength: (scan: Scan, length: GivenLength) => askJson<Scan>(`${scan.links.self}/length`, "PUT", length),
  /** The size of its file again. */
  deleteLength: (scan: Scan) => askJson<Scan>(`${scan.links.self}/length`, "DELETE"),
  /** The scan's model is the right one. */
  sayModel: ({ links, model }: Pick<Scan, "links" | "model">) => askJson<Scan>(`${links.self}/model`, "PUT", { model }),
  /** 202 means: still looking, ask again in so many seconds. */
  async proposed(scan: Scan): Promise<ProposedLandmarks | { retryAfterS: number }> {
    const answer = await ask(scan.links.proposed);
    if (answer.status !== 202) return (await answer.json()) as ProposedLandmarks;
    return { retryAfterS: Number(answer.headers.get("Retry-After")) || 1 };
  },
  /** Lines drawn on the skin; 202 as above. */
  async ink(scan: Scan): Promise<Ink | { retryAfterS: number }> {
    const answer = await ask(scan.links.ink);
    if (answer.status !== 202) return (await answer.json()) as Ink;
    return { retryAfterS: Number(answer.headers.get("Retry-After")) || 1 };
  },
  /** By their names, whether lines of ink are none of the plan; arrives although the page is being closed. */
  dropInk: (scan: Scan, dropped: Readonly<Record<string, boolean>>) => askJson<Ink>(scan.links.ink, "PATCH", { dropped }, true),
  /** Where the model of a fit lies with these picks (mm): for a drag, kept nowhere. */
  moved: (links: FitLinks, landmarks: Record<string, Vector>) => askJson<MovedModel>(links.moved, "POST", { landmarks }),
  /** Which landmarks are worth checking by a person, and how much surer that makes the lines. */
  checks: (link: string) => askJson<Checks>(link),
  checksOf: (fit: string) => askJson<Checks>(`/api/fits/${id(fit)}/checks`),
  /** One page of the printed report as a picture, and how many there are. */
  reportPage: async (report: string, page: number): Promise<{ readonly picture: Blob; readonly count: number }> => {
    const answer = await ask(`${report.replace("report.pdf", "report.png")}${report.includes("?") ? "&" : "?"}page=${page}`);
    return { picture: await answer.blob(), count: Number(answer.headers.get("Page-Count") ?? page) };
  },
  /** A file that the service makes of the plan, beside the report; an ApiError says why it cannot. */
  madeOfPlan: async (report: string, name: string): Promise<{ readonly blob: Blob; readonly name: string }> => {
    const answer = await ask(report.replace("report.pdf", name));
    return { blob: await answer.blob(), name: /filename=([\w.-]+)/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1] ?? name };
  },
  /** Sends a fit to one of the archives that the service names; what the archive noted. Some seconds. */
  toArchive: async (report: string, archive: string): Promise<string> =>
    (await askJson<Archived>(report.replace("report.pdf", "archive"), "POST", { archive })).notes.join(" "),
  startFit: (request: FitRequest) => askJson<Pick<Fit, "id" | "links"> & Partial<Pick<Fit, "cuts">>>("/api/fits", "POST", request),
  fit: (fit: string) => askJson<Fit>(`/api/fits/${id(fit)}`),
  /** Marks that the colours of two fits' scans show, for a person to accept; some seconds. */
  proposeMarks: (from: string, to: string) => askJson<ProposedMarks>("/api/transfers/marks", "POST", { from_fit: from, to_fit: to }),
  /** Predicts a stance that was not scanned; the same prediction is made once. */
  predict: (link: string, request: PredictionRequest) => askJson<Pick<Fit, "id" | "links">>(link, "POST", request),
  cancel: (link: string) => askJson<Fit>(link, "POST"),
  /** All events so far; `link` is that of the stream. */
  async allEvents(link: string): Promise<EventRecord[]> {
    const events: EventRecord[] = [];
    for (let next: string | null = `${link}.json?limit=1000`; next !== null; ) {
      const page: EventPage = await askJson<EventPage>(next);
      events.push(...page.events);
      next = page.next;
    }
    return events;
  },
  result: (link: string) => askJson<Result>(link),
  drawing: (link: string) => askJson<DrawingFile>(link),
  plan: async (link: string): Promise<StoredPlan> => tagged(await ask(link)),
  planVersion: (link: string, version: number) => askJson<StoredPlan>(`${link}/versions/${version}`),
  /** 412 when the plan is not the one that was `seen` any more.  Browsers keep a request alive beyond its page only when it is small. */
  async savePlan(link: string, items: readonly PlanItem[], seen: string | null, sizes: ReadonlyMap<string, number> = new Map()): Promise<StoredPlan> {
    const scans = [...new Set(items.map(({ scan }) => scan ?? ""))].filter((scan) => sizes.has(scan)).map((scan) => ({ id: scan, scale: sizes.get(scan) }));
    const body = JSON.stringify({ items, scans });
    const headers = tagging(seen);
    return tagged(await ask(link, { method: "PUT", body, headers, keepalive: body.length < KEPT_ALIVE_BYTES }));
  },
  /** The whole plan on the scan of a fit, carried there where it was made on another scan. */
  planOnFit: (link: string) => askJson<PlanOnScan>(link),
  /** Along the fitted skin, from each place to the next, mm. */
  lengths: (fit: string, places: readonly Vector[]) => askJson<Lengths>(`${fit}/lengths`, "POST", { places }),
  /** A pattern with its handles on the scan of a fit, as it is or as a drag makes it; nothing is stored. */
  pattern: (fit: string, question: PatternQuestion) => askJson<PatternOnScan>(`${fit}/pattern`, "POST", question),
  /** The scan is that patient's from now on, or a new one's; `sameAs`: of these scans of the patient a person has stated that it shows the same patient. */
  moveScan: (scan: string, patient: string | null, sameAs: readonly string[] = []) => askJson<Patient>(`/api/scans/${id(scan)}/patient`, "PUT", { patient, same_as: sameAs }),
  /** The day of each scan of a patient. */
  visits: (patient: string) => askJson<{ readonly scans: readonly ScanVisit[] }>(`/api/patients/${id(patient)}/visits`),
  putVisit: (scan: string, date: string | null, label: string) => askJson<ScanVisit>(`/api/scans/${id(scan)}/visit`, "PUT", { date, label }),
  visitsFile: (patient: string) => askJson<VisitsFile>(`/api/patients/${id(patient)}/visits.json`),
  measures: (link: string, other: string | null) => askJson<MeasuresFile>(other === null ? link : `${link}?with=${id(other)}`),
  shares: (link: string) => askJson<SharePage>(link),
  makeShare: (link: string, request: ShareRequest) => askJson<ShareMade>(link, "POST", request),
  unlockShare: (link: string) => askJson<Share>(link, "POST"),
  refreshShare: (link: string) => askJson<Share>(link, "POST"),
  revokeShare: async (link: string): Promise<void> => {
    await ask(link, { method: "DELETE" });
  },
  /** Whether there is a session to end: the sign-in page then offers to. */
  async isSignedIn(): Promise<boolean> {
    const page = new DOMParser().parseFromString(await (await ask("/sign-in")).text(), "text/html");
    return page.querySelector('form[action="/sign-out"]') !== null;
  },
  /** Somebody is at the page. */
  stay: async (): Promise<void> => {
    await ask("/api/session", { method: "PUT" });
  },
  signOut: async (): Promise<void> => {
    await ask("/sign-out", { method: "POST" });
  },
  bytes,
  upload,
};

export type Client = typeof client;

function formOf(file: File, { segments, ...words }: VolumeAnswers): FormData {
  const form = new FormData();
  for (const [name, value] of Object.entries(words) as [string, string | undefined][]) if (value !== undefined) form.append(name, value);
  if (segments !== undefined) form.append("segments", JSON.stringify(segments));
  form.append("file", file);
  return form;
}

/** Sends a scan; `progress` gets the share that has left this machine (fetch does not report it, hence XMLHttpRequest). */
function upload(file: File, said: UploadFields, progress: (share: number) => void): Promise<Scan> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", "/api/scans");
    request.upload.onprogress = (event) => {
      if (event.lengthComputable) progress(event.loaded / event.total);
    };
    request.onload = () => {
      if (request.status >= 200 && request.status < 300) resolve(JSON.parse(request.responseText) as Scan);
      else if (request.status === 401) whenSignedOut();
      else reject(problemOf(request.status, request.responseText));
    };
    request.onerror = () => reject(new ApiError(text.noService, 0));
    request.send(formOf(file, said));
  });
}
