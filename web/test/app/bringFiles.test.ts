// Files that come together: one patient, each scan fitted by itself, landmarks where they lie, and nothing guessed.
import { afterEach, expect, test, vi } from "vitest";
import { ApiError, type UploadFields } from "../../src/api/client";
import type { Fit, FitRequest, Patient, Question, Scan } from "../../src/api/types";
import { bringing as words } from "../../src/app/text";
import { fitLinks, page, scanInfo } from "../fakes";

afterEach(() => vi.unstubAllGlobals());

const file = (name: string, content = "x"): File => new File([content], name);
const bounds = (low: number, high: number) => ({ bounds_m: { min: [low, low, low], max: [high, high, high] } }) as unknown as Partial<Scan>;
const landmarks = (x: number): string => JSON.stringify({ unit: "mm", landmarks: { nipple_L: [x, 100, 100] } });

/** A service that keeps what is uploaded under the file's name, of one patient where that is said. */
function service(about: Record<string, Partial<Scan>> = {}, fitsAtOnce = true) {
  const sent: [string, UploadFields][] = [];
  const upload = async (given: File, fields: UploadFields): Promise<Scan> => {
    sent.push([given.name, fields]);
    return { ...scanInfo(given.name), patient: fields.patient ?? "p", ...bounds(0, 1), ...about[given.name] };
  };
  const startFit = vi.fn(async ({ scan }: FitRequest) => ({ id: `fit of ${scan}`, links: fitLinks(`fit of ${scan}`), cuts: "" }));
  const scan = async (id: string) => ({ ...scanInfo(id), patient: "p", ...bounds(0, 1), ...about[id] });
  const patient = async (id: string) => ({ id, code: "K7M-4QX", scans: sent.map(([name]) => ({ id: name, stance: "standing", kind: "surface", created_at: "2026-11-25T09:00:00Z", thumbnail: "", fit: null })) }) as unknown as Patient;
  const fit = async (id: string) => ({ id, links: fitLinks(id), state: "running", drawing: null }) as unknown as Fit;
  const made = page({ upload, startFit, scan, patient, fit, allEvents: async () => [] });
  made.store.set({ fitsAtOnce });
  return { ...made, sent, startFit };
}

test("three files become one patient: the first scan on the page, the next beside it, the image on the strip, each fitted by itself", async () => {
  const { store, actions, sent, startFit } = service();
  await actions.bring.files([file("mri.nii.gz"), file("standing.ply"), file("supine.obj")]);
  expect(sent.map(([name, { patient }]) => [name, patient]), "the image comes last").toEqual([["standing.ply", undefined], ["supine.obj", "p"], ["mri.nii.gz", "p"]]);
  expect(startFit.mock.calls.map(([{ scan }]) => scan)).toEqual(["standing.ply", "supine.obj", "mri.nii.gz"]);
  expect(store.get()).toMatchObject({ scan: { info: { id: "standing.ply" } }, stances: { isComparing: true, isSecond: false, other: { scan: { info: { id: "supine.obj" } }, fit: { id: "fit of supine.obj" } } } });
  expect(store.get().stances.scans.map(({ id }) => id)).toEqual(["standing.ply", "supine.obj", "mri.nii.gz"]);
  expect(store.get().problems).toEqual({});
});

test("a size that may be wrong is asked about before anything is fitted; who says that it is right has it fitted", async () => {
  const doubt = { size_doubt: "The body would be 53 m tall." } as Partial<Scan>;
  const { actions, startFit } = service({ "a.ply": doubt, "b.ply": doubt });
  await actions.bring.files([file("a.ply"), file("b.ply")]);
  expect(startFit).not.toHaveBeenCalled();
  actions.bring.sizeIsRight();
  await vi.waitFor(() => expect(startFit.mock.calls.map(([{ scan }]) => scan)).toEqual(["a.ply"]));
});

