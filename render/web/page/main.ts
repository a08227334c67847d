// The page: loads the light field, first a few small pictures, and lets one look around in it.
import { Arrays, GeometryHeader, Header, SceneHeader, load, receiveData } from "./data";
import { Vec3, clamp, difference, norm, scaled, sum, timesInverse, times } from "./math";
import { Orbit, mostZoom, startingZoom } from "./orbit";
import { Pace, simpleSize } from "./pace";
import { listen } from "./input";
import { Aperture, Renderer } from "./renderer";

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

/** The picture that stands there until the page draws, at the zoom with which the page begins. Ends when it can be seen. */
async function showPoster(): Promise<void> {
  const poster = document.getElementById("poster") as HTMLImageElement | null;
  if (!poster) return;
  const numbers = (text = ""): number[] => text.split(" ").map(Number);
  const [width = 1, height = 1, focal = 1] = numbers(poster.dataset.lens);
  const [radius = 0, distance = 1] = numbers(poster.dataset.subject);
  const zoom = startingZoom({ width, height, focal }, radius, distance, innerWidth || 1, innerHeight || 1);
  poster.style.transform = `scale(${zoom})`;
  poster.style.opacity = "1";
  await poster.decode().catch(() => undefined); // then the page begins without it
  await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
}

const after = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

class Page {
  private readonly canvas = element<HTMLCanvasElement>("picture");
  private readonly progress = element("progress");
  private readonly status = element("status");
  private readonly apertureSlider = element<HTMLInputElement>("aperture");
  private readonly focusSlider = element<HTMLInputElement>("focus");
  private readonly lens = element("lens");
  private readonly help = element<HTMLDialogElement>("help");
  private renderer: Renderer | null = null;
  private header: SceneHeader | null = null;
  private orbit: Orbit | null = null;
  private readonly waiting: [Header, Uint8Array<ArrayBuffer>][] = []; // came before the cameras
  private readonly pace = new Pace();
  private focus: Vec3 = [0, 0, 0];
  private shown: number[] = []; // views of the last picture
  private asked = false;        // a frame
  private movedAt = -Infinity;
  private hasMoved = false;     // since the last frame
  private moves = false;        // in the last frame
  private lastFrameAt = 0;
  private later = 0;            // a frame, asked for by a timer
  private begun: () => void = () => undefined; // when the first frame is drawn
  private readonly hasBegun = new Promise<void>((resolve) => (this.begun = resolve));
  private loadedBytes = 0;
  private hasTurned = false;
  /** For tests: what the last frames were like. */
  readonly figures = { frames: 0, firstPictureMs: 0, complete: false, scale: 1, failed: "" };

  constructor() {
    // Starting the graphics holds the browser up: not before the poster is seen, which a hidden page never shows.
    const patienceMs = 400;
    const posterSeen = Promise.race([showPoster(), after(patienceMs)]);
    receiveData((header, bytes) => {
      if (header.kind === "scene") void posterSeen.then(() => this.receive(header, bytes));
      else this.receive(header, bytes);
    });
    this.connect();
  }

  private receive(header: Header, bytes: Uint8Array<ArrayBuffer>): void {
    try {
      if (header.kind === "scene") this.begin(header, bytes);
      else if (!this.renderer) this.waiting.push([header, bytes]);
      else if (header.kind === "geometry") this.renderer.addGeometry(header as GeometryHeader, new Arrays(header.arrays, bytes));
      else for (const [view, at, size] of header.views) {
        const picture = bytes.slice(at, at + size);
        if (header.kind === "fine") this.renderer.pictures.addFine(view, picture);
        else void this.renderer.pictures.addSmall(view, picture).catch((error: unknown) => this.fail(error));
      }
      if (header.kind === "fine") this.fetch();
      else if (header.kind === "geometry") this.draw();
    } catch (error) {
      this.fail(error);
    }
  }

