// The geometry of the scene: triangles in graphics memory, and on the processor to find what is clicked on.
import { Arrays, GeometryHeader } from "./data";
import { Program } from "./gl";
import { Mat3, Vec3, cross, difference, dot } from "./math";

export class Geometry {
  private readonly vertices: WebGLVertexArrayObject;
  private readonly count: number;
  private readonly cornerType: GLenum;
  private readonly corners: Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>;
  private readonly places: Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>;

  constructor(
    private readonly gl: WebGL2RenderingContext, private readonly program: Program,
    private readonly header: NonNullable<GeometryHeader["geometry"]>, arrays: Arrays,
  ) {
    this.places = arrays.integers("places");
    this.corners = arrays.integers("corners");
    this.count = this.corners.length;
    this.cornerType = this.corners instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
    this.vertices = gl.createVertexArray();
    gl.bindVertexArray(this.vertices);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    // Four numbers a vertex: places that are no multiple of four bytes are slow.
    const padded = new Uint16Array((this.places.length / 3) * 4);
    for (let i = 0; 3 * i < this.places.length; ++i) padded.set(this.places.subarray(3 * i, 3 * i + 3), 4 * i);
    gl.bufferData(gl.ARRAY_BUFFER, padded, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, false, 8, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, this.corners, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  /** 1 - near / depth into the depth texture that is bound. */
  drawNearness(camFromWorld: Mat3, translation: Vec3, lens: [number, number, number, number], near: number): void {
    const gl = this.gl, m = camFromWorld, t = translation;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.program.use()
      .numbers("low", ...this.header.low).numbers("step", ...this.header.step)
      .numbers("row0", m[0], m[1], m[2], t[0]).numbers("row1", m[3], m[4], m[5], t[1])
      .numbers("row2", m[6], m[7], m[8], t[2]).numbers("lens", ...lens).numbers("near", near);
    gl.bindVertexArray(this.vertices);
    gl.drawElements(gl.TRIANGLES, this.count, this.cornerType, 0);
    gl.bindVertexArray(null);
    gl.disable(gl.DEPTH_TEST);
  }

  private vertex(index: number): Vec3 {
    const { low, step } = this.header;
    return [0, 1, 2].map((k) => low[k]! + step[k]! * this.places[3 * index + k]!) as Vec3;
  }

  /** How far along `direction` from `eye` the nearest triangle is, in lengths of `direction`; null: there is none. */
  hit(eye: Vec3, direction: Vec3): number | null {
    let nearest: number | null = null;
    for (let i = 0; i < this.count; i += 3) {
      const a = this.vertex(this.corners[i]!);
      const ab = difference(this.vertex(this.corners[i + 1]!), a), ac = difference(this.vertex(this.corners[i + 2]!), a);
      const p = cross(direction, ac);
      const volume = dot(ab, p);
      if (volume === 0) continue;
      const from = difference(eye, a);
      const u = dot(from, p) / volume;
      if (u < 0 || u > 1) continue;
      const q = cross(from, ab);
      const v = dot(direction, q) / volume;
      if (v < 0 || u + v > 1) continue;
      const distance = dot(ac, q) / volume;
      if (distance > 0 && (nearest === null || distance < nearest)) nearest = distance;
    }
    return nearest;
  }
}
