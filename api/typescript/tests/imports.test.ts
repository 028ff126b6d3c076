import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { suite, test } from "node:test";

/** Which file imports which others, types included. */
type Imports = ReadonlyMap<string, readonly string[]>;

function importsOf(source: string): string[] {
  return [...source.matchAll(/\b(?:from|import)\s*\(?"\.\/([\w-]+)\.js"/g)].map((match) => match[1]!);
}

/** Returns the files that import themselves through others. */
function inCircles(imports: Imports): string[] {
  const reachesItself = (start: string) => {
    const seen = new Set<string>();
    const open = [start];
    for (let file = open.pop(); file !== undefined; file = open.pop()) {
      for (const imported of imports.get(file) ?? []) {
        if (imported === start) return true;
        if (!seen.has(imported)) open.push(imported);
        seen.add(imported);
      }
    }
    return false;
  };
  return [...imports.keys()].filter(reachesItself).sort();
}

suite("imports", () => {
  test("no files of the client import each other in a circle", () => {
    const names = readdirSync("src").filter((name) => name.endsWith(".ts"));
    const read = (name: string) => [name.slice(0, -3), importsOf(readFileSync(`src/${name}`, "utf8"))] as const;
    const imports = new Map(names.map(read));
    assert.ok(imports.get("index")!.length > 8, "the imports of index.ts are found");
    assert.deepEqual(inCircles(imports), []);
  });

  test("an added circle is found, also one of types", () => {
    const sources = { a: 'import { B } from "./b.js";', b: 'export { C } from "./c.js";', c: 'import ws from "ws";' };
    const graph = (c: string) => new Map(Object.entries({ ...sources, c }).map(([name, text]) => [name, importsOf(text)]));
    assert.deepEqual(inCircles(graph(sources.c)), []);
    assert.deepEqual(inCircles(graph('import type {\n  A,\n} from "./a.js";')), ["a", "b", "c"]);
    assert.deepEqual(inCircles(graph('type A = import("./b.js").B;')), ["b", "c"]);
  });
});