  private begin(header: SceneHeader, bytes: Uint8Array<ArrayBuffer>): void {
    this.header = header;
    this.renderer = new Renderer(this.canvas, header, new Arrays(header.arrays, bytes),
      (view) => this.arrived(view));
    if (header.masks) this.renderer.pictures.noteMasks();
    const takeGround = (): void => {
      const levels = getComputedStyle(document.body).backgroundColor.match(/[\d.]+/g) ?? [];
      const [red = 0, green = 0, blue = 0] = levels.map((level) => Number(level) / 255);
      if (this.renderer) this.renderer.ground = [red, green, blue];
      this.draw();
    };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", takeGround);
    this.orbit = new Orbit(header, this.renderer.field);
    const { width, height } = this.size(1);
    this.orbit.reset(width, height);
    takeGround();
    for (const [kind, data] of this.waiting.splice(0)) this.receive(kind, data);
    new ResizeObserver(() => {
      const now = this.size(1);
      this.orbit?.setZoom(this.orbit.zoom, now.width, now.height);
      this.draw();
    }).observe(this.canvas);
    this.canvas.addEventListener("webglcontextlost", () => this.say("The device took the graphics away. Reload the page."));
    addEventListener("load", () => void this.loadRest(header));
    if (document.readyState === "complete") void this.loadRest(header);
  }

  private async loadRest(header: SceneHeader): Promise<void> {
    const patienceMs = 3000;
    await Promise.race([this.hasBegun, after(patienceMs)]);
    const all = header.files.reduce((total, [, size]) => total + size, 0);
    const queue = [...header.files];
    const worker = async (): Promise<void> => {
      for (let next = queue.shift(); next; next = queue.shift()) {
        await load(next[0]);
        this.loadedBytes += next[1];
        const share = all > 0 ? this.loadedBytes / all : 1;
        this.progress.style.setProperty("--share", share.toFixed(3));
        this.progress.setAttribute("aria-valuenow", String(Math.round(100 * share)));
      }
    };
    try {
      await Promise.all([worker(), worker()]);
      this.progress.classList.add("done");
      this.progress.setAttribute("aria-hidden", "true");
      this.status.textContent = "All pictures are loaded.";
    } catch (error) {
      this.progress.classList.add("done");
      this.say("Some pictures could not be loaded. Reload the page to try again.");
      console.warn(error);
    }
    this.draw();
  }

  private say(text: string): void {
    const message = element("message");
    message.textContent = text;
    message.hidden = false;
  }
  private fail(error: unknown): void {
    this.figures.failed = String(error);
    this.say(error instanceof Error && error.message.startsWith("This browser") ? error.message
      : "The light field cannot be shown here.");
    console.error(error);
  }

  // Of the drawing buffer: the canvas's pixels, but no more than are worth drawing.
  private size(scale: number): { width: number; height: number } {
    const mostPixels = 2.6e6;
    const cssWidth = this.canvas.clientWidth || 1, cssHeight = this.canvas.clientHeight || 1;
    const ratio = Math.min(devicePixelRatio || 1, 2, Math.sqrt(mostPixels / (cssWidth * cssHeight)));
    return {
      width: Math.max(1, Math.round(cssWidth * ratio * scale)), height: Math.max(1, Math.round(cssHeight * ratio * scale)),
    };
  }

  private get aperture(): Aperture | null {
    const value = Number(this.apertureSlider.value);
    if (!this.header || !this.orbit || value <= 0) return null;
    // From somewhat more than the viewpoints are apart to half of what they span.
    const distance = norm(this.orbit.eye), spacing = (this.header.spacing || 0.1) * distance;
    return { radius: spacing * 1.3 * (0.35 * distance / (1.3 * spacing)) ** ((value - 1) / 99), focus: this.focus };
  }

