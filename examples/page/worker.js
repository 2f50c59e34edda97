// The worker: one chip behind the C interface of tilemesh.h. The page asks {id, ask, ...}, the worker answers {id, ...} or
// {id, problem}. The page asks for the next frame only when it has the last one, so the newest camera always wins.

let chip = null;

const ready = createTilemesh().then(module => {
  const call = (name, result, types) => module.cwrap("tilemesh_" + name, result, types);
  const handle = call("create", "number", [])();
  if (handle === 0) throw new Error("the chip cannot be made (memory is short); close other pages and load this one again");
  const api = {
    error: call("error", "string", ["number"]),
    load: call("load", "number", ["number", "string", "number", "number"]),
    trajectory: call("trajectory", "string", ["number", "string", "number", "number"]),
    set: call("set", "number", ["number", "string"]),
    render: call("render", "number", ["number", "number"]),
    pixels: call("pixels", "number", ["number", "string"]),
    report: call("report", "string", ["number", "string"]),
    heat: call("heat", "number", ["number", "string", "number"]),
    tile: call("tile", "string", ["number", "number"]),
    gaussian: call("gaussian", "string", ["number", "number"]),
  };
  // Calls a function of the interface; its error, one line, becomes an exception. A text of NULL arrives as "".
  const run = (name, ...parameters) => {
    const result = api[name](handle, ...parameters);
    if (result === 0 || result === "") throw new Error(api.error(handle));
    return result;
  };
  const withBytes = (bytes, use) => {
    const at = module._malloc(bytes.byteLength || 1);
    if (at === 0) throw new Error("the file cannot be read (memory is short); open a smaller one");
    try {
      module.HEAPU8.set(bytes, at);
      return use(at);
    } finally {
      module._free(at);
    }
  };
  chip = {
    run, withBytes,
    json: (name, ...parameters) => JSON.parse(run(name, ...parameters)),
    bytes: (at, length) => module.HEAPU8.slice(at, at + length), // a copy: the next call may move or change the memory
    floats: (at, length) => module.HEAPF32.slice(at >> 2, (at >> 2) + length),
    doubles: numbers => new Uint8Array(Float64Array.from(numbers).buffer),
    memory: () => module.HEAPU8.length,
  };
});

function load({name, bytes}) {
  if (bytes === null) chip.run("load", null, 0, 0);
  else chip.withBytes(new Uint8Array(bytes), at => chip.run("load", name, at, bytes.byteLength));
  return facts();
}
function facts() { // the start camera of the map is one for the settings' width
  const settings = chip.json("report", "settings");
  return {map: {...chip.json("report", "map"), width: settings.width}, settings};
}

const mostRecords = 120; // buttons that a browser changes in a few milliseconds
// What the page shows of the last frame. `superstep` -1: the whole frame. A number beyond the last superstep is the last one. `tile`
// undefined: the page keeps what it shows of the tile.
function details({heat, superstep, tile, gaussian}) {
  const frame = chip.json("report", "frame"), tiles = frame.columns * frame.rows, at = Math.min(superstep, frame.supersteps - 1);
  const shown = tile === undefined ? undefined : tile !== null && tile < tiles ? chip.json("tile", tile) : null;
  return {
    frame, superstep: at, step: at < 0 ? null : chip.json("report", "supersteps")[at],
    heat: chip.floats(chip.run("heat", heat, at), tiles),
    tile: shown && {...shown, list: shown.list.slice(0, mostRecords)},
    gaussian: gaussian !== null ? chip.json("gaussian", gaussian) : null,
    memory: chip.memory(),
  };
}

function render({camera, picture, show}) {
  const begin = performance.now();
  chip.withBytes(chip.doubles(camera), at => chip.run("render", at));
  const shown = details(show);
  const pixels = chip.bytes(chip.run("pixels", picture), 4 * shown.frame.width * shown.frame.height);
  return {...shown, pixels, ms: performance.now() - begin};
}

// The Gaussian at a pixel of the last frame: of the tile's nearest 500, the one that adds most there. Its footprint is taken as a
// disc of `radius`, which is three standard deviations; the rest of the light goes on to the Gaussians behind.
function pick({x, y}) {
  const frame = chip.json("report", "frame");
  const tile = Math.floor(x / frame.tile_width) + frame.columns * Math.floor(y / frame.tile_height);
  let light = 1, most = 0, gaussian = null;
  for (const record of chip.json("tile", tile).list) {
    const far = ((record.x - x) ** 2 + (record.y - y) ** 2) / Math.max(record.radius, 0.5) ** 2;
    if (far > 1) continue;
    const alpha = Math.min(0.99, record.opacity * Math.exp(-4.5 * far));
    if (light * alpha > most) [most, gaussian] = [light * alpha, record.id];
    light *= 1 - alpha;
  }
  return {tile, gaussian};
}

// Poses as numbers, 13 for each: seconds, rotation, position. The page gets them without a copy.
function poses({name, bytes}) {
  const {poses, ...rest} = chip.withBytes(new Uint8Array(bytes), at => chip.json("trajectory", name, at, bytes.byteLength));
  const numbers = new Float64Array(13 * poses.length);
  poses.forEach(({seconds, rotation, position}, i) => numbers.set([seconds, ...rotation, ...position], 13 * i));
  return {...rest, numbers};
}

const answers = {
  load, render, pick, poses, map: facts,
  set: ({settings}) => (chip.run("set", JSON.stringify(settings)), {settings: chip.json("report", "settings")}),
  show: ({show}) => details(show),
  digest: () => ({digest: chip.json("report", "digest")}),
  run: () => ({text: chip.run("report", "run")}),
  floats: () => {
    const {width, height} = chip.json("report", "frame");
    return {width, height, rgb: chip.floats(chip.run("pixels", "rgb_float"), 3 * width * height)};
  },
};

onmessage = async ({data}) => {
  try {
    await ready.catch(error => { throw new Error(`the chip cannot start (${error.message ?? error}); use Chromium 111, Firefox 113, Safari 16.4, or later`); });
    const answer = answers[data.ask](data);
    const buffers = Object.values(answer).filter(ArrayBuffer.isView).map(array => array.buffer); // the page gets them without a copy
    postMessage({id: data.id, ...answer}, buffers);
  } catch (error) {
    const stopped = error instanceof WebAssembly.RuntimeError; // a trap: nothing can be asked any more
    postMessage({id: data.id, problem: stopped ? `the chip stopped (${error.message}); load this page again` : String(error.message ?? error)});
  }
};
