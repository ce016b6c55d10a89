// Strict rules with types.  typescript-eslint reads types through the interface of TypeScript 6, which version 7 no longer
// has: hence package.json names both, "typescript" for ESLint alone and "@typescript/native" for tsc.
import { defineConfig } from "eslint/config";
import tseslint from "typescript-eslint";

export default defineConfig(
  { ignores: ["dist", "test-results", "playwright-report", "src/api/types.gen.ts"] },
  { linterOptions: { reportUnusedDisableDirectives: "error" } },
  {
    files: ["**/*.{ts,js,mjs}"],
    extends: [tseslint.configs.strict, tseslint.configs.stylistic],
    rules: { eqeqeq: ["error", "always", { null: "ignore" }], "no-console": "error", "object-shorthand": "error", "no-implicit-coercion": "error" },
  },
  {
    files: ["**/*.ts"],
    extends: [tseslint.configs.strictTypeCheckedOnly, tseslint.configs.stylisticTypeCheckedOnly],
    languageOptions: { parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname } },
    rules: {
      "@typescript-eslint/consistent-type-imports": "error",
      "@typescript-eslint/switch-exhaustiveness-check": "error",
      "@typescript-eslint/no-unused-vars": ["error", { ignoreRestSiblings: true }],
      // A short arrow function that hands on a call's nothing is plain enough.
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true, ignoreVoidOperator: true, ignoreVoidReturningFunctions: true }],
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
      // noUncheckedIndexedAccess asks for one at every number of a vector and every index that a loop has checked.
      "@typescript-eslint/no-non-null-assertion": "off",
    },
  },
  {
    // Only api/ speaks with the service.
    files: ["src/**/*.ts"],
    ignores: ["src/api/**"],
    rules: { "no-restricted-globals": ["error", "fetch", "XMLHttpRequest", "EventSource"] },
  },
  {
    // What stands in for a function of the service is asynchronous without waiting for anything.
    files: ["test/**/*.ts", "e2e/**/*.ts"],
    rules: { "@typescript-eslint/require-await": "off" },
  },
  { files: ["scripts/**", "e2e/**"], rules: { "no-console": "off" } }, // they print what they measured
);
