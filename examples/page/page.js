// The page: its state, the questions to the worker, and what it paints.

const $ = id => document.getElementById(id);
const number = new Intl.NumberFormat("en-US"), count = n => number.format(n);
const ms = x => x < 9.995 ? x.toFixed(2) + " ms" : x < 99.95 ? x.toFixed(1) + " ms" : count(Math.round(x)) + " ms";
const bytesText = n => n < 1e6 ? count(n) + " bytes" : (n / 1e6).toFixed(1) + " MB";
function put(id, text) { // a text that stays costs no layout
  const element = typeof id === "string" ? $(id) : id;
  if (element.textContent !== text) element.textContent = text;
}
function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

// Numbers of a tile that colour the grid: name in the C interface, label, unit.
const heats = [["load", "Load", "records and copies on the tile"], ["copies", "Copies", "copies on the tile"],
  ["channel", "Channel fill", "of the fullest channel's slots"], ["refused", "Refusals", "refused by a full channel or storage"],
  ["lost", "Lost", "missing in the picture"], ["pairs", "Pairs", "pairs of a Gaussian and a pixel"],
  ["busy", "Busy, modelled", "modelled cycles of computing"]];
const sizes = [[320, 180], [640, 360], [960, 540], [1280, 720]];
const lenses = [["pinhole", "pinhole"], ["opencv,-0.28,0.07", "barrel (opencv)"], ["fov,0.9", "FOV 0.9"], ["fisheye", "fisheye"]];
const tileSizes = [[0, 0], [8, 8], [16, 16], [32, 20], [32, 32], [64, 40]];
// Settings that links carry; 0 or the first choice is left out.
const plain = {preset: "lossless", machine: "mk2", saturation: "preset", channel_slots: 0, storage_slots: 0, hops: 0, tile_width: 0, tile_height: 0,
               lens: "pinhole"};

const state = {view: null, size: [640, 360], chosen: {...plain}, heat: "load", step: -1, tile: null, gaussian: null, difference: false, file: ""};
let map = null, settings = null, last = null; // what the worker said
let poses = null, playing = false, pose = 0; // poses: 13 numbers each, see worker.js
let mesh = 0; // another number begins a new mesh: all records start from the host

// ---- the worker ------------------------------------------------------------------------------------------------------------
const asked = new Map();
let questions = 0, worker = null;
function ask(what, data = {}, buffers = []) {
  return new Promise((resolve, reject) => {
    asked.set(++questions, {resolve, reject});
    worker.postMessage({id: questions, ask: what, ...data}, buffers);
  });
}
function broken(problem) { // no question gets an answer any more
  say(problem);
  for (const {reject} of asked.values()) reject(new Error(problem));
  asked.clear();
}
try {
  worker = new Worker(URL.createObjectURL(new Blob([$("worker-source").textContent], {type: "text/javascript"})));
  worker.onmessage = ({data}) => {
    const {resolve, reject} = asked.get(data.id) ?? {};
    asked.delete(data.id);
    if (data.problem === undefined) resolve?.(data);
    else reject?.(new Error(data.problem));
  };
  worker.onerror = event => broken(`the chip stopped (${event.message}); load this page again`);
} catch (error) {
  worker = {postMessage() { throw new Error(`the chip cannot start (${error.message}); use a newer browser`); }};
}

// What must be done before the page is up to date. One job at a time. A newer map replaces one that waits, and so does a newer camera.
// `queue`: jobs about the frame that is shown; they come before the next frame.
const due = {load: null, settings: false, frame: false, show: false}, queue = [];
let working = null, cold = true, frames = 0, goodView = null;
function want(what, value = true) {
  due[what] = value;
  working ??= work().finally(() => { working = null; });
  remember();
}
function soon(job) {
  queue.push(job);
  working ??= work().finally(() => { working = null; });
}
const machineOf = settings => JSON.stringify({...settings, difference: 0, follow: 0, limits: 0});
async function work() {
  if (!await begun) return;
  while (queue.length || due.load || due.settings || due.frame || due.show) {
    let doing = "";
    try {
      if (queue.length) {
        await queue.shift()();
      } else if (due.load) {
        const file = due.load;
        due.load = null;
        loaded(file.name, await ask("load", file, file.bytes === null ? [] : [file.bytes])); // the bytes go to the worker without a copy
      } else if (due.settings) {
        doing = "settings";
        due.settings = false;
        const before = machineOf(settings);
        ({settings} = await ask("set", {settings: wantedSettings()}));
        cold ||= before !== machineOf(settings);
        showControls();
        due.frame = true;
      } else if (due.frame) {
        doing = "frame";
        due.frame = due.show = false;
        const view = state.view, first = cold, picture = state.difference ? "difference" : "rgba";
        const answer = await ask("render", {camera: cameraOf(view, state.size), picture, show: wantedDetails(!first)});
        if (first) compareStarts(answer.frame);
        cold = false;
        goodView = view;
        ++frames;
        paintPicture(answer, first);
        paintDetails(answer);
      } else {
        due.show = false;
        paintDetails(await ask("show", {show: wantedDetails()}));
      }
    } catch (error) {
      say(error.message);
      showMap();
      if (doing === "settings" && !due.settings) {
        restoreSettings();
        if (state.view !== goodView) due.frame = true;
      }
      if (doing === "frame" && !due.frame && state.view !== goodView) { // back to a camera that gave a picture
        const usable = goodView ?? startView(map);
        due.frame = goodView === null && viewText(state.view) !== viewText(usable);
        state.view = usable;
      }
    }
  }
}
// While the camera moves, the contents of a tile follow five times a second, and once more when it stands: nobody reads 120 records faster.
const restMs = 200;
let tileAt = 0, late = 0; // when the tile was painted; the timer for what is not painted yet
function wantedDetails(moving = false) {
  const waits = moving && state.tile !== null && shown?.tile?.tile === state.tile && performance.now() - tileAt < restMs;
  return {heat: state.heat, superstep: state.step, tile: waits ? undefined : state.tile, gaussian: state.gaussian};
}
const wantedSettings = () => ({...state.chosen, width: state.size[0], height: state.size[1], difference: state.difference,
                               follow: state.gaussian ?? -1, mesh});
