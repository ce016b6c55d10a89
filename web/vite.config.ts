// The page is built to dist/, which the service serves at "/".  While developing, Vite serves the sources and
// passes /api on to a running service (BREASTRIG_SERVICE, by default the port of `make serve`).
import { defineConfig } from "vitest/config";

const service = process.env.BREASTRIG_SERVICE ?? "http://127.0.0.1:8321";

export default defineConfig({
  worker: { format: "es" },
  base: "/", // the page stands at the root and at /s
  server: { host: "127.0.0.1", port: 5173, proxy: { "/api": service, "/healthz": service } },
  build: {
    target: "es2022",
    cssTarget: ["chrome123", "firefox120", "safari17.5"], // the first with light-dark(); older ones would need every colour twice
    // The page's policy is default-src 'self': nothing may be inlined as a data: address.
    assetsInlineLimit: 0,
    // three.js is one library of that size; splitting it would only add round trips.
    chunkSizeWarningLimit: 1000,
    modulePreload: { polyfill: false },
    // What many parts of the page share comes as one file, not as one for each set of parts: each file is another request.
    // Words stand alone: start.ts fills them before any module runs that has some.
    rolldownOptions: { output: { codeSplitting: { groups: [{ name: "words", test: /languages\/words\.ts$/, priority: 1 }, { name: "three", test: /node_modules/, minShareCount: 2 }, { name: "shared", test: /src/, minShareCount: 3 }] } } },
  },
  // One set of modules for all files of a worker: loading them anew for each file took longer than the tests.
  test: { include: ["test/**/*.test.ts"], environment: "node", pool: "threads", isolate: false, setupFiles: ["test/english.ts"], testTimeout: 60_000 }, // none of them waits; a busy machine takes its time
});
