// Draws views of a file of Gaussians with Spark (npm's @sparkjsdev/spark, on three.js) in Debian's Chromium,
// without a screen and with software OpenGL:
//
//   node view_splats.mjs TOOLS PLAN.json OUT
//
// TOOLS: the folder with node_modules. PLAN: {"file": PATH, "views": [{"name", "width", "height", "fx", "fy", "cx",
// "cy", "cam_from_world": 16 numbers by rows}]}, all views of one size. Each picture goes to OUT/NAME.rgb, rows from
// the top, 3 bytes a pixel. Prints one JSON object.
import { createRequire } from "node:module";
import { createServer } from "node:http";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, extname, join, normalize, resolve } from "node:path";

const [tools, planFile, out] = process.argv.slice(2);
const { chromium } = createRequire(resolve(tools, "package.json"))("playwright-core");
const plan = JSON.parse(readFileSync(planFile, "utf8"));
const report = { messages: [], splats: 0, views: 0, failed: "" };

const imports = {
  three: "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/",
  spark: "/node_modules/@sparkjsdev/spark/dist/spark.module.js",
};

// Runs in the page. A camera of the light field looks along +z with y down, one of three.js along -z with y up.
async function prepare(plan, file) {
  const THREE = await import("three");
  const { width, height } = plan.views[0];
  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(0x000000, 1);
  document.body.appendChild(renderer.domElement);
  const camera = new THREE.PerspectiveCamera(50, width / height, 0.01, 10000);
  camera.matrixAutoUpdate = false;
  const place = (view) => {
    const m = view.cam_from_world;
    const turned = [m.slice(0, 4), m.slice(4, 8).map((v) => -v), m.slice(8, 12).map((v) => -v), [0, 0, 0, 1]].flat();
    camera.matrix.set(...turned).invert();
    camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
    camera.matrixWorld.copy(camera.matrix);
    camera.matrixWorldInverse.copy(camera.matrix).invert();
    const { fx, fy, cx, cy, width: w, height: h } = view;
    const [near, far] = [camera.near, camera.far];
    camera.projectionMatrix.set(
      (2 * fx) / w, 0, 1 - (2 * cx) / w, 0,
      0, (2 * fy) / h, (2 * cy) / h - 1, 0,
      0, 0, -(far + near) / (far - near), (-2 * far * near) / (far - near),
      0, 0, -1, 0,
    );
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  };
  const pixels = () => {
    const gl = renderer.getContext();
    const rgba = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    let text = "";
    for (let y = height - 1; y >= 0; --y)
      for (let x = 0; x < width; ++x)
        for (let c = 0; c < 3; ++c) text += String.fromCharCode(rgba[4 * (y * width + x) + c]);
    return btoa(text);
  };
  const scene = new THREE.Scene();
  const { SparkRenderer, SplatMesh } = await import("spark");
  // As Inria's rasteriser: 0.3 px squared are added and opacities stay (Spark's own way is for Gaussians that were
  // trained with antialiasing), depths are sorted along the axis, and places have 32 bits.
  const spark = new SparkRenderer({
    renderer, preBlurAmount: 0.3, blurAmount: 0, accumExtSplats: true, sortRadial: false, maxStdDev: 3.33,
    autoUpdate: false, enableLod: false,
  });
  scene.add(spark);
  const bytes = new Uint8Array(await (await fetch(file)).arrayBuffer());
  const mesh = new SplatMesh({ fileBytes: bytes, fileName: file, extSplats: true, lod: false });
  await mesh.initialized;
  if (file.endsWith(".spz")) mesh.quaternion.set(1, 0, 0, 0); // y and z of SPZ are the other way round
  scene.add(mesh);
  window.splatCount = mesh.splats?.getNumSplats?.() ?? mesh.numSplats;
  window.draw = async (view) => {
    place(view);
    scene.updateMatrixWorld();
    await spark.update({ scene, camera }); // returns when all are sorted for this camera
    renderer.render(scene, camera);
    return pixels();
  };
}

const page_html = `<!doctype html><script type="importmap">${JSON.stringify({ imports })}</script><body></body>`;
const types = { ".js": "text/javascript", ".html": "text/html", ".wasm": "application/wasm" };
const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
  try {
    const bytes = path === "/" ? page_html
                : path === `/${basename(plan.file)}` ? readFileSync(plan.file)
                                                      : readFileSync(join(tools, path));
    response.writeHead(200, { "content-type": path === "/" ? "text/html" : (types[extname(path)] ?? "application/octet-stream") }).end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const profile = mkdtempSync(join(tmpdir(), "splats-"));
let context;
try {
  context = await chromium.launchPersistentContext(profile, {
    executablePath: "/usr/bin/chromium", headless: true,
    args: ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
           "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  const page = await context.newPage();
  page.setDefaultTimeout(600000);
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && report.messages.push(message.text()));
  page.on("pageerror", (error) => report.messages.push(String(error)));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.evaluate(`window.prepare = ${prepare}`);
  await page.evaluate(([p, f]) => window.prepare(p, f), [plan, `/${basename(plan.file)}`]);
  report.splats = await page.evaluate(() => window.splatCount);
  for (const view of plan.views) {
    const text = await page.evaluate((v) => window.draw(v), view);
    writeFileSync(join(out, `${view.name}.rgb`), Buffer.from(text, "base64"));
    ++report.views;
  }
} catch (error) {
  report.failed = String(error);
} finally {
  await context?.close();
  server.close();
  rmSync(profile, { recursive: true, force: true });
}
console.log(JSON.stringify(report));
