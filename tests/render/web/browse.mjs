// Opens the page of a light field in Debian's Chromium, without a screen and with software OpenGL, and does what a plan
// says:
//
//   node browse.mjs TOOLS SITE PLAN.json OUT
//
// TOOLS: the folder with node_modules. Prints one JSON object; pictures go to the folder OUT.
import { createRequire } from "node:module";
import { createServer } from "node:http";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { extname, join, normalize, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [tools, site, planFile, out] = process.argv.slice(2);
const require = createRequire(resolve(tools, "package.json"));
const { chromium } = require("playwright-core");
const plan = JSON.parse(readFileSync(planFile, "utf8"));
const report = { messages: [], requests: [], failed: "", apertures: [] };

const types = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8" };
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
  try {
    const bytes = readFileSync(join(site, path));
    response.writeHead(200, { "content-type": types[extname(path)] ?? "application/octet-stream" }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
if (plan.host) await new Promise((done) => server.listen(0, "127.0.0.1", done));
const root = plan.host ? `http://127.0.0.1:${server.address().port}/` : pathToFileURL(site).href.replace(/\/*$/, "/");

// What textures and the drawing buffers really take, by the calls that make them.
function watchTextures() {
  const taken = new Map(); // bytes by texture
  const ofPixel = { R8: 1, R16F: 2, R32F: 4, RGBA8: 4, SRGB8_ALPHA8: 4, DEPTH_COMPONENT24: 4 };
  const gl = WebGL2RenderingContext.prototype;
  const bytes = (format) => {
    const name = Object.keys(ofPixel).find((one) => gl[one] === format);
    if (!name) console.warn(`a texture of an unknown format, ${format}`);
    return ofPixel[name] ?? 16;
  };
  const bindings = () => new Map([[gl.TEXTURE_2D, gl.TEXTURE_BINDING_2D], [gl.TEXTURE_2D_ARRAY, gl.TEXTURE_BINDING_2D_ARRAY]]);
  const watch = (name, size) => {
    const original = gl[name];
    gl[name] = function (...all) {
      taken.set(this.getParameter(bindings().get(all[0])), size(all));
      return original.apply(this, all);
    };
  };
  watch("texStorage3D", ([, , format, width, height, depth]) => bytes(format) * width * height * depth);
  watch("texStorage2D", ([, , format, width, height]) => bytes(format) * width * height);
  watch("texImage2D", ([, , format, width, height]) => bytes(format) * width * height);
  window.takenByTextures = () => {
    const canvas = document.querySelector("canvas");
    return [...taken.values()].reduce((sum, one) => sum + one, 2 * 4 * canvas.width * canvas.height);
  };
}
// When the poster is on the screen; of a page on a host alone.
function watchPoster() {
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) window.posterMs ??= entry.renderTime || entry.loadTime;
  }).observe({ type: "element", buffered: true });
}

const profile = mkdtempSync(join(tmpdir(), "ulf-chromium-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: plan.chromium,
  headless: true,
  viewport: { width: plan.width, height: plan.height },
  deviceScaleFactor: plan.ratio ?? 1,
  colorScheme: plan.scheme ?? "light",
  hasTouch: true,
  args: [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--ignore-gpu-blocklist", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
  ],
});
try {
  const page = context.pages()[0];
  page.on("console", (message) => report.messages.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => report.messages.push(`error: ${error.message}`));
  page.on("request", (request) => report.requests.push(request.url()));
  await page.addInitScript(watchTextures);
  await page.addInitScript(watchPoster);
  const figures = () => page.evaluate(() => ({ ...window.ulfPage.figures }));
  if (plan.mbit) {
    const session = await context.newCDPSession(page);
    await session.send("Network.enable");
    await session.send("Network.emulateNetworkConditions",
      { offline: false, latency: 20, downloadThroughput: plan.mbit * 125000, uploadThroughput: plan.mbit * 125000 });
  }
  await page.waitForTimeout(plan.settle_ms ?? 0); // browsers run before a page is opened
  await page.goto(`${root}index.html`, { waitUntil: "commit" });
  await page.waitForFunction(() => window.ulfPage && (window.ulfPage.figures.frames > 0 || window.ulfPage.figures.failed),
    null, { timeout: 60000 });
  report.first = { ...(await figures()), posterMs: await page.evaluate(() => window.posterMs ?? null) };
  if (plan.firstPicture) await page.screenshot({ path: join(out, plan.firstPicture) });
  await page.waitForFunction(() => window.ulfPage.figures.complete || window.ulfPage.figures.failed, null, { timeout: 240000 });
  report.failed = (await figures()).failed;
  for (const picture of plan.screens ?? []) {
    for (const step of picture.steps ?? []) {
      if (step.key) await page.keyboard.press(step.key);
      if (step.click) await page.click(step.click);
    }
    await page.waitForTimeout(picture.wait_ms ?? 600);
    await page.screenshot({ path: join(out, picture.name) });
  }
  report.colors = await page.evaluate(() => {
    const style = getComputedStyle(document.body);
    return { background: style.backgroundColor, text: style.color };
  });
  if (plan.axe) {
    await page.addScriptTag({ content: readFileSync(require.resolve("axe-core/axe.min.js"), "utf8") });
    report.axe = { violations: [], passes: 0, seen: [] };
    const check = async () => {
      const found = await page.evaluate(async () => {
        const { violations, passes } = await window.axe.run(document);
        const seen = ["lens", "help"].filter((id) => document.getElementById(id).checkVisibility());
        return {
          violations: violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.html).join(" ")}`), passes: passes.length, seen,
        };
      });
      report.axe.violations.push(...found.violations);
      report.axe.passes += found.passes;
      report.axe.seen.push(found.seen.join(" "));
    };
    await check();
    await page.click("#depth_of_field");
    await check();
    await page.click("#depth_of_field");
    await page.click("#show_help");
    await check();
    await page.click("#close_help");
    await page.keyboard.press("Home");
  }
  if (plan.controls) {
    const eye = () => page.evaluate(() => [...window.ulfPage.orbit.eye]);
    const zoom = () => page.evaluate(() => window.ulfPage.orbit.zoom);
    const moved = async (action, what) => {
      const before = JSON.stringify(await what());
      await action();
      await page.waitForTimeout(50);
      return JSON.stringify(await what()) !== before;
    };
    const middle = [plan.width / 2, plan.height / 2];
    const touch = await context.newCDPSession(page);
    const fingers = async (type, ...points) =>
      touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    report.controls = {
      keys: await moved(() => page.keyboard.press("ArrowRight"), eye),
      mouse: await moved(async () => {
        await page.mouse.move(...middle);
        await page.mouse.down();
        await page.mouse.move(middle[0] + 40, middle[1] + 10, { steps: 4 });
        await page.mouse.up();
      }, eye),
      wheel: await moved(() => page.mouse.wheel(0, -200), zoom),
      finger: await moved(async () => {
        await fingers("touchStart", middle);
        for (const dx of [10, 20, 40]) await fingers("touchMove", [middle[0] - dx, middle[1]]);
        await fingers("touchEnd");
      }, eye),
      pinch: await moved(async () => {
        await fingers("touchStart", [middle[0] - 40, middle[1]], [middle[0] + 40, middle[1]]);
        for (const d of [38, 34, 30]) await fingers("touchMove", [middle[0] - d, middle[1]], [middle[0] + d, middle[1]]);
        await fingers("touchEnd");
      }, zoom),
    };
    for (let i = 0; i < 60; ++i) await page.keyboard.press("+");
    report.controls.mostZoom = await zoom();
    await page.keyboard.press("Home");
    const value = (id) => page.evaluate((name) => Number(document.getElementById(name).value), id);
    const focus = () => page.evaluate(() => [...window.ulfPage.focus]);
    const number = (id) => () => value(id);
    Object.assign(report.controls, {
      zoomOut: await moved(() => page.click("#zoom_out"), zoom),
      zoomIn: await moved(() => page.click("#zoom_in"), zoom),
      lensButton: await moved(() => page.click("#depth_of_field"), number("aperture")),
      widerKey: await moved(() => page.keyboard.press("o"), number("aperture")),
      narrowerKey: await moved(() => page.keyboard.press("i"), number("aperture")),
      fartherKey: await moved(() => page.keyboard.press("u"), focus),
      nearerKey: await moved(() => page.keyboard.press("j"), focus),
      click: await moved(() => page.mouse.click(0.3 * plan.width, 0.4 * plan.height), focus),
      fullscreen: await moved(async () => {
        await page.keyboard.press("f");
        await page.waitForTimeout(300);
      }, () => page.evaluate(() => document.fullscreenElement !== null)),
    });
    await page.keyboard.press("f");
    await page.waitForTimeout(300);
    await page.click("#depth_of_field");
    await page.keyboard.press("ArrowRight");
    report.controls.againButton = await moved(() => page.click("#again"), eye);
    report.controls.helpKey = await moved(() => page.keyboard.press("?"), () => page.evaluate(() => document.getElementById("help").open));
    await page.click("#close_help");
    report.controls.tabs = [];
    await page.evaluate(() => document.getElementById("picture").focus());
    for (let i = 0; i < 7; ++i) {
      if (i > 0) await page.keyboard.press("Tab");
      report.controls.tabs.push(await page.evaluate(() => {
        const outline = getComputedStyle(document.activeElement);
        return `${document.activeElement.id} ${outline.outlineStyle !== "none" && parseFloat(outline.outlineWidth) >= 2}`;
      }));
    }
  }
  if (plan.poses?.length) {
    await page.addStyleTag({ content: "main > :not(#stage), #mark { display: none !important } #picture { transition: none !important; outline: none !important }" });
    for (const pose of plan.poses) {
      const before = await page.evaluate(({ eye, zoom, aperture }) => {
        window.ulfPage.lookFrom(eye, zoom);
        window.ulfPage.openLens(aperture ?? 0);
        return window.ulfPage.figures.frames;
      }, pose);
      report.apertures.push(await page.evaluate(() => window.ulfPage.aperture));
      await page.waitForFunction((n) => window.ulfPage.figures.frames > n && window.ulfPage.figures.complete, before,
        { timeout: 60000 });
      await page.waitForTimeout(100);
      await page.screenshot({ path: join(out, pose.name) });
    }
  }
  if (plan.seconds)
    report.pace = await page.evaluate(async (seconds) => {
      const intervals = [], sizes = [];
      const begin = performance.now();
      let last = begin, before = window.ulfPage.figures.frames;
      await new Promise((resolve) => {
        const tick = (now) => {
          const { frames, scale } = window.ulfPage.figures;
          if (frames > before) {
            intervals.push(now - last);
            sizes.push(scale);
            last = now;
            before = frames;
          }
          const t = (now - begin) / 1000;
          window.ulfPage.turn(0.007 * Math.cos(1.1 * t), 0.004 * Math.sin(1.7 * t));
          if (t > seconds) resolve();
          else requestAnimationFrame(tick);
        };
        requestAnimationFrame(tick);
      });
      const late = intervals.slice(Math.floor(intervals.length / 4)); // once the size has settled
      const sorted = [...late].sort((a, b) => a - b);
      return {
        fps: (1000 * late.length) / late.reduce((a, b) => a + b, 0), medianMs: sorted[sorted.length >> 1],
        slowestTenthMs: sorted[Math.floor(0.9 * sorted.length)], size: sizes[sizes.length - 1], frames: intervals.length,
      };
    }, plan.seconds);
  report.textureMegabytes = await page.evaluate(() => 1e-6 * window.takenByTextures());
  report.last = await figures();
} finally {
  await context.close();
  server.close();
  rmSync(profile, { recursive: true, force: true });
}
report.outside = report.requests.filter((url) => !url.startsWith(root) && !url.startsWith("data:") && !url.startsWith("blob:"));
report.requests = report.requests.length;
console.log(JSON.stringify(report));
