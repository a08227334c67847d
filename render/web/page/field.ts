// The blending field: which views a ray of the virtual camera is made of (render/fields/mesh_field.h). Triangles of the
// mesh of viewpoints, as seen from the camera's centre, each with the views that have weight in it.
import { Arrays, SceneHeader } from "./data";
import { Mat3, Vec3, angleBetween, clamp, cross, difference, dot, norm, scaled, sum, times, timesInverse, unit } from "./math";

/** Views of a triangle that are drawn; of a vertex with more neighbours the lightest are left out. */
export const mostViewsOfTriangle = 12;

export interface Camera {
  eye: Vec3;
  camFromWorld: Mat3;
  focalPx: number;
  width: number;
  height: number;
}

export interface Fan {
  view: number;
  /** Its weight along a ray in the camera's axes is numerator . ray over the sum of all numerators . ray. */
  numerator: Vec3;
}

export interface FieldTriangle {
  /** Of the corners: x and y of clip space, and w. */
  corners: [Vec3, Vec3, Vec3];
  denominator: Vec3;
  fans: Fan[];
}

export interface ViewCamera {
  /** Of a picture of size 1. */
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  width: number;
  height: number;
  camFromWorld: Mat3;
  translation: Vec3;
  center: Vec3;
}

export function viewCameras(arrays: Arrays, views: number): ViewCamera[] {
  const values = arrays.f32("cameras");
  const cameras: ViewCamera[] = [];
  for (let i = 0; i < views; ++i) {
    const at = (k: number): number => values[18 * i + k]!;
    const camFromWorld: Mat3 = [at(6), at(7), at(8), at(10), at(11), at(12), at(14), at(15), at(16)];
    const translation: Vec3 = [at(9), at(13), at(17)];
    cameras.push({
      fx: at(0), fy: at(1), cx: at(2), cy: at(3), width: at(4), height: at(5),
      camFromWorld,
      translation,
      center: scaled(timesInverse(camFromWorld, translation), -1),
    });
  }
  return cameras;
}

interface Entry {
  vertex: number;
  weights: Vec3;
}

/** Triangles of the mesh with, for each, the weights of viewpoints at its corners. */
interface Level {
  triangles: [number, number, number][];
  entries: Entry[][];
}

const onMeshShare = 1e-3; // kOnMeshShare

/** The inverse of the matrix with these columns; null where it has no volume. */
function inverse(a: Vec3, b: Vec3, c: Vec3): [Vec3, Vec3, Vec3] | null {
  const bc = cross(b, c);
  const volume = dot(a, bc);
  const leastVolume = 1e-15;
  if (!(Math.abs(volume) > leastVolume * norm(a) * norm(b) * norm(c))) return null;
  return [scaled(bc, 1 / volume), scaled(cross(c, a), 1 / volume), scaled(cross(a, b), 1 / volume)];
}

/** None where the triangle does not meet the picture. Corners are in the camera's axes. */
function inPicture(corners: [Vec3, Vec3, Vec3], camera: Camera): [Vec3, Vec3, Vec3] | null {
  const outside = [0, 0, 0, 0, 0];
  const clip = corners.map((c): Vec3 => {
    const x = (2 * camera.focalPx * c[0]) / camera.width;
    const y = (-2 * camera.focalPx * c[1]) / camera.height;
    if (c[2] <= 0) ++outside[0]!;
    if (x > c[2]) ++outside[1]!;
    if (-x > c[2]) ++outside[2]!;
    if (y > c[2]) ++outside[3]!;
    if (-y > c[2]) ++outside[4]!;
    return [x, y, c[2]];
  });
  return outside.includes(3) ? null : (clip as [Vec3, Vec3, Vec3]);
}

/** Of several weights per view; fewer than mostViewsOfTriangle are left. */
function triangleOf(
  clip: [Vec3, Vec3, Vec3], rows: [Vec3, Vec3, Vec3], entries: { view: number; weights: Vec3 }[],
): FieldTriangle {
  const size = Math.max(...rows.map(norm));
  const r = rows.map((row) => scaled(row, 1 / size)) as [Vec3, Vec3, Vec3];
  let kept = entries;
  if (kept.length > mostViewsOfTriangle)
    kept = [...kept]
      .sort((a, b) => b.weights[0] + b.weights[1] + b.weights[2] - a.weights[0] - a.weights[1] - a.weights[2])
      .slice(0, mostViewsOfTriangle);
  return {
    corners: clip,
    denominator: sum(sum(r[0], r[1]), r[2]),
    fans: kept.map(({ view, weights }) => ({
      view,
      numerator: sum(sum(scaled(r[0], weights[0]), scaled(r[1], weights[1])), scaled(r[2], weights[2])),
    })),
  };
}

