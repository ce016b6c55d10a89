// The words of all languages belong together, all of them are used, and none stands outside of them.
import { readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import ts from "typescript";
import { expect, test } from "vitest";
import german from "../../src/languages/de.json";
import english from "../../src/languages/en.json";
import type { Catalogue } from "../../src/languages/words";

const catalogues: Record<string, Catalogue> = { en: english, de: german };
const SRC = fileURLToPath(new URL("../../src/", import.meta.url));
const names = readdirSync(SRC, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".ts") && !/\.gen\.ts$|\.d\.ts$/.test(name));
const files = names.map((name) => ts.createSourceFile(name, readFileSync(SRC + name, "utf8"), ts.ScriptTarget.ES2022, true));

const forms = (entry: Catalogue[string]): string[] => (typeof entry === "string" ? [entry] : Object.values(entry));
const places = (sentence: string): string[] => [...new Set([...sentence.matchAll(/\{(\w+)\}/g)].map(([, name]) => name!))].sort();
const placesOf = (entry: Catalogue[string]): string[] => [...new Set(forms(entry).flatMap(places))].sort();

function look(visit: (node: ts.Node, file: ts.SourceFile) => boolean): void {
  for (const file of files) {
    const walk = (node: ts.Node): void => {
      if (visit(node, file)) ts.forEachChild(node, walk);
    };
    walk(file);
  }
}

test("each language has the same keys, each entry the same places, the plural forms that the language has, and no space too many", () => {
  for (const [language, catalogue] of Object.entries(catalogues)) {
    expect(Object.keys(catalogue).sort(), language).toEqual(Object.keys(english).sort());
    const { pluralCategories } = new Intl.PluralRules(language).resolvedOptions();
    const wrong = Object.entries(catalogue).filter(([key, entry]) => {
      const own = (english as Catalogue)[key]!;
      const arePlaces = placesOf(entry).join() === placesOf(own).join();
      const areForms = typeof entry === "string" ? typeof own === "string" : typeof own !== "string" && Object.keys(entry).sort().join() === [...pluralCategories].sort().join();
      const isTidy = forms(entry).every((form) => form !== "" && !/ {2}|\t|\n| $/.test(form) && form.split("{").length === form.split("}").length);
      return !arePlaces || !areForms || !isTidy;
    });
    expect(wrong, language).toEqual([]);
  }
});

// What is one word in both languages, or no word.
const SAME = /^(?:[^A-Za-zÄÖÜäöü]*|[A-Z]( · ([A-Z]|\+))*|Details|Plan|Scan|Name|Radius|Tumor|Link|Code|Import|Lasso|Stopp|Pause|Axial|Sagittal|Tab|Esc|Orange|Text|, in|auto|Iteration|Scans|[+] Scan|L − R|mm|cm|P · E · T · M)$/;
const places_only = (text: string): string => text.replaceAll(/\{\w+\}/g, "").replaceAll(/\b(mm|cm|s|MB|x|y|z)\b/g, "").trim();

test("what reads in German as in English is the same word in both", () => {
  const left = Object.entries(german as Catalogue).filter(([key, entry]) => forms(entry).some((form) => forms((english as Catalogue)[key]!).includes(form) && !SAME.test(places_only(form))));
  expect(left).toEqual([]);
});

test("each key is used, with a value for each of its places and no other", () => {
  const used = new Set<string>();
  const wrong: string[] = [];
  look((node, file) => {
    if (ts.isStringLiteral(node) && Object.hasOwn(english, node.text)) used.add(node.text);
    if (!ts.isCallExpression(node) || node.expression.getText(file) !== "word") return true;
    const [key, values] = node.arguments;
    const keys: string[] = [];
    const collect = (each: ts.Node): void => {
      if (ts.isStringLiteral(each) && Object.hasOwn(english, each.text)) keys.push(each.text);
      else ts.forEachChild(each, collect);
    };
    collect(key!);
    const given = values && ts.isObjectLiteralExpression(values) ? values.properties.map((property) => property.name!.getText(file)).sort() : [];
    const wanted = keys.flatMap((each) => [...placesOf((english as Catalogue)[each]!), ...(typeof (english as Catalogue)[each] === "string" ? [] : ["count"])]); // of all that a condition chooses from
    if (keys.length > 0 && [...new Set(wanted)].sort().join() !== given.join()) wrong.push(`${file.fileName}: ${keys.join()} have ${wanted.join()}, are given ${given.join()}`);
    return true;
  });
  expect(wrong).toEqual([]);
  expect(Object.keys(english).filter((key) => !used.has(key))).toEqual([]);
});

const NAMES = /^(Enter|Escape|Backspace|Delete|Files|English|Deutsch|BreastRig|[A-Z]\w+-[A-Z]\w+|ResizeObserver|WebKit WebGL|.*SameSite=.*|; Secure|(quiet|outlined) .*|(discs?|halo) of .*|along the skin)$/; // of keys, headers, looks, things on the stage, a column of a file
const UNSEEN = /^(class|look|d|viewBox|accept|vertexShader|fragmentShader)$/;

/** A word that begins with a capital, three words in a row, or the end of a sentence: no name of a class or an event. */
const isSaid = (text: string): boolean => (/(^|[ “"(])[A-Z][a-z]{2,}/.test(text) || /[a-z]{2,} [a-z]+ [a-z]+/.test(text) || /[a-z]{2,} ?[.!?…]($| )/.test(text)) && !NAMES.test(text);

test("no words stand in the sources, but for faults that only programmers meet", () => {
  const found: string[] = [];
  look((node, file) => {
    if (ts.isImportDeclaration(node) || ts.isExportDeclaration(node) || ts.isLiteralTypeNode(node)) return false;
    if (ts.isNewExpression(node) && node.expression.getText(file) === "Error") return false;
    if (ts.isPropertyAssignment(node) && UNSEEN.test(node.name.getText(file))) return false;
    const text = ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node) ? node.text : ts.isTemplateExpression(node) ? [node.head, ...node.templateSpans.map(({ literal }) => literal)].map(({ text: part }) => part).join("{}") : "";
    if (isSaid(text) && !Object.hasOwn(english, text)) found.push(`${file.fileName}:${file.getLineAndCharacterOfPosition(node.getStart(file)).line + 1}: ${text.slice(0, 90)}`);
    return true;
  });
  expect(found).toEqual([]);
  expect(["Line", "Make a link", "the model alone", "Sending …", "no such fit."].filter((text) => !isSaid(text)), "the check itself").toEqual([]);
});