// After a refused setting the chip keeps the old ones, and the controls say so.
function restoreSettings() {
  for (const name of Object.keys(plain)) state.chosen[name] = settings[name];
  state.size = [settings.width, settings.height];
  state.difference = settings.difference;
  showControls();
  remember();
}
function change(changed) {
  say("");
  Object.assign(state.chosen, changed);
  want("settings");
}

// ---- messages --------------------------------------------------------------------------------------------------------------
function say(problem) {
  $("problem").textContent = problem;
  $("problem").hidden = problem === "";
}
let told = "", telling = 0;
function tell(text) { // a screen reader hears a sentence once it has stayed for a moment
  if (text === told) return;
  told = text;
  clearTimeout(telling);
  telling = setTimeout(() => { $("missing").textContent = told; }, $("missing").dataset.shown ? 250 : 0);
  $("missing").dataset.shown = "1";
}

// ---- the picture and the numbers -------------------------------------------------------------------------------------------
function paintPicture({pixels, frame, ms: took}, first) {
  const canvas = $("picture");
  if (canvas.width !== frame.width || canvas.height !== frame.height) {
    [canvas.width, canvas.height] = [frame.width, frame.height];
    $("frame").style.aspectRatio = `${frame.width} / ${frame.height}`;
  }
  canvas.getContext("2d", {alpha: false}).putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), frame.width), 0, 0);
  last = {...frame, took};
  put("n-host", ms(took));
  put("n-host-what", first ? "this host, cold" : "this host");
  put("n-chip", ms(frame.modelled_ms));
  put("n-steps", count(frame.supersteps));
  put("n-moved", count(frame.moved));
  const lost = lostOf(frame);
  put("n-lost", count(lost));
  $("n-lost").parentElement.classList.toggle("bad", lost !== 0);
  const sentence = text => text[0].toUpperCase() + text.slice(1) + ".";
  tell(frame.missing === "" ? (frame.visible === 0 ? "No Gaussian of the map is in this view." : "Nothing is missing in the picture.") : sentence(frame.missing) + (frame.advice ? " " + sentence(frame.advice) : ""));
  const slow = took > 100 && !first && frame.width > 320 ? " Frames are slow: fewer pixels are faster." : "";
  const d = frame.difference;
  const differs = !d ? "" : d.pixels === 0 ? " No pixel differs from the complete picture."
    : ` ${count(d.pixels)} pixels differ from the complete picture` +
      (d.psnr_db === null ? "." : `: PSNR ${d.psnr_db.toFixed(2)} dB, at most ${d.largest.toFixed(3)}.`);
  put("resolution", `${frame.width} x ${frame.height} pixels, ${frame.columns} x ${frame.rows} tiles of ` +
    `${frame.tile_width} x ${frame.tile_height} pixels.${differs}${slow}`);
}
const lostOf = frame => frame.lost_records + frame.lost_copies + frame.late_copies;

// What a change of the machine did: the first frames of two machines, which both begin from cold.
let start = null;
function compareStarts(frame) {
  const now = {missing: lostOf(frame), supersteps: frame.supersteps, modelled: frame.modelled_ms, refused: frame.refused};
  const key = JSON.stringify(state.chosen), before = start?.key === key ? start.before : start?.now; // the same machine again: as it was compared
  const line = (name, text) => `${name} ${text(now[name])}` + (before ? ` (before: ${text(before[name])})` : "");
  $("effect").textContent = "Cold start, every Gaussian travels from where the host put it: " +
    [line("modelled", ms), line("supersteps", count), line("refused", count), line("missing", count)].join(", ") + ".";
  start = {key, now, before};
}

