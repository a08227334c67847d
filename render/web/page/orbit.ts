// The camera of the page: it goes round the subject among the recorded viewpoints, zooms its lens, and has a wide aperture
// on request.
import { SceneHeader } from "./data";
import { Camera, Field } from "./field";
import { Vec3, angleBetween, clamp, cross, lookAtCenter, norm, scaled, turned, unit } from "./math";

export const mostZoom = 2.5;
const mostStartingZoom = 1.1; // of a photograph that fills the picture: its border is left out. Guessed.
const leastPolarRad = 0.035; // of the camera from a pole, where up has no meaning

export class Orbit {
  eye: Vec3;
  zoom = 1;
  private readonly up: Vec3;

  constructor(private readonly header: SceneHeader, private readonly field: Field) {
    this.eye = header.eye;
    this.up = unit(header.up);
  }

  /** Pixels of focal length at which a photograph just fills the picture. */
  private filling(width: number, height: number): number {
    const [w, h, focal] = this.header.lens;
    return focal * Math.max(width / w, height / h);
  }
  /** At this zoom all of a photograph is in the picture. */
  leastZoom(width: number, height: number): number {
    const [w, h] = this.header.lens;
    return Math.min(width / w, height / h) / Math.max(width / w, height / h);
  }
  /** At which the subject fits. */
  startingZoom(width: number, height: number): number {
    const distance = norm(this.eye), slope = this.header.radius / Math.sqrt(Math.max(distance ** 2 - this.header.radius ** 2, 1e-12));
    const air = 1.25; // around the subject's sphere. Guessed.
    const fits = Math.min(width, height) / (2 * air * slope * this.filling(width, height));
    return clamp(fits, this.leastZoom(width, height), mostStartingZoom);
  }
  setZoom(zoom: number, width: number, height: number): void {
    this.zoom = clamp(zoom, this.leastZoom(width, height), mostZoom);
  }
  reset(width: number, height: number): void {
    this.eye = this.header.eye;
    this.zoom = this.startingZoom(width, height);
  }

  camera(width: number, height: number): Camera {
    return {
      eye: this.eye, camFromWorld: lookAtCenter(this.eye, this.up), focalPx: this.zoom * this.filling(width, height),
      width, height,
    };
  }

  /** Round the subject, in radians, as far as there are recorded viewpoints: at their rim along it. Whether it moved. */
  turn(right: number, up: number): boolean {
    // Small steps, so that a fast hand reaches the rim.
    const steps = Math.max(1, Math.ceil(Math.hypot(right, up) / 0.02));
    let moved = false;
    for (let i = 0; i < steps; ++i) {
      const step: [number, number] = [right / steps, up / steps];
      moved = this.step(...step) || this.step(step[0], 0) || this.step(0, step[1]) || moved;
    }
    return moved;
  }
  private step(right: number, up: number): boolean {
    if (right === 0 && up === 0) return false;
    const polar = angleBetween(this.eye, this.up);
    const wanted = clamp(polar - up, Math.min(leastPolarRad, polar), Math.max(Math.PI - leastPolarRad, polar));
    const sideways = unit(cross(this.up, this.eye));
    let eye = turned(this.eye, sideways, wanted - polar);
    eye = turned(eye, this.up, right);
    if (!this.field.inside(eye) && this.field.inside(this.eye)) return false;
    this.eye = scaled(unit(eye), norm(this.header.eye));
    return true;
  }
}
