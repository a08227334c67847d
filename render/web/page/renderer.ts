// Draws a light field as ulf's GL renderer does: the geometry gives each pixel a depth, the blending field the views that
// it is made of; a view that does not see the point has no weight; where hardly any weight is left the nearest views that
// see it fill in.
import { Arrays, GeometryHeader, SceneHeader } from "./data";
import { Camera, Field, LumigraphField, MeshField, ViewCamera, mostViewsOfTriangle, viewCameras } from "./field";
import { Geometry } from "./geometry";
import { Program, Target } from "./gl";
import { Vec3, angleBetween, difference, dot, norm, scaled, sum, times, timesInverse, unit } from "./math";
import { Pictures } from "./pictures";
import {
  apertureFragment, depthFragment, depthVertex, fieldFragment, fieldVertex, fillFragment, fillVertex,
  mostFilling, mostViewsOfDraw, openTilesFragment, pullFragment, pushFragment, screenVertex, tilePx, vectorsOfView,
} from "./shaders";

export interface Aperture {
  /** Of the lens, in units of the light field. */
  radius: number;
  /** A point that is in focus. */
  focus: Vec3;
}

const kinds = [3, 4, 5, 6, 7, 8, 10, mostViewsOfTriangle]; // views of a triangle that there are programs for

export class Renderer {
  readonly cameras: ViewCamera[];
  readonly field: Field;
  readonly pictures: Pictures;
  private coarse: Geometry | null = null; // half of the triangles
  private fine: Geometry | null = null;   // comes later
  private readonly gl: WebGL2RenderingContext;
  private readonly fieldPrograms: (Program | undefined)[] = []; // made when they are first needed
  private readonly nearnessProgram: Program;
  private readonly findOpen: Program;
  private readonly open: Target;
  private readonly fill: Program;
  private readonly drawn: Target;
  private readonly nothing: WebGLVertexArrayObject;
  private apertureProgram: Program | undefined; // made when it is first needed
  private readonly pull: Program;
  private readonly push: Program;
  private readonly depth: Target;
  /** Red, green and blue of the page, which shows where there is no light; 0 to 1. */
  ground: Vec3 = [0, 0, 0];
  private readonly pulled: Target[] = [];
  private readonly pushed: Target[] = [];
  private readonly canDrawFloats: boolean;
  private readonly views: WebGLBuffer;
  private readonly corners = new Float32Array(12);
  private readonly data = new Float32Array(4 * vectorsOfView * mostViewsOfDraw);

