// The views' pictures in graphics memory: small ones of all views, sixteen in a layer, and fine ones of as many views as
// fit, those that are drawn before those that are not.
import { Program, Target, texture } from "./gl";
import { SceneHeader } from "./data";
import { ViewCamera } from "./field";
import { Geometry } from "./geometry";
import { norm } from "./math";
import { hidesFragment, openFragment, screenVertex, widenFragment } from "./shaders";

/** Of the views' textures; with what a large window takes it is 150 MB, and phones end pages that take much more. */
export const mostTextureBytes = 125e6;
const hidesPx = 256; // as kShadowMapPx
const mostDecoding = 3;

/** Where a view's picture lies. */
export interface Place {
  layer: number;
  scaleX: number;
  scaleY: number;
  offsetX: number;
  offsetY: number;
  fine: boolean;
}

interface Slot {
  view: number;
  usedAt: number;
}

export class Pictures {
  readonly texture: WebGLTexture;
  readonly bytes: number;
  private readonly frame: WebGLFramebuffer;
  private readonly width: number;
  private readonly height: number;
  private readonly smallWidth: number;
  private readonly smallHeight: number;
  private readonly smallLayers: number;
  private readonly places: (Place | undefined)[];
  private readonly smallIn: boolean[];
  private readonly small: (Blob | undefined)[];
  private readonly slots: Slot[] = [];
  private readonly fine: (Blob | undefined)[];
  private readonly decoding = new Set<number>();
  private readonly hides: WebGLTexture;
  private readonly hidesFrame: WebGLFramebuffer;
  private readonly hidesOf: number[];  // of each layer the view whose it is
  private readonly nearness: Target;
  private readonly narrow: Target;
  private readonly narrowProgram: Program;
  private readonly widenProgram: Program;
  private readonly openProgram: Program;
  private drawing = 0;
  private hasMasks = false;
  /** Views that have something to show. */
  shown = 0;