test("who wishes so fits when it is time, not at once", async () => {
  const { actions, startFit } = service({}, false);
  await actions.bring.files([file("a.ply"), file("b.ply")]);
  expect(startFit).not.toHaveBeenCalled();
});

test("landmarks go to the one scan that they lie on; where that may be several, or none, they are not taken, and it is said", async () => {
  const { store, client, actions } = service({ "a.ply": bounds(0, 0.3), "b.ply": bounds(1, 2) }, false);
  await actions.bring.files([file("a.ply"), file("b.ply"), file("of_a.json", landmarks(200))]);
  expect(store.get().picks.present).toEqual({ nipple_L: [200, 100, 100] });
  const both = service({}, false);
  await both.actions.bring.files([file("a.ply"), file("b.ply"), file("either.json", landmarks(200)), file("note.txt~")]);
  expect(both.store.get().picks.present).toEqual({});
  expect(both.client.saveLandmarks).not.toHaveBeenCalled();
  expect(both.store.get().problems.scan).toBe(`${words.notTaken(1)} ${words.unplaced(1)}`);
  expect(client.saveLandmarks).not.toHaveBeenCalledWith(expect.objectContaining({ id: "b.ply" }), expect.anything(), expect.anything());
});

test("landmarks alone go to the scan on the page; nothing that can be read is said, and nothing is left", async () => {
  const { store, actions, sent } = service({}, false);
  await actions.bring.files([file("a.ply")]);
  await actions.bring.files([file("picks.json", landmarks(5))]);
  expect(store.get().picks.present).toEqual({ nipple_L: [5, 100, 100] });
  await actions.bring.files([file("skin.jpg"), file("body.mtl")]);
  expect(sent.map(([name]) => name)).toEqual(["a.ply"]);
  expect(store.get().problems.scan).toBe(words.none(2));
});

test("of a further scan, too, the side is asked; called off, it is not added", async () => {
  const question = { problem: "Which side is left?", field: "frame", choices: [{ value: "RAS", text: "left" }] } as unknown as Question;
  const said: UploadFields[] = [];
  const upload = async ({ name }: File, fields: UploadFields): Promise<Scan> => {
    said.push(fields);
    if (name.endsWith(".nii.gz") && fields.frame === undefined) throw new ApiError("say which it is", 422, question);
    return { ...scanInfo(name), ...bounds(0, 1) };
  };
  const { store, actions } = page({ upload });
  const going = actions.bring.files([file("a.ply"), file("mri.nii.gz")]);
  await vi.waitFor(() => expect(store.get().asked).toBe(question));
  actions.scan.answer(null);
  await going;
  expect(said).toHaveLength(2);
  expect(store.get()).toMatchObject({ scan: { info: { id: "a.ply" } }, problems: {} });
});

const dicom = (name: string, uid: string): File => file(name, `${"\0".repeat(128)}DICM${"\0".repeat(40)}${uid}\0`);
const SEG = "1.2.840.10008.5.1.4.1.1.66.4";
const SLICE = "1.2.840.10008.5.1.4.1.1.4";
const image = { shape: [2, 2, 2], to_scan: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], bytes: 8 } as unknown as NonNullable<Scan["image"]>;

/** A service whose images take files of lesions. */
function withImages(about: Record<string, Partial<Scan>>, asks: Question | null = null) {
  const made = service(about, false);
  const taken: [string, string, string | undefined][] = [];
  const addLesions = vi.fn(async (scan: Scan, given: File, { same_place: same }: { same_place?: string }) => {
    if (asks && same === undefined) throw new ApiError(`${asks.problem}.`, 422, asks);
    taken.push([scan.id, given.name, same]);
    return { lesions: [{ name: "Lesion 1", new: true }], segments: [], notes: ["Assumed."] };
  });
  Object.assign(made.client, { addLesions });
  return { ...made, taken };
}