// ---- the machine -----------------------------------------------------------------------------------------------------------
// Nine colours of viridis (Smith and van der Walt, matplotlib 2015, CC0), an eighth apart, as in the library's reports.
const viridis = [[68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128], [92, 200, 99], [170, 220, 50],
  [253, 231, 37]];
function heatColour(share) {
  const at = Math.min(Math.max(share, 0), 1) * 8, below = Math.min(Math.floor(at), 7);
  return viridis[below].map((c, i) => c + (at - below) * (viridis[below + 1][i] - c));
}
// 256 colours, one word each.
const ramp = new Uint32Array(Uint8ClampedArray.from({length: 256 * 4}, (_, i) => i % 4 === 3 ? 255 : heatColour((i >> 2) / 255)[i % 4]).buffer);

let shown = null; // the last details
function paintDetails(answer) {
  const waits = answer.tile === undefined;
  if (waits) {
    answer.tile = shown.tile;
    late ||= setTimeout(() => { late = 0; want("show"); }, restMs);
  } else {
    tileAt = performance.now();
    clearTimeout(late);
    late = 0;
  }
  shown = answer;
  const {frame, heat, superstep, step} = answer;
  const canvas = $("grid"), most = heat.reduce((a, b) => Math.max(a, b), 0);
  if (canvas.width !== frame.columns || canvas.height !== frame.rows) [canvas.width, canvas.height] = [frame.columns, frame.rows];
  $("grid-frame").style.aspectRatio = `${frame.columns * frame.tile_width} / ${frame.rows * frame.tile_height}`;
  const image = new ImageData(frame.columns, frame.rows), colours = new Uint32Array(image.data.buffer);
  const full = state.heat === "channel" ? 1 : most || 1;
  for (let i = 0; i < colours.length; ++i) colours[i] = ramp[Math.round(255 * Math.min(1, heat[i] / full))];
  canvas.getContext("2d", {alpha: false}).putImageData(image, 0, 0);
  const percent = share => `${(100 * share).toFixed(0)} %`, value = state.heat === "channel" ? percent : n => count(Math.round(n));
  put("least", "0");
  put("most", state.heat === "channel" ? "100 %" : count(Math.round(most)));
  const chosen = state.tile !== null && state.tile < heat.length ? `; tile ${state.tile}: ${value(heat[state.tile])}` : "";
  put("map-what", heats.find(([name]) => name === state.heat)[2] + (state.heat === "channel" ? `, fullest ${percent(most)}` : "") + chosen);

  const slider = $("step");
  slider.max = frame.supersteps;
  slider.value = step === null ? frame.supersteps : superstep;
  const text = step === null ? `whole frame, ${count(frame.supersteps)} supersteps`
    : `${superstep + 1} of ${count(frame.supersteps)}: ${step.kernel}, ${count(step.tiles)} tiles ran, ` +
      `${count(step.messages_bytes)} bytes sent, ${count(step.cycles)} modelled cycles`;
  put("step-text", text);
  slider.setAttribute("aria-valuetext", text);

  if (!waits) showTile(answer);
  showGaussian(answer);
  paintMarks(answer);
  put("memory", `Memory of the library: ${bytesText(answer.memory)}.`);
}

const svg = "http://www.w3.org/2000/svg";
function mark(parent, name, attributes) {
  const element = parent.appendChild(document.createElementNS(svg, name));
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
}
// The chosen tile, and the path of the chosen Gaussian, over the grid and over the picture.
let painted = "";
function paintMarks({frame, gaussian}) {
  const key = JSON.stringify([frame.width, frame.height, frame.columns, frame.rows, frame.tile_width, frame.tile_height, gaussian, state.tile]);
  if (key === painted) return;
  painted = key;
  const [w, h] = [frame.tile_width, frame.tile_height];
  for (const id of ["grid-marks", "picture-marks"]) {
    const marks = $(id);
    marks.replaceChildren();
    marks.setAttribute("viewBox", `0 0 ${frame.columns * w} ${frame.rows * h}`);
    if (id === "picture-marks") marks.setAttribute("viewBox", `0 0 ${frame.width} ${frame.height}`);
    const box = (tile, kind) => mark(marks, "rect", {class: kind, x: tile % frame.columns * w, y: Math.floor(tile / frame.columns) * h,
                                                     width: w, height: h});
    if (gaussian && id === "grid-marks") {
      const centre = tile => [(tile % frame.columns + 0.5) * w, (Math.floor(tile / frame.columns) + 0.5) * h];
      for (const tile of gaussian.copies) box(tile, "copy");
      for (const tile of gaussian.missing) box(tile, "lacks");
      const moving = ["anchored", "leaving", "road", "waiting"];
      const way = (gaussian.path ?? []).filter(event => moving.includes(event.what)).map(event => centre(event.tile));
      if (way.length > 1) {
        for (const kind of ["under", "over"]) mark(marks, "polyline", {class: "way " + kind, points: way.map(p => p.join()).join(" ")});
        mark(marks, "circle", {class: "from", cx: way[0][0], cy: way[0][1], r: 0.35 * Math.min(w, h)});
      }
      if (gaussian.anchor !== null) {
        const [x, y] = centre(gaussian.anchor);
        mark(marks, "circle", {class: "anchor", cx: x, cy: y, r: 0.45 * Math.min(w, h)});
      }
    }
    if (state.tile !== null && state.tile < frame.columns * frame.rows) box(state.tile, "chosen");
  }
}