  constructor(canvas: HTMLCanvasElement, readonly header: SceneHeader, arrays: Arrays, changed: (view: number) => void) {
    const gl = canvas.getContext("webgl2", {
      alpha: false, // composing what one can see through takes longer, in software much
      antialias: false, depth: false, stencil: false, powerPreference: "high-performance",
    });
    if (!gl) throw new Error("This browser has no WebGL 2, which draws the pictures.");
    this.gl = gl;
    this.canDrawFloats = gl.getExtension("EXT_color_buffer_float") !== null ||
      gl.getExtension("EXT_color_buffer_half_float") !== null;
    this.cameras = viewCameras(arrays, header.views);
    this.field = arrays.has("triangles") ? new MeshField(arrays, this.cameras) : new LumigraphField(header, this.cameras);
    this.pictures = new Pictures(gl, header, this.cameras, () => this.geometry, changed);
    this.nearnessProgram = new Program(gl, depthVertex, depthFragment);
    this.findOpen = new Program(gl, screenVertex, openTilesFragment);
    this.open = new Target(gl, gl.R8, gl.NEAREST);
    this.fill = new Program(gl, fillVertex, fillFragment);
    this.drawn = new Target(gl, gl.RGBA8, gl.NEAREST);
    this.nothing = gl.createVertexArray();
    this.pull = new Program(gl, screenVertex, pullFragment);
    this.push = new Program(gl, screenVertex, pushFragment);
    this.depth = new Target(gl, gl.DEPTH_COMPONENT24, gl.NEAREST);
    this.views = gl.createBuffer();
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.views);
    gl.bufferData(gl.UNIFORM_BUFFER, this.data.byteLength, gl.DYNAMIC_DRAW);
  }

  addGeometry(header: GeometryHeader, arrays: Arrays): void {
    if (!header.geometry) return;
    const geometry = new Geometry(this.gl, this.nearnessProgram, header.geometry, arrays);
    if (header.coarse) this.coarse = geometry;
    else this.fine = geometry;
    this.pictures.geometryChanged();
  }
  private get geometry(): Geometry | null {
    return this.fine ?? this.coarse;
  }

  /** The point of the scene under a pixel. */
  pointAt(camera: Camera, x: number, y: number): Vec3 {
    const ray: Vec3 = [(x - 0.5 * camera.width) / camera.focalPx, (y - 0.5 * camera.height) / camera.focalPx, 1];
    const direction = timesInverse(camera.camFromWorld, ray);
    const toCenter = scaled(unit(camera.eye), -1);
    const atPlane = norm(camera.eye) / Math.max(dot(direction, toCenter), 1e-3);
    return sum(camera.eye, scaled(direction, this.geometry?.hit(camera.eye, direction) ?? atPlane));
  }

  // Writes a view's data for this picture at `index` of a draw.
  private put(index: number, view: number, camera: Camera): void {
    const place = this.pictures.place(view)!;
    const of = this.cameras[view]!;
    const at = 4 * vectorsOfView * index;
    const r = of.camFromWorld, c = camera.camFromWorld;
    const t = sum(times(r, camera.eye), of.translation);
    for (let row = 0; row < 3; ++row) {
      // view_from_cam = view_from_world * world_from_cam
      for (let k = 0; k < 3; ++k)
        this.data[at + 4 * row + k] = r[3 * row]! * c[3 * k]! + r[3 * row + 1]! * c[3 * k + 1]! + r[3 * row + 2]! * c[3 * k + 2]!;
      this.data[at + 4 * row + 3] = t[row]!;
    }
    for (let k = 0; k < 4; ++k) {
      const z = this.data[at + 8 + k]!;
      this.data[at + k] = of.fx * this.data[at + k]! + of.cx * z;
      this.data[at + 4 + k] = of.fy * this.data[at + 4 + k]! + of.cy * z;
    }
    const feather = this.header.feather * Math.min(of.width, of.height);
    const center = times(c, difference(of.center, camera.eye));
    this.data.set([of.width / feather, of.height / feather, place.layer, this.pictures.nearnessFactor(view)], at + 12);
    this.data.set([place.scaleX, place.scaleY, place.offsetX, place.offsetY], at + 16);
    this.data.set([...center, 0], at + 20);
  }

  private uploadViews(count: number): void {
    const gl = this.gl;
    gl.bindBuffer(gl.UNIFORM_BUFFER, this.views);
    gl.bufferData(gl.UNIFORM_BUFFER, this.data.byteLength, gl.DYNAMIC_DRAW);
    gl.bufferSubData(gl.UNIFORM_BUFFER, 0, this.data, 0, 4 * vectorsOfView * count);
    gl.bindBufferBase(gl.UNIFORM_BUFFER, 0, this.views);
  }

  private near(camera: Camera): number {
    return 0.02 * norm(camera.eye);
  }

  // Returns whether holes have depths.
  private drawDepth(camera: Camera, simple: boolean): boolean {
    const gl = this.gl;
    this.depth.bind();
    const geometry = simple ? this.coarse ?? this.fine : this.geometry;
    if (!geometry) {
      gl.clear(gl.DEPTH_BUFFER_BIT);
      return false;
    }
    geometry.drawNearness(camera.camFromWorld, scaled(times(camera.camFromWorld, camera.eye), -1),
      [(2 * camera.focalPx) / camera.width, (-2 * camera.focalPx) / camera.height, 0, 0], this.near(camera));
    if (!this.canDrawFloats) return false;
    const sizes: [number, number][] = [];
    for (let w = (camera.width + 1) >> 1, h = (camera.height + 1) >> 1; w > 1 || h > 1;)
      sizes.push([w = (w + 1) >> 1, h = (h + 1) >> 1]);
    while (this.pulled.length < sizes.length) {
      this.pulled.push(new Target(gl, gl.R16F, gl.NEAREST));
      this.pushed.push(new Target(gl, gl.R16F, gl.LINEAR));
    }
    gl.activeTexture(gl.TEXTURE0);
    this.pull.use().integer("finer", 0).numbers("depth", 0);
    sizes.forEach(([width, height], n) => {
      const target = this.pulled[n]!;
      target.resize(width, height);
      this.pull.integer("ofNearness", n === 0 ? 1 : 0);
      target.bind();
      gl.bindTexture(gl.TEXTURE_2D, n === 0 ? this.depth.texture : this.pulled[n - 1]!.texture);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
    this.push.use().integer("coarser", 0).integer("pulled", 1).numbers("depth", 0);
    for (let n = sizes.length - 2; n >= 0; --n) {
      const target = this.pushed[n]!;
      target.resize(...sizes[n]!);
      target.bind();
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, n === sizes.length - 2 ? this.pulled[n + 1]!.texture : this.pushed[n + 1]!.texture);
      gl.activeTexture(gl.TEXTURE1);
      gl.bindTexture(gl.TEXTURE_2D, this.pulled[n]!.texture);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    return sizes.length > 1;
  }

  private setPixels(program: Program, camera: Camera, focusInverse: number, holes: boolean): void {
    const gl = this.gl, near = this.near(camera), distance = norm(camera.eye);
    const normal = scaled(times(camera.camFromWorld, camera.eye), -1 / distance ** 2);
    program.use().integer("pictures", 0).integer("nearness", 1).integer("holes", 2)
      .numbers("masks", this.pictures.masks && focusInverse === 0 ? 1 : 0)
      .numbers("camera", 0.5 * camera.width, 0.5 * camera.height, 1 / camera.focalPx, 1 / near)
      .numbers("plane", ...normal, 1e-3 / distance).numbers("focusInverse", focusInverse)
      .numbers("holesScale", holes ? 1 / near : 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.pictures.texture);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.depth.texture);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, holes ? this.pushed[0]!.texture : this.depth.texture);
  }

  /**
   * Draws into the canvas; simple: with coarse geometry and three views a triangle, for small pictures that move. Returns the
   * views that the picture is made of, the most important first.
   */
  draw(camera: Camera, aperture: Aperture | null, simple: boolean): number[] {
    const gl = this.gl;
    gl.disable(gl.BLEND);
    this.depth.resize(camera.width, camera.height);
    const holes = aperture ? false : this.drawDepth(camera, simple);
    const focusDepth = aperture ? this.focusDepth(camera, aperture) : 0;
    const through = aperture ? this.viewsThrough(camera, aperture) : [];
    const used = through.length > 0 && aperture ? this.drawAperture(camera, aperture, through, focusDepth)
      : this.drawField(camera, aperture ? 1 / focusDepth : 0, holes, simple);
    return used;
  }

  private focusDepth(camera: Camera, aperture: Aperture): number {
    const focus = times(camera.camFromWorld, difference(aperture.focus, camera.eye));
    return Math.max(focus[2], 1e-3 * norm(focus), 1e-9);
  }

  // The views whose rays go through the lens; none where it is too small for any.
  private viewsThrough(camera: Camera, aperture: Aperture): number[] {
    const within = this.cameras.map((view, index): [number, number] => {
      const center = times(camera.camFromWorld, difference(view.center, camera.eye));
      return [Math.hypot(center[0], center[1]), index];
    }).filter(([off, index]) => off < 1.2 * aperture.radius && this.pictures.place(index))
      .sort((a, b) => a[0] - b[0]).map(([, index]) => index);
    const fewest = 4; // guessed
    return within.length >= fewest ? within.slice(0, mostViewsOfDraw) : [];
  }

  private drawAperture(camera: Camera, aperture: Aperture, views: number[], focusDepth: number): number[] {
    views.forEach((view, index) => this.put(index, view, camera));
    this.uploadViews(views.length);
    const gl = this.gl;
    const program = this.apertureProgram ??= new Program(gl, screenVertex, apertureFragment);
    this.setPixels(program, camera, 1 / focusDepth, false);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, camera.width, camera.height);
    program.integer("count", views.length).numbers("inverseRadius", 1 / aperture.radius).numbers("depth", 0)
      .numbers("ground", ...this.ground);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return views;
  }

  // The views nearest in direction that have a picture.
  private nearestViews(camera: Camera, most: number): number[] {
    return this.byAngle(camera).filter((index) => this.pictures.place(index)).slice(0, most);
  }
  /** All views, the nearest in direction first. */
  byAngle(camera: Camera): number[] {
    return this.cameras.map((view, index): [number, number] => [angleBetween(view.center, camera.eye), index])
      .sort((a, b) => a[0] - b[0]).map(([, index]) => index);
  }

  private drawField(camera: Camera, focusInverse: number, holes: boolean, simple: boolean): number[] {
    const gl = this.gl;
    const filling = this.nearestViews(camera, mostFilling);
    const wanted = new Map<number, number>(); // views with their weights in the middle
    this.drawn.resize(camera.width, camera.height);
    this.drawn.bind();
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.bindVertexArray(this.nothing);
    const triangles = this.field.place(camera, simple);
    const drawing = triangles.map((triangle) => triangle.fans.filter((fan) => this.pictures.place(fan.view)));
    // Of overlapping triangles the last counts. Programs are changed as seldom as that allows.
    let current = -1;
    triangles.forEach((triangle, t) => {
      for (const fan of triangle.fans)
        wanted.set(fan.view, (wanted.get(fan.view) ?? 0) + Math.max(0, fan.numerator[2]) / Math.max(triangle.denominator[2], 1e-9));
      const fans = drawing[t]!;
      if (fans.length === 0) return;
      const kind = kinds.findIndex((most) => most >= fans.length);
      const program = this.fieldPrograms[kind] ??= new Program(gl, fieldVertex, fieldFragment(kinds[kind]!));
      if (kind !== current) this.setPixels(program, camera, focusInverse, holes);
      current = kind;
      const most = kinds[kind]!;
      for (let n = 0; n < most; ++n) {
        const fan = fans[Math.min(n, fans.length - 1)]!;
        this.put(n, fan.view, camera);
        this.data.set(n < fans.length ? fan.numerator : [0, 0, 0], 4 * (vectorsOfView * n + 5));
      }
      triangle.corners.forEach((corner, n) => this.corners.set([corner[0], corner[1], 0, corner[2]], 4 * n));
      program.vectors("own", this.data.subarray(0, 4 * vectorsOfView * most)).vectors("corners", this.corners)
        .numbers("denominator", ...triangle.denominator);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
    filling.forEach((view, index) => this.put(index, view, camera));
    this.uploadViews(filling.length);
    this.open.resize(Math.ceil(camera.width / tilePx), Math.ceil(camera.height / tilePx));
    this.open.bind();
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, this.drawn.texture);
    this.findOpen.use().integer("drawn", 3).numbers("depth", 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    this.drawn.copyToScreen();
    this.setPixels(this.fill, camera, focusInverse, holes);
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_2D, this.drawn.texture);
    gl.activeTexture(gl.TEXTURE4);
    gl.bindTexture(gl.TEXTURE_2D, this.open.texture);
    this.fill.integer("drawn", 3).integer("openTiles", 4).integer("filling", filling.length)
      .numbers("ground", ...this.ground);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, 6, this.open.width * this.open.height);
    gl.bindVertexArray(null);
    const inOrder = [...wanted].sort((a, b) => b[1] - a[1]).map(([view]) => view);
    return [...inOrder, ...filling.filter((view) => !wanted.has(view)).slice(0, 4)];
  }

  /** Waits until what was asked for is drawn. */
  finish(): void {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