/** Weights by where rays cross the mesh of viewpoints. */
export class MeshField {
  private readonly positions: Vec3[] = [];
  private readonly subdivided: Level;
  private readonly plain: Level; // not subdivided: three viewpoints a triangle
  private readonly viewsOfVertex: number[][] = [];

  constructor(arrays: Arrays, private readonly cameras: ViewCamera[]) {
    const positions = arrays.f32("positions");
    for (let i = 0; i < positions.length; i += 3)
      this.positions.push([positions[i]!, positions[i + 1]!, positions[i + 2]!]);
    const triples = (name: string): [number, number, number][] => {
      const corners = arrays.integers(name), into: [number, number, number][] = [];
      for (let i = 0; i < corners.length; i += 3) into.push([corners[i]!, corners[i + 1]!, corners[i + 2]!]);
      return into;
    };
    const hull = triples("hull");
    const unitWeights: Vec3[] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    this.plain = {
      triangles: hull,
      entries: hull.map((triangle) => triangle.map((vertex, k) => ({ vertex, weights: unitWeights[k]! }))),
    };
    this.subdivided = { triangles: triples("triangles"), entries: [] };
    const first = arrays.integers("firstWeight"), vertex = arrays.integers("weightVertex"), weight = arrays.f32("weight");
    for (const triangle of this.subdivided.triangles) {
      const of = new Map<number, Vec3>();
      triangle.forEach((corner, k) => {
        for (let i = first[corner]!; i < first[corner + 1]!; ++i) {
          const weights = of.get(vertex[i]!) ?? [0, 0, 0];
          weights[k]! += weight[i]!;
          of.set(vertex[i]!, weights);
        }
      });
      this.subdivided.entries.push([...of].map(([key, weights]) => ({ vertex: key, weights })));
    }
    const firstView = arrays.integers("firstViewOfVertex"), views = arrays.integers("viewOfVertex");
    for (let i = 0; i + 1 < firstView.length; ++i)
      this.viewsOfVertex.push(Array.from(views.subarray(firstView[i], firstView[i + 1])));
  }

  /** Whether a direction from the subject meets the mesh. */
  inside(direction: Vec3): boolean {
    return this.plain.triangles.some((triangle) => {
      const arms = triangle.map((corner) => this.positions[corner]!);
      return [0, 1, 2].every((k) => dot(direction, cross(arms[k]!, arms[(k + 1) % 3]!)) >= 0);
    });
  }

  // Moved off the mesh where the camera stands on it: there every ray would cross it at the camera.
  private offTheMesh(eye: Vec3, triangles: Level["triangles"]): Vec3 {
    const radial = unit(eye);
    for (let t = triangles.length - 1; t >= 0; --t) {
      const [a, b, c] = triangles[t]!.map((corner) => this.positions[corner]!) as [Vec3, Vec3, Vec3];
      const rows = inverse(a, b, c);
      if (!rows || rows.some((row) => dot(row, radial) < 0)) continue;
      const first = difference(b, a), second = difference(c, b), third = difference(a, c);
      const normal = unit(cross(first, scaled(third, -1)));
      const margin = onMeshShare * Math.min(norm(first), norm(second), norm(third));
      const outside = -dot(normal, difference(a, eye)), slope = dot(normal, radial);
      if (Math.abs(outside) >= margin || slope <= 0) return eye;
      return sum(eye, scaled(radial, ((outside < 0 ? -margin : margin) - outside) / slope));
    }
    return eye;
  }

  private viewAt(vertex: number, distance: number): number {
    const views = this.viewsOfVertex[vertex]!;
    let best = views[0]!;
    for (const view of views)
      if (Math.abs(norm(this.cameras[view]!.center) - distance) < Math.abs(norm(this.cameras[best]!.center) - distance))
        best = view;
    return best;
  }

  /** The triangles that the picture shows, in their order. Simple: of the mesh that is not subdivided. */
  place(camera: Camera, simple: boolean): FieldTriangle[] {
    const { triangles, entries } = simple ? this.plain : this.subdivided;
    const from = this.offTheMesh(camera.eye, triangles);
    const distance = norm(camera.eye);
    const inCamera = this.positions.map((position) => times(camera.camFromWorld, difference(position, from)));
    const placed: FieldTriangle[] = [];
    triangles.forEach((triangle, t) => {
      let corners = triangle.map((corner) => inCamera[corner]!) as [Vec3, Vec3, Vec3];
      // Outward normals: the volume is negative where the camera is outside the triangle's plane.
      if (dot(corners[0], cross(corners[1], corners[2])) > 0)
        corners = corners.map((corner) => scaled(corner, -1)) as [Vec3, Vec3, Vec3];
      const clip = inPicture(corners, camera);
      if (!clip) return;
      const rows = inverse(...corners);
      if (!rows) return;
      placed.push(triangleOf(clip, rows,
        entries[t]!.map(({ vertex, weights }) => ({ view: this.viewAt(vertex, distance), weights }))));
    });
    return placed;
  }
}