  draw(): void {
    if (this.asked || !this.renderer) return;
    this.asked = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    this.asked = false;
    if (!this.renderer || !this.orbit || this.renderer.pictures.shown === 0) return;
    const restMs = 180;
    const moves = this.hasMoved || now - this.movedAt < restMs;
    this.hasMoved = false;
    const isFirst = this.figures.frames === 0;
    const scale = isFirst ? simpleSize : moves ? this.pace.size : 1; // the first is to be there soon
    const { width, height } = this.size(scale);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const simple = isFirst || (moves && this.pace.simple);
    this.shown = this.renderer.draw(this.orbit.camera(width, height), this.aperture, simple);
    this.fetch();
    if (isFirst) {
      this.renderer.finish();
      this.figures.firstPictureMs = performance.now();
      document.body.classList.add("shows");
      setTimeout(() => document.getElementById("poster")?.remove(), 500); // when the canvas has faded in
      this.begun();
      this.draw();
    }
    ++this.figures.frames;
    this.figures.scale = scale;
    this.figures.complete = this.progress.classList.contains("done") && !this.renderer.pictures.waits(this.shown);
    if (moves) {
      if (this.moves) this.pace.note(now - this.lastFrameAt);
      this.draw(); // until it rests
    }
    this.moves = moves;
    this.lastFrameAt = now;
  }

  // Fine pictures: of what is shown, then of what may be shown next.
  private fetch(): void {
    if (!this.renderer || !this.orbit) return;
    const { pictures } = this.renderer;
    const ahead = Math.floor(0.8 * pictures.fineViews);
    const around = this.renderer.byAngle(this.orbit.camera(1, 1)).slice(0, ahead);
    pictures.want([...this.shown, ...around.filter((view) => !this.shown.includes(view))]);
  }
  private arrived(view: number): void {
    if (this.figures.frames > 0 && !this.shown.includes(view)) return this.fetch();
    // What is on the screen gets better a few times a second: more would only hold loading up.
    const patienceMs = this.figures.frames === 0 ? 0 : 250;
    const wait = this.lastFrameAt + patienceMs - performance.now();
    if (wait <= 0) this.draw();
    else if (!this.later) this.later = setTimeout(() => {
      this.later = 0;
      this.draw();
    }, wait);
    this.fetch();
  }

  private moved(): void {
    this.movedAt = performance.now();
    this.hasMoved = true;
    this.draw();
  }
  turn(right: number, up: number): void {
    if (this.orbit?.turn(right, up)) this.moved();
    if (!this.hasTurned) {
      this.hasTurned = true;
      document.body.classList.add("used");
    }
  }
  zoomBy(factor: number): void {
    if (!this.orbit) return;
    const { width, height } = this.size(1);
    this.orbit.setZoom(this.orbit.zoom * factor, width, height);
    this.showZoom();
    this.moved();
  }
  private showZoom(): void {
    if (!this.orbit) return;
    const { width, height } = this.size(1);
    element<HTMLButtonElement>("zoom_in").disabled = this.orbit.zoom >= mostZoom - 1e-6;
    element<HTMLButtonElement>("zoom_out").disabled = this.orbit.zoom <= this.orbit.leastZoom(width, height) + 1e-6;
  }
  private reset(): void {
    if (!this.orbit) return;
    const { width, height } = this.size(1);
    this.orbit.reset(width, height);
    this.apertureSlider.value = "0";
    this.setFocus([0, 0, 0]);
    this.showZoom();
    this.moved();
  }

