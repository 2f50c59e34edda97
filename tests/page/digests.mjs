// node digests.mjs MODULE.js FILE: renders the cameras of FILE (digests.py writes it) with the WebAssembly module in Node, and compares the
// digests of pictures and counters. Ends with 1 if one differs.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const [modulePath, file] = process.argv.slice(2);
const module = await createRequire(import.meta.url)(resolve(modulePath))();
const call = (name, result, types) => module.cwrap("tilemesh_" + name, result, types);
const render = call("render", "number", ["number", "number"]);
const report = call("report", "string", ["number", "string"]);
const error = call("error", "string", ["number"]);
const handle = call("create", "number", [])();
const camera = module._malloc(17 * 8);

let cameras = 0, different = 0;
const times = [];
for (const line of readFileSync(file, "utf8").split("\n")) {
    if (line === "" || line.startsWith("#")) continue;
    const words = line.split(" ");
    module.HEAPF64.set(words.slice(0, 17).map(Number), camera / 8);
    const begin = process.cpuUsage();
    if (render(handle, camera) !== 1) throw new Error(error(handle));
    const { user, system } = process.cpuUsage(begin);
    times.push((user + system) / 1000);
    const digest = JSON.parse(report(handle, "digest"));
    const same = digest.picture === words[17] && digest.counters === words[18];
    if (!same) console.log(`camera ${cameras}: ${digest.picture} ${digest.counters}, native ${words[17]} ${words[18]}`);
    different += same ? 0 : 1;
    ++cameras;
}
console.log(`${cameras - different} of ${cameras} cameras equal; ${times[0].toFixed(0)} ms of a core for the first frame, ` +
    `${times.slice(1, 5).sort((a, b) => a - b)[1].toFixed(0)} ms for one that turned by 0.5 degrees`);
process.exit(cameras === 10 && different === 0 ? 0 : 1);