/** Lumigraph weights at the corners of a grid over the picture, for views that stand in a row, a ring, or are few. */
export class LumigraphField {
  constructor(private readonly header: SceneHeader, private readonly cameras: ViewCamera[]) {}

  private weightsAt(point: Vec3, eye: Vec3): Map<number, number> {
    const back = difference(eye, point);
    const penalties: [number, number][] = [];
    this.cameras.forEach((camera, view) => {
      const inView = sum(times(camera.camFromWorld, point), camera.translation);
      const u = (camera.fx * inView[0]) / inView[2] + camera.cx, v = (camera.fy * inView[1]) / inView[2] + camera.cy;
      if (inView[2] <= 0 || u < 0 || v < 0 || u > 1 || v > 1) return;
      const toView = difference(camera.center, point);
      penalties.push([
        angleBetween(back, toView) + this.header.lumigraphResolution * Math.max(0, norm(toView) / norm(back) - 1), view,
      ]);
    });
    penalties.sort((a, b) => a[0] - b[0]);
    const k = Math.max(1, this.header.lumigraphViews);
    const kept = penalties.slice(0, k);
    const weights = new Map<number, number>();
    if (kept.length === 0) return weights;
    const last = kept[kept.length - 1]![0];
    const threshold = penalties.length > k ? Math.max(penalties[k]![0], 1.001 * last) : 1.1 * last;
    if (kept[0]![0] <= 1e-6) return weights.set(kept[0]![1], 1);
    let total = 0;
    for (const [penalty] of kept) total += Math.max(0, 1 - penalty / threshold) / penalty;
    for (const [penalty, view] of kept) weights.set(view, Math.max(0, 1 - penalty / threshold) / penalty / total);
    return weights;
  }

  place(camera: Camera, _simple: boolean): FieldTriangle[] {
    const columns = 8, rows = 6; // guessed
    const distance = norm(camera.eye);
    const toCenter = scaled(camera.eye, -1 / distance);
    const vertices: { ray: Vec3; clip: Vec3; weights: Map<number, number> }[] = [];
    for (let y = 0; y <= rows; ++y)
      for (let x = 0; x <= columns; ++x) {
        const clip: Vec3 = [(2 * x) / columns - 1, (2 * y) / rows - 1, 1];
        const ray: Vec3 = [
          (clip[0] * camera.width) / (2 * camera.focalPx), (-clip[1] * camera.height) / (2 * camera.focalPx), 1,
        ];
        const inWorld = timesInverse(camera.camFromWorld, ray);
        const slope = Math.max(dot(inWorld, toCenter), 1e-3);
        vertices.push({ ray, clip, weights: this.weightsAt(sum(camera.eye, scaled(inWorld, distance / slope)), camera.eye) });
      }
    const placed: FieldTriangle[] = [];
    const add = (a: number, b: number, c: number): void => {
      const corners = [vertices[a]!, vertices[b]!, vertices[c]!];
      const inverted = inverse(corners[0]!.ray, corners[1]!.ray, corners[2]!.ray);
      if (!inverted) return;
      const of = new Map<number, Vec3>();
      corners.forEach((corner, k) => {
        for (const [view, weight] of corner.weights) {
          const weights = of.get(view) ?? [0, 0, 0];
          weights[k] = weight;
          of.set(view, weights);
        }
      });
      placed.push(triangleOf(corners.map((corner) => corner.clip) as [Vec3, Vec3, Vec3], inverted,
        [...of].map(([view, weights]) => ({ view, weights }))));
    };
    for (let y = 0; y < rows; ++y)
      for (let x = 0; x < columns; ++x) {
        const at = y * (columns + 1) + x;
        add(at, at + 1, at + columns + 1);
        add(at + 1, at + columns + 2, at + columns + 1);
      }
    return placed;
  }

  /** Whether a camera in this direction has a view beside it. */
  inside(direction: Vec3): boolean {
    const mostRad = clamp(this.header.spacing || 0.15, 0.02, 0.3); // guessed
    return this.cameras.some((camera) => angleBetween(camera.center, direction) <= mostRad);
  }
}

export type Field = MeshField | LumigraphField;
