// Drives Chromium through the DevTools protocol over two pipes (--remote-debugging-pipe), without any package.
import {spawn} from "node:child_process";
import {mkdtempSync, readFileSync, readdirSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

export const sleep = ms => new Promise(done => setTimeout(done, ms));

/// The milliseconds of processor time that a process and those that it started have used, or NaN where there is no /proc.
export function processorMs(root) {
  try {
    const all = new Map();
    for (const pid of readdirSync("/proc").filter(name => /^\d+$/.test(name)))
      try {
        const words = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ").at(-1).split(" ");
        all.set(Number(pid), {parent: Number(words[1]), ticks: Number(words[11]) + Number(words[12])});
      } catch {} // it ended
    const below = pid => { for (; pid > 1; pid = all.get(pid)?.parent ?? 0) if (pid === root) return true; return false; };
    return [...all].filter(([pid]) => below(pid)).reduce((sum, [, {ticks}]) => sum + 10 * ticks, 0); // 100 ticks a second
  } catch {
    return NaN;
  }
}

/// Starts a browser without a window. `session()` opens a page in it, `close()` ends it and removes its files.
export async function browser(program) {
  const profile = mkdtempSync(join(tmpdir(), "page-"));
  const child = spawn(program, ["--headless", "--no-sandbox", "--remote-debugging-pipe", "--disable-gpu", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-background-timer-throttling", "--disable-renderer-backgrounding",
    "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb", `--user-data-dir=${profile}`, "about:blank"],
    {stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"]});
  const asked = new Map(), heard = [];
  let number = 0, rest = [];
  child.stdio[4].on("data", chunk => { // messages end with a zero byte
    for (let at; (at = chunk.indexOf(0)) >= 0; chunk = chunk.subarray(at + 1), rest = []) {
      const message = JSON.parse(Buffer.concat([...rest, chunk.subarray(0, at)]));
      if (message.id === undefined) { for (const listen of heard) listen(message); continue; }
      const {resolve, reject, method} = asked.get(message.id) ?? {};
      asked.delete(message.id);
      if (!resolve) continue; // it came too late
      if (message.error) reject(new Error(`${method}: ${message.error.message}`));
      else resolve(message.result);
    }
    rest.push(chunk);
  });
  let ended = "";
  const end = why => { ended = why; for (const {reject, method} of asked.values()) reject(new Error(`${why} during ${method}`)); };
  child.on("exit", code => end(`the browser ended (status ${code})`));
  child.on("error", error => end(`the browser does not start (${error.message})`));
  child.stdio[3].on("error", () => {}); // it ended
  const send = (method, params = {}, sessionId) => new Promise((resolve, reject) => {
    if (ended) return reject(new Error(`${ended} before ${method}`));
    const id = ++number, late = setTimeout(() => { asked.delete(id); reject(new Error(`the browser gave no answer to ${method} in 180 s`)); }, 180000);
    const settle = act => value => { clearTimeout(late); act(value); };
    asked.set(id, {resolve: settle(resolve), reject: settle(reject), method});
    child.stdio[3].write(JSON.stringify({id, method, params, sessionId}) + "\0");
  });

  /// A page: a few verbs, and the lists `requests` and `faults` of what it asked a network for and of its uncaught exceptions.
  async function session(width = 1280, height = 900, {dark = false, mobile = false} = {}) {
    const {targetId} = await send("Target.createTarget", {url: "about:blank"});
    const {sessionId} = await send("Target.attachToTarget", {targetId, flatten: true});
    const requests = [], faults = [];
    heard.push(message => {
      if (message.sessionId !== sessionId) { // a worker of the page reports its requests and exceptions in a session of its own
        if (!message.sessionId || !workers.has(message.sessionId)) return;
      }
      const {method, params} = message;
      if (method === "Network.requestWillBeSent") requests.push(params.request.url);
      if (method === "Runtime.exceptionThrown") faults.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      if (method === "Log.entryAdded" && params.entry.level === "error") faults.push(params.entry.text);
      if (method === "Target.attachedToTarget") {
        workers.add(params.sessionId);
        for (const domain of ["Network", "Runtime"]) call2(`${domain}.enable`, {}, params.sessionId);
        call2("Runtime.runIfWaitingForDebugger", {}, params.sessionId);
      }
    });
    const workers = new Set(), call2 = (...all) => send(...all).catch(() => {});
    const call = (method, params = {}) => send(method, params, sessionId);
    for (const domain of ["Page", "Network", "Runtime", "Log"]) await call(`${domain}.enable`);
    await call("Target.setAutoAttach", {autoAttach: true, waitForDebuggerOnStart: true, flatten: true});
    await call("Emulation.setDeviceMetricsOverride", {width, height, deviceScaleFactor: 1, mobile});
    if (mobile) await call("Emulation.setTouchEmulationEnabled", {enabled: true});
    await call("Emulation.setEmulatedMedia", {features: [{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]});
    const page = {
      requests, faults, call,
      open: url => call("Page.navigate", {url}),
      /// The value of an expression in the page, awaited.
      async value(expression) {
        const {result, exceptionDetails} = await call("Runtime.evaluate", {expression: `(async () => (${expression}))()`, awaitPromise: true, returnByValue: true});
        if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
        return result.value;
      },
      /// Waits until an expression is true; long, because a machine may be busy.
      async until(expression, seconds = 300) {
        for (const end = Date.now() + 1000 * seconds; Date.now() < end; await sleep(20)) if (await page.value(expression).catch(() => false)) return;
        throw new Error(`not true after ${seconds} s: ${expression}`);
      },
      mouse: (type, x, y, more = {}) => call("Input.dispatchMouseEvent", {type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1, ...more}),
      async click(x, y) {
        await page.mouse("mousePressed", x, y);
        await page.mouse("mouseReleased", x, y);
      },
      async key(key, code = 0, more = {}) {
        const text = key.length === 1 ? key : key === "Enter" ? "\r" : undefined;
        await call("Input.dispatchKeyEvent", {type: text ? "keyDown" : "rawKeyDown", key, text, windowsVirtualKeyCode: code, ...more});
        await call("Input.dispatchKeyEvent", {type: "keyUp", key, windowsVirtualKeyCode: code, ...more});
      },
      /// Where an element is: left, top, width, height in the window, after it was scrolled into it.
      box: selector => page.value(`(() => { const e = document.querySelector(${JSON.stringify(selector)}); e.scrollIntoView({block: "center", behavior: "instant"});
        const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()`),
      async screenshot(whole = false) {
        const {data} = await call("Page.captureScreenshot", {format: "png", captureBeyondViewport: whole, ...(whole && {clip: await page.value(
          "({x: 0, y: 0, width: document.documentElement.clientWidth, height: document.documentElement.scrollHeight, scale: 1})")})});
        return Buffer.from(data, "base64");
      },
      close: () => send("Target.closeTarget", {targetId}),
    };
    return page;
  }
  async function close() {
    const gone = new Promise(done => ended ? done() : child.on("exit", done));
    await send("Browser.close").catch(() => {});
    await Promise.race([gone, sleep(3000).then(() => child.kill("SIGKILL"))]);
    rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  }
  return {session, close, kill: () => child.kill("SIGKILL"), processorMs: () => processorMs(child.pid)};
}