  constructor(
    private readonly gl: WebGL2RenderingContext, header: SceneHeader, private readonly cameras: ViewCamera[],
    private readonly geometry: () => Geometry | null, private readonly changed: (view: number) => void,
  ) {
    [this.width, this.height] = header.picture;
    const perSide = header.small;
    this.smallWidth = Math.max(1, Math.floor(this.width / perSide));
    this.smallHeight = Math.max(1, Math.floor(this.height / perSide));
    this.smallLayers = Math.ceil(header.views / perSide ** 2);
    this.places = new Array<Place | undefined>(header.views);
    this.smallIn = new Array<boolean>(header.views).fill(false);
    this.small = new Array<Blob | undefined>(header.views);
    this.fine = new Array<Blob | undefined>(header.views);
    const mostLayers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number;
    const ofLayer = 4 * this.width * this.height;
    const hidesLayers = Math.min(header.views, mostLayers);
    const forFine = Math.floor((mostTextureBytes - hidesLayers * hidesPx ** 2) / ofLayer) - this.smallLayers;
    const fineLayers = Math.max(1, Math.min(header.views, forFine, mostLayers - this.smallLayers));
    this.bytes = (this.smallLayers + fineLayers) * ofLayer + hidesLayers * hidesPx ** 2;
    this.texture = texture(gl, gl.TEXTURE_2D_ARRAY, gl.LINEAR);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.SRGB8_ALPHA8, this.width, this.height, this.smallLayers + fineLayers);
    this.frame = gl.createFramebuffer();
    for (let i = 0; i < fineLayers; ++i) this.slots.push({ view: -1, usedAt: -1 });
    this.hides = texture(gl, gl.TEXTURE_2D_ARRAY, gl.LINEAR);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.R8, hidesPx, hidesPx, hidesLayers);
    this.hidesFrame = gl.createFramebuffer();
    this.hidesOf = new Array<number>(hidesLayers).fill(-1);
    this.nearness = new Target(gl, gl.DEPTH_COMPONENT24, gl.NEAREST);
    this.narrow = new Target(gl, gl.R8, gl.NEAREST);
    this.nearness.resize(hidesPx, hidesPx);
    this.narrow.resize(hidesPx, hidesPx);
    this.narrowProgram = new Program(gl, screenVertex, hidesFragment);
    this.widenProgram = new Program(gl, screenVertex, widenFragment);
    this.openProgram = new Program(gl, screenVertex, openFragment);
    this.radius = header.radius;
  }
  private readonly radius: number;

  place(view: number): Place | undefined {
    return this.places[view];
  }
  /** Whether pictures have an alpha that hides something. */
  get masks(): boolean {
    return this.hasMasks || this.geometry() !== null;
  }
  /** The factor of a view's inverse depths: what is nearer than the subject counts as one depth. */
  nearnessFactor(view: number): number {
    const distance = norm(this.cameras[view]!.center);
    const nearest = this.radius < 0.5 * distance ? (distance - this.radius) / 1.25 : distance / 2.5;
    return Math.max(nearest, 1e-9);
  }

  addSmall(view: number, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    this.small[view] = new Blob([bytes], { type: "image/webp" });
    return this.readSmall(view);
  }
  private async readSmall(view: number): Promise<void> {
    const blob = this.small[view];
    if (!blob) return;
    await this.decode(view, blob, this.smallWidth, this.smallHeight, (bitmap) => {
      const perSide = Math.round(this.width / this.smallWidth), k = view % perSide ** 2;
      const x = (k % perSide) * this.smallWidth, y = Math.floor(k / perSide) * this.smallHeight;
      if (!this.smallIn[view]) ++this.shown;
      this.smallIn[view] = true;
      const place = this.smallPlace(view);
      this.upload(view, bitmap, place.layer, x, y, this.smallWidth, this.smallHeight);
      if (!this.places[view]) this.places[view] = place;
    });
  }
  /** Reads all pictures again: each keeps in its alpha what the geometry of that time hid from it. */
  geometryChanged(): void {
    this.hidesOf.fill(-1);
    for (const slot of this.slots) {
      if (slot.view >= 0) this.places[slot.view] = this.smallIn[slot.view] ? this.smallPlace(slot.view) : undefined;
      slot.view = -1;
    }
    this.small.forEach((blob, view) => blob && void this.readSmall(view).catch(() => undefined)); // as it was
  }
  private smallPlace(view: number): Place {
    const perSide = Math.round(this.width / this.smallWidth), k = view % perSide ** 2;
    return {
      layer: Math.floor(view / perSide ** 2), scaleX: this.smallWidth / this.width, scaleY: this.smallHeight / this.height,
      offsetX: ((k % perSide) * this.smallWidth) / this.width,
      offsetY: (Math.floor(k / perSide) * this.smallHeight) / this.height, fine: false,
    };
  }
  addFine(view: number, bytes: Uint8Array<ArrayBuffer>): void {
    this.fine[view] = new Blob([bytes], { type: "image/webp" });
  }

  private async decode(view: number, blob: Blob, width: number, height: number, use: (bitmap: ImageBitmap) => void): Promise<void> {
    const camera = this.cameras[view]!;
    const own = width === this.width ? [camera.width, camera.height] : [Math.floor(camera.width / 4), Math.floor(camera.height / 4)];
    const options: ImageBitmapOptions = { premultiplyAlpha: "none", colorSpaceConversion: "none" };
    if (own[0] !== width || own[1] !== height)
      Object.assign(options, { resizeWidth: width, resizeHeight: height, resizeQuality: "medium" });
    const bitmap = await createImageBitmap(blob, options).catch(() => createImageBitmap(blob)); // old browsers know no options
    if (!this.gl.isContextLost()) use(bitmap);
    bitmap.close();
    this.decoding.delete(view);
    this.changed(view);
  }

  /** Of the views of a picture, the most important first: reads fine ones that are not there. */
  want(views: readonly number[]): void {
    ++this.drawing;
    for (const view of views) {
      const slot = this.slots.find((s) => s.view === view);
      if (slot) slot.usedAt = this.drawing;
    }
    for (const view of views) {
      if (this.decoding.size >= mostDecoding) return;
      const blob = this.fine[view];
      if (!blob || this.decoding.has(view) || this.slots.some((s) => s.view === view)) continue;
      const slot = this.slots.reduce((a, b) => (b.usedAt < a.usedAt ? b : a));
      if (slot.usedAt === this.drawing) return; // all are of this picture
      if (slot.view >= 0) this.places[slot.view] = this.smallIn[slot.view] ? this.smallPlace(slot.view) : undefined;
      slot.view = view;
      slot.usedAt = this.drawing;
      this.decoding.add(view);
      void this.decode(view, blob, this.width, this.height, (bitmap) => {
        if (slot.view !== view) return; // given to another view meanwhile
        const layer = this.smallLayers + this.slots.indexOf(slot);
        this.upload(view, bitmap, layer, 0, 0, this.width, this.height);
        this.places[view] = { layer, scaleX: 1, scaleY: 1, offsetX: 0, offsetY: 0, fine: true };
      }).catch(() => {
        this.fine[view] = undefined; // cannot be decoded: the small one stays
        this.decoding.delete(view);
        slot.view = -1;
      });
    }
  }
  /** Whether fine pictures of these views are still being read. */
  waits(views: readonly number[]): boolean {
    return views.slice(0, this.slots.length).some((view) => this.fine[view] && !this.places[view]?.fine);
  }
  /** How many views may be fine at the same time. */
  get fineViews(): number {
    return this.slots.length;
  }
  noteMasks(): void {
    this.hasMasks = true;
  }

  private upload(view: number, bitmap: ImageBitmap, layer: number, x: number, y: number, width: number, height: number): void {
    const gl = this.gl;
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, x, y, layer, width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    const geometry = this.geometry();
    if (geometry) this.hide(view, geometry, layer, x, y, width, height);
  }

  // What the geometry hides from a view, as the alpha of its picture.
  private hide(view: number, geometry: Geometry, layer: number, x: number, y: number, width: number, height: number): void {
    const gl = this.gl;
    const at = view % this.hidesOf.length;
    if (this.hidesOf[at] !== view) {
      this.hidesOf[at] = view;
      const camera = this.cameras[view]!;
      const near = 0.02 * norm(camera.center);
      this.nearness.bind();
      geometry.drawNearness(camera.camFromWorld, camera.translation,
        [2 * camera.fx, 2 * camera.fy, 2 * camera.cx - 1, 2 * camera.cy - 1], near);
      this.narrow.bind();
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.nearness.texture);
      this.narrowProgram.use().integer("nearness", 0).numbers("depth", 0).numbers("scale", this.nearnessFactor(view) / near);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.hidesFrame);
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.hides, 0, at);
      gl.bindTexture(gl.TEXTURE_2D, this.narrow.texture);
      this.widenProgram.use().integer("narrow", 0).numbers("depth", 0);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.texture, 0, layer);
    gl.viewport(x, y, width, height);
    gl.colorMask(false, false, false, true);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ZERO, gl.SRC_ALPHA);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.hides);
    this.openProgram.use().integer("hides", 0).numbers("depth", 0).numbers("area", x, y, 1 / width, 1 / height)
      .numbers("layer", at);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.BLEND);
    gl.colorMask(true, true, true, true);
  }
}