function rows(table, lines) { // the first line is the head; cells that stay are not touched
  while (table.rows.length > lines.length) table.deleteRow(-1);
  lines.forEach((line, y) => {
    const row = table.rows[y] ?? table.appendChild(make("tr"));
    line.forEach((text, x) => put(row.cells[x] ?? row.appendChild(y === 0 ? make("th", {scope: "col"}) : make("td")), text));
  });
}
function showTile({tile}) {
  $("tile-body").hidden = tile === null;
  put("tile-title", tile === null ? "No tile is chosen" : `Tile ${tile.tile}: column ${tile.column}, row ${tile.row}`);
  put("tile-hint", tile === null ? "Click a tile of the grid, or a pixel of the picture."
    : `${count(tile.records)} of ${count(tile.slots)} slots: ${count(tile.anchored)} anchored, ${count(tile.copies)} copies, ` +
      `${count(tile.leaving)} leaving. ${count(tile.counts.pairs)} pairs, ${count(tile.counts.busy_cycles)} modelled cycles. ` +
      `Refused: ${Object.entries(tile.counts).filter(([name]) => name !== "pairs" && name !== "busy_cycles")
        .map(([name, n]) => `${count(n)} ${name.replaceAll("_", " ")}`).join(", ")}.`);
  if (tile === null) return;
  rows($("channels"), [["side", "sent, bytes", "received, bytes", "most messages", "slots"],
    ...tile.channels.map(c => [c.side, count(c.sent_bytes), count(c.received_bytes), count(c.most_messages), count(c.slots)])]);
  rows($("ledger"), [["region", "kind", "bytes"], ...tile.ledger.map(r => [r.name, r.what, count(r.bytes)]),
    ["sum", "", count(tile.ledger_bytes)], ["SRAM of a tile", "", count(tile.sram_bytes)]]);
  const list = tile.list, records = $("records");
  put("records-title", list.length === tile.records ? "Records" : `Records: the ${count(list.length)} nearest that are visible`);
  const focused = document.activeElement?.dataset?.gaussian;
  while (records.children.length > list.length) records.lastChild.remove();
  list.forEach((r, i) => { // buttons are used again: a new one costs more than a new text
    const button = records.children[i] ?? records.appendChild(make("button", {}, make("i"), make("span")));
    const [dot, text] = button.children, id = String(r.id);
    button.title = `depth ${r.depth.toFixed(3)}, opacity ${r.opacity.toFixed(2)}`;
    if (button.dataset.gaussian !== id) button.dataset.gaussian = id;
    put(text, `${id} ${r.kind}`);
    const colour = `rgb(${r.colour.map(c => Math.round(255 * Math.min(1, Math.max(0, c)))).join()})`;
    if (dot.dataset.colour !== colour) dot.style.background = dot.dataset.colour = colour;
  });
  if (focused !== undefined) records.querySelector(`[data-gaussian="${focused}"]`)?.focus();
}

let listed = "";
function showGaussian({gaussian, frame}) {
  put("gaussian-title", gaussian === null ? "No Gaussian is chosen" : `Gaussian ${gaussian.id}`);
  for (const button of $("records").children) {
    const pressed = String(Number(button.dataset.gaussian) === state.gaussian);
    if (button.getAttribute("aria-pressed") !== pressed) button.setAttribute("aria-pressed", pressed);
  }
  const place = tile => `tile ${tile} (${tile % frame.columns}, ${Math.floor(tile / frame.columns)})`;
  put("gaussian-hint", gaussian === null ? "Choose a record of a tile, or click the picture. Its path is then drawn over the grid."
    : gaussian.mean === null ? "The map has no Gaussian of this number."
    : `It is ${gaussian.state}` + (gaussian.anchor !== null ? `, anchored on ${place(gaussian.anchor)}` : "") +
      `, with ${count(gaussian.copies.length)} ${gaussian.copies.length === 1 ? "copy" : "copies"}` +
      (gaussian.missing.length ? `; ${count(gaussian.missing.length)} ${gaussian.missing.length === 1 ? "tile lacks" : "tiles lack"} it` : "") +
      `. Opacity ${gaussian.opacity.toFixed(2)}.` +
      (gaussian.path?.length ? " Its path in this frame:" : " It did not move in this frame."));
  const events = gaussian?.path ?? [], pathKey = JSON.stringify([events, frame.columns]);
  if (pathKey === listed) return;
  listed = pathKey;
  $("path").replaceChildren(...events.slice(0, 200).map(e =>
    make("li", {textContent: `superstep ${e.superstep + 1}, ${e.kernel}: ${e.what} on ${place(e.tile)}` +
      (e.side ? `, ${e.side} side` : "") + (e.refusal ? `, refused: ${e.refusal}` : "")})),
    ...(events.length > 200 ? [make("li", {textContent: `and ${count(events.length - 200)} more`})] : []));
}

