// The camera of the page: it goes round the subject among the recorded viewpoints, zooms its lens, and has a wide aperture
// on request.
import { SceneHeader } from "./data";
import { Camera, Field } from "./field";
import { Vec3, angleBetween, clamp, cross, lookAtCenter, norm, scaled, turned, unit } from "./math";

export const mostZoom = 2.5;
const mostStartingZoom = 1.1; // of a photograph that fills the picture: its border is left out. Guessed.
const leastPolarRad = 0.035; // of the camera from a pole, where up has no meaning

/** Of a photograph, in its pixels. */
export interface Lens {
  width: number;
  height: number;
  focal: number;
}

/** At this zoom all of a photograph is in the window; at 1 it just fills it. */
function leastZoom(lens: Lens, width: number, height: number): number {
  const across = width / lens.width, down = height / lens.height;
  return Math.min(across, down) / Math.max(across, down);
}

/** At which a subject of this radius fits into the window. */
export function startingZoom(lens: Lens, radius: number, distance: number, width: number, height: number): number {
  const slope = radius / Math.sqrt(Math.max(distance ** 2 - radius ** 2, 1e-12));
  const filling = lens.focal * Math.max(width / lens.width, height / lens.height);
  const air = 1.25; // around the subject's sphere. Guessed.
  return clamp(Math.min(width, height) / (2 * air * slope * filling), leastZoom(lens, width, height), mostStartingZoom);
}

export class Orbit {
  eye: Vec3;
  zoom = 1;
  private readonly up: Vec3;

  constructor(private readonly header: SceneHeader, private readonly field: Field) {
    this.eye = header.eye;
    this.up = unit(header.up);
  }

  private get lens(): Lens {
    const [width, height, focal] = this.header.lens;
    return { width, height, focal };
  }
  leastZoom(width: number, height: number): number {
    return leastZoom(this.lens, width, height);
  }
  setZoom(zoom: number, width: number, height: number): void {
    this.zoom = clamp(zoom, this.leastZoom(width, height), mostZoom);
  }
  reset(width: number, height: number): void {
    this.eye = this.header.eye;
    this.zoom = startingZoom(this.lens, this.header.radius, norm(this.eye), width, height);
  }

  camera(width: number, height: number): Camera {
    const { lens } = this;
    const focalPx = this.zoom * lens.focal * Math.max(width / lens.width, height / lens.height);
    return { eye: this.eye, camFromWorld: lookAtCenter(this.eye, this.up), focalPx, width, height };
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
