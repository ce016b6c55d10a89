// Every English sentence of the page, in one place, ready for translation.
// Names and definitions of landmarks, shapes and drawings come from the model, notes and reasons from the service.
import { plainLabel, sideOf } from "./state/landmarks";
import type { Overlay, Step, Theme, ViewName } from "./state/session";

const plural = (count: number, one: string, many: string): string => `${count} ${count === 1 ? one : many}`;

export const text = {
  name: "BreastRig",
  notice: "Research use only. Not a medical device.",
  noticeLong:
    "Research use only. Not a medical device; not for diagnosis, treatment or surgical decisions. " +
    "Measurements carry scanner and fitting error.",
  version: (version: string) => `version ${version}`,

  steps: { scan: "Scan", landmarks: "Landmarks", fit: "Fit", result: "Result" } satisfies Record<Step, string>,
  stepsLabel: "Steps",
  dismiss: "Dismiss",
  close: "Close",

  top: {
    newScan: "New scan",
    theme: (theme: Theme) => ({ system: "Theme: as the system", light: "Theme: light", dark: "Theme: dark" })[theme],
    help: "Keyboard and mouse",
    uploaded: "Uploaded scan",
  },

  empty: {
    title: "Drop a 3D scan of the torso here",
    formats: "PLY, OBJ, STL, GLB, or a zip with OBJ, MTL and image.",
    limit: (megabytes: string) => `Up to ${megabytes} MB.`,
    choose: "Choose a scan file",
    units: "Unit of the file",
    or: "No scan at hand? These are one click away:",
    lines: [
      "BreastRig fits a rigged model of the torso to a 3D scan and shows it settle, live.",
      "Reference surgical drawings come along and lie on the patient's skin.",
      "The scan stays with this service; no names are asked for and none are kept.",
    ],
    drop: "Let go to load this scan",
  },

  units: {
    auto: "Find out from the size",
    mm: "Millimetres",
    cm: "Centimetres",
    dm: "Decimetres",
    m: "Metres",
    in: "Inches",
  },

  loading: {
    sending: (title: string) => `Sending ${title}`,
    preparing: (title: string) => `Reading and checking ${title}`,
  },

  scan: {
    before: "A 3D scan of the torso, standing or lying down.",
    triangles: "Triangles",
    size: "Size",
    sizeValue: (w: string, h: string, d: string) => `${w} × ${h} × ${d}`,
    unit: "Unit",
    stance: "Stance",
    stances: { auto: "Decide from the scan", standing: "Standing", supine: "Supine" },
    facingFrom: { landmarks: "Upright by its landmarks.", person: "Turned by you." },
    wrongWay: "Not upright and facing you?",
    turns: { around: "Turn", sideways: "Roll", forwards: "Tip" },
    turnHints: {
      around: "Turn the body by 90° about its long axis",
      sideways: "Roll the body by 90° in the plane of the picture",
      forwards: "Tip the body forwards by 90°",
    },
    colours: "Show the scan's own colours",
    readAgain: "Wrong unit? Read the file as",
    other: "Load another scan",
    ruler: "30 cm",
    summary: (triangles: string) => `${triangles} triangles`,
  },

  landmarks: {
    before: "Up to twelve clicks on the body; three are enough to start.",
    /** "nipple, patient's left": as it stands inside a sentence */
    spoken({ name, label }: { name: string; label: string }): string {
      const plain = plainLabel(label);
      const side = { left: ", patient's left", right: ", patient's right", middle: "" }[sideOf(name)];
      return plain.charAt(0).toLowerCase() + plain.slice(1) + side;
    },
    progress: (placed: number, all: number) => `${placed}/${all}`,
    sides: { left: "patient's LEFT", right: "patient's RIGHT", middle: "midline" },
    sideWords: { left: "LEFT", right: "RIGHT", middle: "" },
    sideShort: { left: "L", right: "R", middle: "" },
    placed: "placed",
    skippedState: "skipped",
    missing: "not placed",
    wrongSide: (label: string) =>
      `Are left and right swapped? The point for “${label}” lies on the other side of the body than its partner.`,
    skip: "Skip",
    remove: (label: string) => `Remove ${label}`,
    undo: "Undo",
    redo: "Redo",
    stop: "Stop placing",
    importFile: "Import",
    importHint: "Read landmarks from a JSON or CSV file",
    exportJson: "JSON",
    exportCsv: "CSV",
    exportHint: (kind: string) => `Save the placed landmarks as ${kind}`,
    useExample: "Use the example's landmarks",
    clear: "Clear all",
    saved: "Saved",
    saving: "Saving …",
    unsaved: "Not saved yet",
    again: "Try again",
    how: "A click on the body places the point, dragging turns the view.",
    guideTitle: "Place this point",
    guideCaption: "Shown on the model",
    announcePlaced: (label: string, next: string | null) =>
      next === null ? `Placed: ${label}. All landmarks are done.` : `Placed: ${label}. Next: ${next}.`,
    announceUndone: "Undone.",
    announceRedone: "Redone.",
    announceImported: (count: number) => `${plural(count, "landmark", "landmarks")} read.`,
  },

  proposals: {
    looking: "Looking for the landmarks on this scan …",
    found: (count: number) => `${plural(count, "proposal", "proposals")}, shown dashed; none is used before you confirm it.`,
    doubtful: (count: number) =>
      count === 1 ? "One is a rough guess: check it by itself." : `${count} are rough guesses: check each.`,
    none: (reason: string) => `No proposals: ${reason}`,
    late: "The service is still busy with it.",
    again: "Ask again",
    confirmAll: (count: number) => `Confirm all ${count}`,
    confirm: (label: string) => `Confirm the proposed ${label}`,
    confirmLikely: (count: number) => (count === 1 ? "Confirm the likely point" : `Confirm the ${count} likely points`),
    error: (mm: string) => `±\u00a0${mm}\u00a0mm`,
    errorHint: (mm: string) => `The proposal is expected to be about ${mm} mm off.`,
    offScan: "no skin there",
    offScanHint: "The scan shows no skin here: the model alone says where it would be.",
    take: (mm: string) => `Take the proposal, ±\u00a0${mm}\u00a0mm`,
    rowState: (mm: string) => `proposed, about ${mm} millimetres off`,
    announceFound: (count: number) => `${plural(count, "landmark is", "landmarks are")} proposed.`,
    announceConfirmed: (labels: readonly string[]) =>
      labels.length === 1 ? `Confirmed: ${labels[0]}.` : `${labels.length} proposed landmarks confirmed.`,
  },

  fit: {
    before: "The model settles on the scan within seconds, drawing included.",
    stance: "Stance",
    drawing: "Drawing",
    preset: "Settings",
    presets: { default: "Best known (default)", paper: "As in the paper" } as Record<string, string>,
    refine: "Follow the skin exactly",
    refineHint: "After the fit the model's surface bends smoothly onto the scan where it shows skin; bones and shapes stay as fitted.",
    cancel: "Cancel the fit",
    waiting: "Waiting for a free worker …",
    running: "Fitting …",
    stage: "Stage",
    retrying: "The connection to the service broke; trying again. The fit goes on meanwhile.",
    cancelled: "Cancelled. The iterations so far can still be looked at.",
    noLandmarks: "Without landmarks the fit has to find its start alone: that works best upright and facing front.",
    fewLandmarks: (count: number) => `With only ${plural(count, "landmark", "landmarks")} the start is found from the scan alone.`,
    with: (count: number) => `Fit with ${plural(count, "landmark", "landmarks")}`,
    without: "Fit without landmarks",
    again: (count: number) => (count === 0 ? "Fit again without landmarks" : `Fit again with ${plural(count, "landmark", "landmarks")}`),
    summary: (mean: string) => `${mean} mm`,
    announceStarted: "The fit has started.",
    announceStage: (stage: string) => `Stage ${stage}.`,
    announceDone: (mean: string) => `The fit is done: mean distance ${mean} millimetres.`,
  },

  result: {
    before: "Numbers, drawing and files for download.",
    save: "Download the fitted model",
    files: "Files",
    doubts: "Check these landmarks",
    drawing: "Drawing on the scan",
    noDrawing: "No drawing was asked for.",
    shapeNote: "Dashed where the scan has a hole.",
    downloads: [
      { key: "fitted_glb", name: "fitted.glb", what: "posed rig, drawing, replay" },
      { key: "fitted_ply", name: "fitted.ply", what: "posed model, scan's frame" },
      { key: "drawing", name: "drawing.json", what: "lines on the scan" },
      { key: "result", name: "result.json", what: "numbers and parameters" },
    ] as const,
  },

  numbers: {
    title: "Numbers",
    before: "They appear here while the model is being fitted.",
    live: "This iteration",
    surface: "Model to scan",
    surfaceHint: "From each model vertex with an accepted partner to the scan's surface",
    scanToModel: "Scan to model",
    scanToModelHint: "From each scan point within the model's reach to the fitted surface",
    landmarks: "Landmarks",
    landmarksHint: "From the model's landmark to the picked one",
    run: "Run",
    mean: "mean",
    std: "std",
    p95: "95 %",
    max: "max",
    meanDistance: "mean distance",
    landmarkDistance: "landmark mean",
    coverage: "coverage",
    coverageHint: "Share of the model's vertices that have a partner on the scan",
    iteration: "iteration",
    iterations: "iterations",
    stage: "stage",
    stance: "stance",
    elapsed: "elapsed",
    solve: "solve time",
    total: "total time",
    stop: "stopped because",
    curve: "Mean distance over the iterations",
    noLandmarks: "None were given.",
    each: "Each landmark",
  },

  timeline: {
    label: "Iteration",
    position: (shown: string, last: string) => `${shown} / ${last}`,
    mean: (mm: string) => `mean ${mm} mm`,
    replay: "Replay",
    play: "Play",
    pause: "Pause",
  },

  view: {
    label: "View",
    names: { front: "Front", left: "Left", right: "Right", back: "Back", top: "Top" } satisfies Record<ViewName, string>,
    hints: {
      front: "From the front (F)",
      left: "From the patient's left",
      right: "From the patient's right",
      back: "From behind",
      top: "From above the head",
    } satisfies Record<ViewName, string>,
    overlayLabel: "Show",
    overlays: { scan: "Scan", both: "Both", model: "Model" } satisfies Record<Overlay, string>,
    canvas: "3D view of the scan. Drag to turn it, scroll to zoom, drag with the right button to move it.",
    left: "patient's left",
    right: "patient's right",
  },

  next: {
    start: (label: string) => `Place ${label}`,
    armed: (label: string) => `Click on ${label}`,
  },

  help: {
    title: "Keyboard and mouse",
    keys: [
      ["1 – 4", "Go to a step"],
      ["N", "Next landmark"],
      ["Z · Shift+Z", "Undo · redo"],
      ["C", "Take the proposed point"],
      ["Esc", "Stop placing"],
      ["F", "View from the front"],
      ["O", "Scan, both or model"],
      ["Space", "Replay the fit"],
      ["?", "This list"],
    ],
    mouse: [
      ["Click", "Place the wanted landmark, or confirm a dashed one"],
      ["Drag", "Turn the view"],
      ["Right drag", "Move the view"],
      ["Scroll", "Zoom"],
      ["Touch", "One finger turns, two move and zoom, a tap places"],
    ],
  },

  errors: {
    noService: "The service does not answer. Check that “breastrig serve” is running, then try again.",
    refused: (status: number) => `The service refused this (HTTP ${status}). Try again, or look at its log.`,
    tooLarge: "The file is larger than this service accepts.",
    notAScan: (name: string) => `“${name}” is not a 3D scan that can be read here: choose a PLY, OBJ, STL or GLB file, or a zip.`,
    noScan: "This scan is no longer kept by the service. Load it again.",
    mesh: "The scan cannot be drawn: the service sent a mesh that is not valid glTF.",
    model: "The model cannot be drawn: the service sent a file that is not the expected rig.",
    noGraphics:
      "This browser offers no WebGL 2, so the body cannot be drawn. Turn on hardware acceleration or use another browser; the command line works without.",
    graphicsLost: "The graphics driver dropped this page's picture. It comes back by itself in most cases; if not, load the page again.",
    unexpected: (message: string) => `Something unexpected happened in the page (${message}). Your landmarks are kept.`,
  },
};