// ---- controls --------------------------------------------------------------------------------------------------------------
function slider(name, label, zero, most) {
  const id = "set-" + name;
  const min = zero === "most" ? 1 : 0; // 0 slots would mean the preset's number
  const range = make("input", {type: "range", id, min, max: most, step: 1});
  const box = make("input", {type: "number", id: id + "-number", min, max: most, step: 1});
  box.setAttribute("aria-label", label + ", as a number");
  const read = input => {
    const value = Math.round(Number(input.value));
    change({[name]: zero === "most" && value >= most ? 0 : Math.max(min, value)});
  };
  range.oninput = () => read(range);
  box.onchange = () => read(box);
  return make("div", {className: "control"}, make("label", {htmlFor: id, textContent: label}), range, box);
}
function choice(name, label, choices, texts = choices) {
  const select = make("select", {id: "set-" + name}, ...choices.map((value, i) => make("option", {value, textContent: texts[i]})));
  const reset = name === "preset" ? {channel_slots: 0, storage_slots: 0, hops: 0} : {}; // each preset has its own numbers
  select.onchange = () => change(name === "tile" ? tileChange(select.value) : {[name]: select.value, ...reset});
  return make("div", {className: "control"}, make("label", {htmlFor: "set-" + name, textContent: label}), select);
}
const tileChange = text => { const [w, h] = text.split("x").map(Number); return {tile_width: w, tile_height: h}; };
const most = name => settings.limits[name].most;

let built = "";
function showControls() {
  const key = JSON.stringify([most("channel_slots"), most("storage_slots"), settings.choices]);
  if (key !== built) { // other limits: new controls, and the focus stays where it was
    built = key;
    const focused = document.activeElement?.id;
    const words = {preset: "the preset's rule", hold: "hold: it waits", drop: "drop: copies are lost"};
    $("controls").replaceChildren(
      choice("preset", "Preset", settings.choices.preset),
      choice("machine", "Machine", settings.choices.machine, settings.choices.machine.map(m => m === "mk2" ? "Mk2" : "test: more SRAM")),
      choice("saturation", "A full channel", settings.choices.saturation, settings.choices.saturation.map(s => words[s] ?? s)),
      choice("lens", "Lens", lenses.map(([lens]) => lens), lenses.map(([, text]) => text)),
      choice("tile", "Tile", tileSizes.map(([w, h]) => `${w}x${h}`), tileSizes.map(([w, h]) => w ? `${w} x ${h} pixels` : "40 x 36 tiles")),
      slider("channel_slots", "Channel slots", "most", most("channel_slots")),
      slider("storage_slots", "Storage slots", "most", most("storage_slots")),
      slider("hops", "Hops a frame, 0: all", "zero", 80));
    if (focused) $(focused)?.focus();
  }
  for (const name of ["preset", "machine", "saturation"]) $("set-" + name).value = settings[name];
  const tile = `${settings.tile_width}x${settings.tile_height}`, select = $("set-tile");
  if (![...select.options].some(o => o.value === tile))
    select.append(make("option", {value: tile, textContent: tile.replace("x", " x ") + " pixels"}));
  select.value = tile;
  if (![...$("set-lens").options].some(o => o.value === settings.lens))
    $("set-lens").append(make("option", {value: settings.lens, textContent: settings.lens}));
  $("set-lens").value = settings.lens;
  for (const [name, value] of [["channel_slots", settings.channel_slots || most("channel_slots")],
                               ["storage_slots", settings.storage_slots || most("storage_slots")], ["hops", settings.hops]])
    for (const input of [$("set-" + name), $("set-" + name + "-number")])
      if (input !== document.activeElement || !due.settings) input.value = value;
  const size = state.size.join("x");
  if (![...$("size").options].some(o => o.value === size)) $("size").append(make("option", {value: size, textContent: size.replace("x", " x ")}));
  $("size").value = size;
  $("difference").checked = state.difference;
}

function chooseTile(tile) {
  state.tile = tile;
  want("show");
}
// The path of a Gaussian begins where the host put it, so the machine starts again from cold.
function chooseGaussian(id) {
  state.gaussian = id;
  if (id !== null) startAgain();
  else want("settings");
}
function startAgain() {
  mesh = (mesh + 1) % 1000000;
  want("settings");
}

