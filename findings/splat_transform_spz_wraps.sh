#!/usr/bin/env bash
# Version:  @playcanvas/splat-transform 3.7.0 (npm), SPZ as nianticlabs/spz describes it.
# Expected: a position that SPZ does not hold is refused, or the fractional bits of the header are fewer.
# Seen:     every file has 12 fractional bits; a Gaussian at x = 3000 is written as -1096, without a word and with exit 0.
# Matters:  a light field in millimetres, or with a far background, reaches 2,048 units easily.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 77
command -v node >/dev/null && command -v npm >/dev/null || exit 77
npm install --no-audit --no-fund --ignore-scripts --silent --prefix "$work" @playcanvas/splat-transform@3.7.0 >/dev/null 2>&1 || exit 77
cat >try.mjs <<'JS'
import { readFileSync, writeFileSync } from "node:fs";
import { spawnSync } from "node:child_process";
const names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
               "rot_0", "rot_1", "rot_2", "rot_3"];
const header = ["ply", "format binary_little_endian 1.0", "element vertex 2",
                ...names.map((name) => `property float ${name}`), "end_header\n"].join("\n");
const numbers = new Float32Array([3000, 1, 2, 0, 0, 0, 1, -3, -3, -3, 1, 0, 0, 0, //
                                  5, 1, 2, 0, 0, 0, 1, -3, -3, -3, 1, 0, 0, 0]);
writeFileSync("in.ply", Buffer.concat([Buffer.from(header), Buffer.from(numbers.buffer)]));
const run = (...files) =>
  spawnSync(process.execPath, ["node_modules/@playcanvas/splat-transform/bin/cli.mjs", "-w", ...files], { encoding: "utf8" });
const there = run("in.ply", "out.spz"), back = run("out.spz", "back.ply");
const said = there.stdout + there.stderr;
const bytes = readFileSync("back.ply"), at = bytes.indexOf("end_header\n") + 11;
const properties = bytes.subarray(0, at).toString().match(/property float \w+/g).map((line) => line.split(" ")[2]);
const found = [0, 1].map((i) => bytes.readFloatLE(at + 4 * (properties.length * i + properties.indexOf("x"))));
console.log(`   exits ${there.status} and ${back.status}; x = 3000 and 5 come back as ${found.join(" and ")}`);
const warned = /2048|range|wrap|overflow|precision/i.test(said);
console.log(`   it ${warned ? "says something" : "says nothing"} about the range`);
process.exit(there.status === 0 && !warned && found.some((x) => Math.abs(x + 1096) < 1) ? 0 : 1);
JS
node try.mjs
