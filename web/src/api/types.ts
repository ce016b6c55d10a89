// The service's words under the names that the page uses; the shapes themselves are generated.
import type * as wire from "./types.gen";

export type {
  Caller,
  CarriedDrawing,
  Cut,
  CutPlane,
  Cuts,
  DrawingFile,
  DrawnShape,
  EventPage,
  EventRecord,
  Fit,
  FitLinks,
  FitRequest,
  GivenLength,
  Ink,
  InkShape,
  Iterated,
  LandmarkFile,
  LineChecks as Checks,
  Measure,
  Archived,
  MeasuresFile,
  Meta,
  MovedModel,
  NodePose,
  OwnDrawing,
  Patient,
  PatientPage,
  PatternHandle,
  PatternInfo,
  Lengths,
  PatternOnScan,
  PatternParameter,
  PatternQuestion,
  PlanLine,
  PlannedShape,
  PlanLesion,
  PlanNote,
  PlanOnScan,
  PlanPattern,
  PlanTumour,
  PredictionRequest,
  Problem,
  ProposedLandmark,
  ProposedLandmarks,
  ProposedMark,
  ProposedMarks,
  Scan,
  ScanImage,
  ScanVisit,
  Share,
  ShareMade,
  SharePage,
  SharedResult,
  ShareRequest,
  Started,
  SurfacePoint,
  TakenLesions,
  VisitsFile,
} from "./types.gen";

export type PlanItem = wire.StoredPlan["items"][number];
export type Vector = [number, number, number];
export type Unit = wire.Scan["unit"];
export type UnitChoice = wire.ScanUpload["units"] & string;
/** With the tag under which the service has them; null where it gives none. */
export type StoredLandmarks = wire.LandmarkFile & { readonly seen?: string | null };
export type StoredPlan = wire.StoredPlan & { readonly seen?: string | null };
export type Stance = wire.ResultFile["stance"];
export type StanceChoice = wire.Fit["stance"];
export type Frame = Pick<wire.Frame, "up" | "front">;
export type Question = NonNullable<wire.Problem["question"]>;
export type Segment = NonNullable<wire.Scan["segments"]>[number];
export type TakenAs = Segment["taken_as"];

/** What a person says of a volume where its file does not: which way it lies, what its segments are, which series it is, whether its lesions lie where the image does. */
export interface VolumeAnswers {
  readonly frame?: string;
  readonly series?: string;
  readonly same_place?: string;
  readonly segments?: Readonly<Record<number, TakenAs>>;
}

/** A scan from the example also brings the example's landmarks. */
export type ExampleScan = wire.Scan & Partial<Pick<wire.ExampleScan, "example_landmarks">>;
export type Example = wire.ExampleEntry;
export type LandmarkDefinition = wire.LandmarkInfo;
export type ModelShape = wire.ModelDrawnShape;
export type Result = wire.ResultFile;
export type Ended = Pick<wire.Failed, "reason">;
export interface Done {
  result: Result;
}
/** The side file has more; the page needs where the model's landmarks are. */
export type ModelSide = wire.ModelSide & {
  landmarks: (LandmarkDefinition & wire.SurfacePoint)[];
  skinning?: "linear" | "dual_quaternion" | "corrective"; // the last one is linear with further shapes
};
/** A rig: its file, and what is known of it. */
export interface Model {
  readonly glb: ArrayBuffer;
  readonly side: ModelSide;
}