// ---- camera ----------------------------------------------------------------------------------------------------------------
function look(view) {
  state.view = view;
  want("frame");
}
const away = 0.02; // a key moves the camera by this share of its distance
const keys = {
  ArrowLeft: v => turned(v, 2, 0), ArrowRight: v => turned(v, -2, 0), ArrowUp: v => turned(v, 0, 2), ArrowDown: v => turned(v, 0, -2),
  w: v => moved(v, 0, 0, away * v.distance), s: v => moved(v, 0, 0, -away * v.distance), a: v => moved(v, -away * v.distance, 0, 0),
  d: v => moved(v, away * v.distance, 0, 0), q: v => moved(v, 0, -away * v.distance, 0), e: v => moved(v, 0, away * v.distance, 0),
  "+": v => closer(v, 0.9), "=": v => closer(v, 0.9), "-": v => closer(v, 1 / 0.9), r: () => startView(map), u: upsideDown,
};
$("picture").addEventListener("keydown", event => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (event.ctrlKey || event.metaKey || event.altKey || !state.view) return;
  if (keys[key]) look(keys[key](state.view));
  else if (key === "Enter") pickAt(state.size[0] / 2, state.size[1] / 2);
  else return;
  event.preventDefault();
});
document.addEventListener("keydown", event => {
  if (!poses || event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|BUTTON|SUMMARY)$/.test(event.target.tagName)) return;
  const act = {" ": () => play(!playing), ",": () => goTo(pose - 1), ".": () => goTo(pose + 1)}[event.key];
  if (act) act(), event.preventDefault();
});

const fingers = new Map();
let dragged = 0;
$("picture").addEventListener("pointerdown", event => {
  $("picture").setPointerCapture(event.pointerId);
  $("picture").focus({preventScroll: true});
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  if (fingers.size === 1) dragged = 0;
});
$("picture").addEventListener("pointermove", event => {
  const before = fingers.get(event.pointerId);
  if (!before || !state.view) return;
  const dx = event.clientX - before[0], dy = event.clientY - before[1], width = Math.max(1, $("picture").clientWidth);
  dragged += Math.abs(dx) + Math.abs(dy);
  const reach = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  const apart = fingers.size === 2 ? reach() : 0;
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  const sideways = 2 * state.view.distance * Math.tan(state.view.fov / 2 * radians) / width;
  if (fingers.size === 2) look(closer(moved(state.view, -dx / 2 * sideways, -dy / 2 * sideways, 0), apart / Math.max(1, reach())));
  else if (event.shiftKey || event.buttons === 2) look(moved(state.view, -dx * sideways, -dy * sideways, 0));
  else if (dragged > 3) look(turned(state.view, dx * 180 / width, -dy * 180 / width));
});
for (const end of ["pointerup", "pointercancel"])
  $("picture").addEventListener(end, event => {
    const at = fingers.get(event.pointerId);
    fingers.delete(event.pointerId);
    if (end === "pointercancel" || !at || dragged > 3 || event.button !== 0 || !last) return;
    const box = $("picture").getBoundingClientRect();
    pickAt((event.clientX - box.left) / box.width * last.width, (event.clientY - box.top) / box.height * last.height);
  });
$("picture").addEventListener("contextmenu", event => event.preventDefault());
$("picture").addEventListener("wheel", event => {
  event.preventDefault();
  const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
  if (state.view) look(closer(state.view, Math.exp(Math.max(-300, Math.min(300, pixels)) * 0.001)));
}, {passive: false});
function pickAt(x, y) {
  if (!last) return;
  const inside = (value, size) => Math.max(0, Math.min(size - 1, value)); // in the last frame's pixels
  soon(async () => {
    const {tile, gaussian} = await ask("pick", {x: inside(x, last.width), y: inside(y, last.height)});
    state.tile = tile;
    chooseGaussian(gaussian);
  });
}

// ---- the grid and the supersteps ---------------------------------------------------------------------------------------------
$("grid").addEventListener("click", event => {
  if (!last) return;
  const box = $("grid").getBoundingClientRect();
  const column = Math.min(last.columns - 1, Math.floor((event.clientX - box.left) / box.width * last.columns));
  const row = Math.min(last.rows - 1, Math.floor((event.clientY - box.top) / box.height * last.rows));
  chooseTile(row * last.columns + column);
});
$("grid").addEventListener("keydown", event => {
  const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
  if (!step || !last) return;
  event.preventDefault();
  const at = state.tile ?? Math.floor(last.rows / 2) * last.columns + Math.floor(last.columns / 2);
  const column = Math.max(0, Math.min(last.columns - 1, at % last.columns + (state.tile === null ? 0 : step[0])));
  const row = Math.max(0, Math.min(last.rows - 1, Math.floor(at / last.columns) + (state.tile === null ? 0 : step[1])));
  chooseTile(row * last.columns + column);
});
$("records").addEventListener("click", event => {
  const button = event.target.closest("button");
  if (button) chooseGaussian(Number(button.dataset.gaussian) === state.gaussian ? null : Number(button.dataset.gaussian));
});
function toStep(value) {
  if (!shown) return;
  state.step = value >= shown.frame.supersteps ? -1 : Math.max(0, value);
  want("show");
}
$("step").oninput = () => toStep(Number($("step").value));
$("step-back").onclick = () => toStep((state.step < 0 ? shown?.frame.supersteps : shown.superstep) - 1);
$("step-on").onclick = () => toStep((state.step < 0 ? shown?.frame.supersteps : shown.superstep) + 1);

