// The rooms of the page, from the ground up.  A room imports itself and the rooms before it, never one after it; no file
// is part of a circle, types included.  `npm run lint` checks it; README.md says what each room is for.
const ROOMS = ["languages", "api", "store", "ui", "viewer", "scan", "landmarks", "fit", "drawing", "plan", "stances", "checks", "ink", "patients", "share", "app"];

/** Words and state, and what is plain HTML: no 3D in them. */
const WITHOUT_3D = "^src/(api|store|ui|app)/|/(actions|state|text)\\.ts$|(Panel|Dialog|Menu|Card|Bar|State|Sliders|Curve|Layers|Pattern)\\.ts$";

export default {
  forbidden: [
    { name: "no-circle", severity: "error", from: {}, to: { circular: true } },
    ...ROOMS.slice(0, -1).map((room, floor) => ({
      name: `${room}-knows-no-room-above`,
      severity: "error",
      from: { path: `^src/${room}/` },
      to: { path: `^src/(${ROOMS.slice(floor + 1).join("|")})/|^src/[^/]+\\.ts$` },
    })),
    { name: "every-room-is-listed", severity: "error", from: { path: "^src/", pathNot: `^src/(${ROOMS.join("|")})/|^src/start\\.ts$` }, to: {} },
    { name: "no-three-in-panels", severity: "error", from: { path: WITHOUT_3D }, to: { path: "^node_modules/three" } },
    { name: "no-test-in-the-page", severity: "error", from: { path: "^src/" }, to: { path: "^(test|e2e|scripts)/" } },
    { name: "no-unresolved", severity: "error", from: {}, to: { couldNotResolve: true } },
    { name: "no-undeclared-package", severity: "error", from: { path: "^src/" }, to: { dependencyTypes: ["npm-dev", "npm-no-pkg", "npm-unknown", "core"], dependencyTypesNot: ["type-only"] } },
    { name: "no-unused-file", severity: "error", from: { path: "^src/start\\.ts$" }, to: { path: "^src/", pathNot: "\\.d\\.ts$", reachable: false } }, // types of others' scripts are found without an import
  ],
  options: {
    doNotFollow: { path: "node_modules" },
    tsConfig: { fileName: "tsconfig.json" },
    tsPreCompilationDeps: true, // type imports count as well
    enhancedResolveOptions: { exportsFields: ["exports"], conditionNames: ["import", "types"] },
  },
};