test("a segmentation that comes with an image is drawn on it: its lesions go there, and it is no scan", async () => {
  const { store, actions, sent, taken } = withImages({ "mri.zip": { image } });
  await actions.bring.files([dicom("tumour.dcm", SEG), file("mri.zip"), file("standing.ply")]);
  expect(sent.map(([name]) => name)).toEqual(["standing.ply", "mri.zip"]);
  expect(taken).toEqual([["mri.zip", "tumour.dcm", undefined]]);
  expect(store.get().lesionFiles["mri.zip"]).toMatchObject({ notes: ["Assumed."] });
  expect(store.get().problems).toEqual({});
  await actions.bring.files([file("mri.zip")]);
  await actions.bring.files([dicom("second.dcm", SEG)]);
  expect(taken.at(-1), "alone it goes to the image of the patient on the page").toEqual(["mri.zip", "second.dcm", undefined]);
});

test("without an image a segmentation is a scan; with several nobody guesses which", async () => {
  const { actions, sent } = withImages({});
  await actions.bring.files([dicom("body.dcm", SEG), file("standing.ply")]);
  expect(sent.map(([name]) => name)).toEqual(["standing.ply", "body.dcm"]);
  const two = withImages({ "a.zip": { image }, "b.zip": { image } });
  await two.actions.bring.files([file("a.zip"), file("b.zip"), dicom("tumour.dcm", SEG)]);
  expect(two.taken).toEqual([]);
  expect(two.store.get().problems.scan).toBe(words.noImage(2));
});

test("a volume that is no scan is tried as lesions of the image beside it, whichever came first; what neither is says why not", async () => {
  const refused = new ApiError("This label map shows no body.", 422);
  const made = withImages({ "mri.nii.gz": { image } });
  const upload = made.client.upload;
  Object.assign(made.client, { upload: (given: File, ...rest: [UploadFields, () => void]) => (given.name === "lesion.nii.gz" ? Promise.reject(refused) : upload(given, ...rest)) });
  await made.actions.bring.files([file("lesion.nii.gz"), file("mri.nii.gz")]);
  expect(made.taken).toEqual([["mri.nii.gz", "lesion.nii.gz", undefined]]);
  expect(made.store.get()).toMatchObject({ scan: { info: { id: "mri.nii.gz" } }, problems: {} });
  Object.assign(made.client, { addLesions: () => Promise.reject(new ApiError("No segment of this file is a lesion.", 422)) });
  await made.actions.bring.files([file("mri.nii.gz"), file("lesion.nii.gz")]);
  expect(made.store.get().problems.scan).toBe("This label map shows no body. No segment of this file is a lesion.");
});

test("whether lesions lie in the image is asked; called off, none are taken", async () => {
  const question = { problem: "Another frame", field: "same_place", choices: [{ value: "yes", text: "They do" }] } as unknown as Question;
  for (const [answer, expected] of [["yes", [["mri.zip", "tumour.dcm", "yes"]]], [null, []]] as const) {
    const { store, actions, taken } = withImages({ "mri.zip": { image } }, question);
    const brought = actions.bring.files([file("mri.zip"), dicom("tumour.dcm", SEG)]);
    await vi.waitFor(() => expect(store.get().asked).toEqual(question));
    actions.scan.answer(answer);
    await brought;
    expect(taken).toEqual(expected);
  }
});

test("files that come before the service has said what it takes are all sent", async () => {
  const { store, actions, sent } = withImages({ "mri.zip": { image } });
  store.set({ meta: null });
  await actions.bring.files([dicom("tumour.dcm", SEG), file("mri.zip"), file("standing.ply")]);
  expect(sent.map(([name]) => name)).toEqual(["standing.ply", "mri.zip"]);
});

test("slices by themselves are not sent one by one", async () => {
  const { store, actions, sent } = withImages({});
  await actions.bring.files(Array.from({ length: 20 }, (_, k) => dicom(`I${k}`, SLICE)));
  expect([sent, store.get().problems.scan]).toEqual([[], words.slices]);
});
