// Drives Chromium through the DevTools protocol over two pipes (--remote-debugging-pipe), without any package.
import {spawn} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

export const sleep = ms => new Promise(done => setTimeout(done, ms));

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
      const {resolve, reject, method} = asked.get(message.id);
      asked.delete(message.id);
      if (message.error) reject(new Error(`${method}: ${message.error.message}`));
      else resolve(message.result);
    }
    rest.push(chunk);
  });
  child.on("exit", code => { for (const {reject, method} of asked.values()) reject(new Error(`the browser ended (status ${code}) during ${method}`)); });
  const send = (method, params = {}, sessionId) => new Promise((resolve, reject) => {
    asked.set(++number, {resolve, reject, method});
    child.stdio[3].write(JSON.stringify({id: number, method, params, sessionId}) + "\0");
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
      /// Waits until an expression is true.
      async until(expression, seconds = 60) {
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
    const ended = new Promise(done => child.on("exit", done));
    await send("Browser.close").catch(() => {});
    await Promise.race([ended, sleep(3000).then(() => child.kill("SIGKILL"))]);
    rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  }
  return {session, close};
}
