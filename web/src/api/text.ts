// What went wrong and what to do.

export const errors = {
  noService: "The service does not answer. Check that “breastrig serve” is running, then try again.",
  refused: (status: number) => `The service refused this (HTTP ${status}). Try again, or look at its log.`,
  tooLarge: "The file is larger than this service accepts.",
  notAScan: (name: string) => `“${name}” is not a 3D scan that can be read here: choose a PLY, OBJ, STL or GLB file, or a zip.`,
  noScan: "This scan is no longer kept by the service. Load it again.",
  mesh: "The scan cannot be drawn: the service sent a mesh that is not valid glTF.",
  model: "The model cannot be drawn: the service sent a file that is not the expected rig.",
  surface: "The fitted surface cannot be drawn: the service sent a file that does not belong to this fit.",
  noGraphics:
    "This browser offers no WebGL 2, so the body cannot be drawn. Turn on hardware acceleration or use another browser; the command line works without.",
  graphicsLost: "The graphics driver dropped this page's picture. It comes back by itself in most cases; if not, load the page again.",
  unexpected: (message: string) => `Something unexpected happened in the page (${message}). Your landmarks are kept.`,
};