for (const [name, label] of heats) {
  const input = make("input", {type: "radio", name: "heat", value: name, checked: name === state.heat});
  input.onchange = () => { state.heat = name; want("show"); };
  $("maps").append(make("label", {}, input, label));
}
$("size").append(...sizes.map(([w, h]) => make("option", {value: `${w}x${h}`, textContent: `${w} x ${h}`})));
$("size").onchange = () => { say(""); state.size = $("size").value.split("x").map(Number); want("settings"); };
$("difference").onchange = () => { state.difference = $("difference").checked; want("settings"); };
$("defaults").onclick = () => change({...plain, preset: state.chosen.preset, machine: state.chosen.machine, lens: state.chosen.lens});
$("cold").onclick = startAgain;
$("reset").onclick = () => look(startView(map));
$("upright").onclick = () => look(upsideDown(state.view));

// ---- files -----------------------------------------------------------------------------------------------------------------
const mostBytes = 2e9; // the chip has 4 GB of memory in a browser, and a map is in it twice while it is read
let taking = 0;
async function take(file) {
  say("");
  const mine = ++taking; // a file that is dropped later wins, also if it is read sooner
  try {
    if (file.size > mostBytes)
      throw new Error(`${file.name} cannot be opened (it has ${count(file.size)} bytes, more than 2 GB); open a smaller map`);
    put("map-name", `Opening ${file.name}, ${bytesText(file.size)}.`);
    const bytes = await file.arrayBuffer().catch(error => { throw new Error(`${file.name} cannot be read (${error.message}); drop a file`); });
    if (mine !== taking) return;
    // The first bytes of a text of poses are digits, a sign or a comment; everything else is a map, and the library says what is wrong.
    const head = new TextDecoder("latin1").decode(bytes.slice(0, 200));
    if (!/\.splat$/i.test(file.name) && /^[\uFEFF\s]*(#|[-+.\d])[\x20-\x7e\s]*$/.test(head)) {
      const answer = await ask("poses", {name: file.name, bytes}, [bytes]);
      if (mine === taking) showPoses(answer);
    } else {
      want("load", {name: file.name, bytes});
    }
  } catch (error) {
    if (mine !== taking) return;
    say(error.message);
    showMap();
  }
}
function showPoses({numbers, notes}) {
  poses = numbers;
  showMap();
  put("pose-notes", notes.map(note => `Note: ${note}.`).join(" "));
  $("timeline").hidden = false;
  $("pose").max = poses.length / 13 - 1;
  goTo(0);
}
function loaded(name, answer) {
  ({map, settings} = answer);
  [state.file, state.tile, state.gaussian, state.step, state.view] = [name, null, null, -1, null];
  [cold, start, goodView] = [true, null, null];
  if (awaited?.name === name) readFragment(awaited.link);
  awaited = null;
  state.view ??= startView(map);
  showMap();
  want("settings");
}
function showMap() {
  if (!map) return;
  $("map-name").textContent = `Map: ${state.file || "built-in"}, ${count(map.gaussians)} Gaussians` +
    (map.rejected ? `, ${count(map.rejected)} rows rejected` : "") + "." + map.notes.map(note => ` Note: ${note}.`).join("");
}
$("file").onchange = () => { if ($("file").files[0]) take($("file").files[0]); $("file").value = ""; };
$("built-in").onclick = () => {
  say("");
  ++taking;
  want("load", {name: "", bytes: null});
};
let inside = 0;
document.addEventListener("dragenter", event => { event.preventDefault(); ++inside; $("drop").hidden = false; });
document.addEventListener("dragleave", () => { if (--inside <= 0) $("drop").hidden = true; });
document.addEventListener("dragover", event => event.preventDefault());
document.addEventListener("drop", event => {
  event.preventDefault();
  inside = 0;
  $("drop").hidden = true;
  const files = event.dataTransfer.files;
  if (files.length === 1) take(files[0]);
  else say(files.length === 0 ? "nothing to open (what was dropped is no file); drop a map or a trajectory"
    : `${files.length} files at once (the page shows one map and one trajectory); drop them one after the other`);
});

// ---- poses -----------------------------------------------------------------------------------------------------------------
function goTo(index) {
  const many = poses.length / 13;
  pose = (index + many) % many;
  const numbers = [...poses.subarray(13 * pose, 13 * pose + 13)], text = `${pose + 1} of ${count(many)}, ${numbers[0].toFixed(2)} s`;
  $("pose").value = pose;
  $("pose").setAttribute("aria-valuetext", text);
  put("pose-text", text);
  look(viewOf(numbers.slice(1), state.view));
}
async function play(on) {
  const was = playing;
  playing = on;
  $("play").textContent = on ? "Pause" : "Play";
  $("play").setAttribute("aria-pressed", on);
  if (was) return;
  while (playing) { // the next pose when the last frame is done, at most 30 a second
    goTo(pose + 1);
    await Promise.all([working, new Promise(done => setTimeout(done, 33))]);
  }
}
$("play").onclick = () => play(!playing);
$("before").onclick = () => goTo(pose - 1);
$("after").onclick = () => goTo(pose + 1);
$("pose").oninput = () => goTo(Number($("pose").value));

// ---- saving and links ------------------------------------------------------------------------------------------------------
function save(what) { // the frame that is shown
  soon(async () => {
    if (!last) throw new Error("nothing to save (there is no picture yet); wait for the first one");
    if (what === "pfm") download("frame_0000.pfm", pfm(await ask("floats")), "application/octet-stream");
    if (what === "json") download("report.json", [(await ask("run")).text], "application/json");
    if (what !== "png") return;
    const blob = await new Promise(done => $("picture").toBlob(done));
    if (blob === null) throw new Error("the PNG cannot be written (memory is short); choose fewer pixels");
    download("frame_0000.png", [blob], "image/png");
  });
}
for (const button of document.querySelectorAll("[data-save]")) button.onclick = () => save(button.dataset.save);
$("link").onclick = async () => {
  awaited = null;
  writeFragment();
  try {
    await navigator.clipboard.writeText(location.href);
    tell("The link is in the clipboard.");
  } catch {
    tell("The link is in the address bar.");
  }
};

// The state as the fragment of a link. What is as at the beginning is left out.
function fragment() {
  const text = new URLSearchParams();
  if (state.view) text.set("view", viewText(state.view));
  if (state.size.join() !== "640,360") text.set("size", state.size.join("x"));
  for (const [name, value] of Object.entries(plain)) if (state.chosen[name] !== value) text.set(name, state.chosen[name]);
  if (state.heat !== "load") text.set("heat", state.heat);
  for (const name of ["tile", "gaussian"]) if (state[name] !== null) text.set(name, state[name]);
  if (state.step >= 0) text.set("superstep", state.step);
  if (state.difference) text.set("difference", 1);
  if (state.file) text.set("file", state.file);
  return text.toString().replaceAll("%2C", ",");
}
function readFragment(link) {
  const text = new URLSearchParams(link.slice(1));
  const whole = (name, otherwise) => /^\d{1,9}$/.test(text.get(name) ?? "") ? Number(text.get(name)) : otherwise;
  state.view = viewFromText(text.get("view"));
  const size = (text.get("size") ?? "").match(/^(\d{2,4})x(\d{2,4})$/);
  state.size = size ? [Number(size[1]), Number(size[2])] : [640, 360];
  for (const [name, value] of Object.entries(plain)) state.chosen[name] = typeof value === "number" ? whole(name, value) : text.get(name) ?? value;
  state.heat = heats.some(([name]) => name === text.get("heat")) ? text.get("heat") : "load";
  [state.tile, state.gaussian, state.step] = [whole("tile", null), whole("gaussian", null), whole("superstep", -1)];
  state.difference = text.get("difference") === "1";
  for (const input of $("maps").querySelectorAll("input")) input.checked = input.value === state.heat;
  return text.get("file");
}
let remembering = 0, written = "";
function remember() {
  clearTimeout(remembering);
  remembering = setTimeout(writeFragment, 300);
}
function writeFragment() {
  if (awaited || !state.view) return; // a link that waits for its file, or for the chip, stays
  written = "#" + fragment();
  history.replaceState(null, "", written);
}
addEventListener("hashchange", () => { // another link was pasted into the address bar
  if (location.hash === written || !map) return;
  say("");
  openLink(location.hash);
  startAgain(); // as a link that is opened
});
// A link to a view of a file shows this view when the file is dropped. Until then the map that is there is shown from its start.
let awaited = null;
function openLink(link) {
  const name = readFragment(link) ?? "";
  awaited = null;
  if (name !== "" && name !== state.file) {
    awaited = {name, link};
    [state.tile, state.gaussian, state.step, state.view] = [null, null, -1, null];
    say(`this link shows another map (${name}); drop that file onto the page`);
  } else if (name === "" && state.file !== "") {
    awaited = {name, link};
    want("load", {name: "", bytes: null});
  }
  state.view ??= startView(map);
}

// ---- beginning -------------------------------------------------------------------------------------------------------------
const begun = (async () => {
  const link = location.hash;
  try {
    ({map, settings} = await ask("map"));
    openLink(link);
    ({settings} = await ask("set", {settings: wantedSettings()}).catch(error => { // the link asks for what no machine has
      say(error.message);
      Object.assign(state, {size: [640, 360], chosen: {...plain}, gaussian: null});
      return ask("set", {settings: wantedSettings()});
    }));
    showMap();
    return true;
  } catch (error) {
    say(error.message);
    tell("There is no picture.");
    return false;
  }
})();
want("settings");
