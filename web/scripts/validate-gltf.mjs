// Validates .glb and .gltf files with Khronos' glTF validator: node scripts/validate-gltf.mjs FILE...
// Prints one line per error and warning; exit code 1 when there is any, 2 when the validator is missing.
import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";

const SEVERITIES = ["error", "warning"];

let validateBytes;
try {
  ({ validateBytes } = await import("gltf-validator"));
} catch {
  console.error("gltf-validator is not installed: run npm ci in web/.");
  process.exit(2);
}

let findings = 0;
for (const file of process.argv.slice(2)) {
  const report = await validateBytes(new Uint8Array(await readFile(file)), {
    uri: file,
    maxIssues: 100,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(resolve(dirname(file), uri))),
  });
  for (const issue of report.issues.messages) {
    if (issue.severity >= SEVERITIES.length) continue;
    findings += 1;
    console.error(`${file}: ${SEVERITIES[issue.severity]} ${issue.code} at ${issue.pointer ?? "?"}: ${issue.message}`);
  }
  const { numErrors, numWarnings } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
  findings = Math.max(findings, numErrors + numWarnings);
}
process.exit(findings > 0 ? 1 : 0);