  // A point into focus; the slider goes to where it is.
  private setFocus(point: Vec3): void {
    this.focus = point;
    if (!this.orbit || !this.header) return;
    const camera = this.orbit.camera(1, 1);
    const depth = times(camera.camFromWorld, difference(point, camera.eye))[2];
    this.focusSlider.value = String((100 * (depth / norm(camera.eye) - 0.6)) / 0.9);
    this.draw();
  }
  private focusAt(x: number, y: number): void {
    if (!this.orbit || !this.renderer || !this.aperture) return;
    const area = this.canvas.getBoundingClientRect();
    const camera = this.orbit.camera(Math.round(area.width), Math.round(area.height));
    this.setFocus(this.renderer.pointAt(camera, x - area.left, y - area.top));
    const mark = element("mark");
    mark.style.left = `${x - area.left}px`;
    mark.style.top = `${y - area.top}px`;
    mark.classList.remove("seen");
    void mark.offsetWidth; // so that the animation begins again
    mark.classList.add("seen");
  }
  private focusFromSlider(): void {
    if (!this.orbit) return;
    const camera = this.orbit.camera(1, 1);
    const depth = norm(camera.eye) * (0.6 + (0.9 * Number(this.focusSlider.value)) / 100);
    this.focus = sum(camera.eye, timesInverse(camera.camFromWorld, scaled([0, 0, 1], depth)));
    this.moved();
  }
  private step(slider: HTMLInputElement, by: number): void {
    slider.value = String(clamp(Number(slider.value) + by, 0, 100));
    slider.dispatchEvent(new Event("input"));
  }
  private toggleLens(open = this.lens.hidden): void {
    this.lens.hidden = !open;
    element("depth_of_field").setAttribute("aria-expanded", String(open));
    document.body.classList.add("used");
    if (open && Number(this.apertureSlider.value) === 0) this.step(this.apertureSlider, 35);
    if (open) this.apertureSlider.focus();
  }
  private async toggleFullscreen(): Promise<void> {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await document.documentElement.requestFullscreen();
  }

  private key(event: KeyboardEvent): boolean {
    if (this.help.open) return false;
    const turnRad = event.shiftKey ? 0.01 : 0.05;
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.turn(-turnRad, 0),
      ArrowRight: () => this.turn(turnRad, 0),
      ArrowUp: () => this.turn(0, turnRad),
      ArrowDown: () => this.turn(0, -turnRad),
      "+": () => this.zoomBy(1.1),
      "=": () => this.zoomBy(1.1),
      "-": () => this.zoomBy(1 / 1.1),
      Home: () => this.reset(),
      "0": () => this.reset(),
      o: () => this.step(this.apertureSlider, 5),
      i: () => this.step(this.apertureSlider, -5),
      u: () => this.step(this.focusSlider, 3),
      j: () => this.step(this.focusSlider, -3),
      f: () => void this.toggleFullscreen().catch(() => undefined),
      "?": () => this.help.showModal(),
      Escape: () => this.toggleLens(false),
    };
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (event.key === "Escape" && this.lens.hidden) return false;
    action?.();
    return action !== undefined;
  }

  private connect(): void {
    listen(this.canvas, {
      turn: (right, up) => this.turn(right, up),
      zoomBy: (factor) => this.zoomBy(factor),
      focusAt: (x, y) => this.focusAt(x, y),
      key: (event) => this.key(event),
      rest: () => this.draw(),
    });
    const click = (id: string, action: () => void): void => element(id).addEventListener("click", action);
    click("zoom_in", () => this.zoomBy(1.25));
    click("zoom_out", () => this.zoomBy(1 / 1.25));
    click("again", () => this.reset());
    click("depth_of_field", () => this.toggleLens());
    click("show_help", () => this.help.showModal());
    click("close_help", () => this.help.close());
    this.help.addEventListener("click", (event) => {
      if (event.target === this.help) this.help.close();
    });
    const fullscreen = element<HTMLButtonElement>("fullscreen");
    if (document.fullscreenEnabled) {
      fullscreen.addEventListener("click", () => void this.toggleFullscreen().catch(() => undefined));
      document.addEventListener("fullscreenchange", () =>
        fullscreen.setAttribute("aria-pressed", String(document.fullscreenElement !== null)));
    } else {
      fullscreen.hidden = true;
    }
    this.apertureSlider.addEventListener("input", () => this.moved());
    this.focusSlider.addEventListener("input", () => this.focusFromSlider());
  }

  /** For tests: looks from a place, in full size. */
  lookFrom(eye: Vec3, zoom: number): void {
    if (!this.orbit) return;
    this.orbit.eye = eye;
    this.orbit.zoom = zoom;
    this.draw();
  }
  /** For tests: the aperture, 0 (closed) to 100. */
  openLens(value: number): void {
    this.apertureSlider.value = String(value);
    this.draw();
  }
}

(window as unknown as { ulfPage: Page }).ulfPage = new Page();
