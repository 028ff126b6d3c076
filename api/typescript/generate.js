// Writes src/generated.ts: the types of the OpenAPI document and the remedy for each type of problem.
//     node generate.js ../openapi.json
import { readFile, writeFile } from "node:fs/promises";
import { resolve } from "node:path";
import openapiTS, { astToString } from "openapi-typescript";

const path = resolve(process.argv[2]);
const document = JSON.parse(await readFile(path, "utf8"));
const types = astToString(await openapiTS(document, { defaultNonNullable: false }));
const rows = document.info.description.matchAll(/^\| `(\/problems\/[\w-]+)` \| \d+ \| .*? \| (.*?) \|$/gm);
const remedies = Object.fromEntries([...rows].map(([, type, remedy]) => [type, remedy]));
const table = `export const REMEDIES: Readonly<Record<string, string>> = ${JSON.stringify(remedies, null, 2)};\n`;
await writeFile(new URL("src/generated.ts", import.meta.url), `${types}\n${table}`);
