// What Khronos' validator says of glTF files:
//
//   node validate_gltf.mjs TOOLS FILE...
//
// TOOLS: the folder with node_modules. Prints one JSON object, a report for each file.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

const [tools, ...files] = process.argv.slice(2);
const validator = createRequire(resolve(tools, "package.json"))("gltf-validator");
const reports = {};
for (const file of files) reports[file] = await validator.validateBytes(new Uint8Array(readFileSync(file)));
console.log(JSON.stringify(reports));
