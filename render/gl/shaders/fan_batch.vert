// Second pass: every triangle once for up to VIEWS of the views that have weight in it and whose photographs
// lie in one array, so that the fixed cost of a fragment, and adding up in memory, is paid once for all of
// them. The data of the views and of their weights is constant over the triangle; it is passed flat, in as
// few vectors as possible.
struct Fan {
  uint triangle;
  uint view;
  uint unused[2];
  vec4 weights;  // of the view at the triangle's corners
};
layout(std430, binding = 2) readonly buffer Fans { Fan fans[]; };
struct FanBatch {
  uint triangle;
  uint first, count;  // of its fans
  uint unused;
};
layout(std430, binding = 3) readonly buffer FanBatches { FanBatch batches[]; };

invariant gl_Position;
// view_from_cam, two rows, x and y of its translation; the third row is their cross product.
flat out vec4 right[VIEWS], down[VIEWS];
// A view's weight is numerator . ray / denominator . ray. The numerator's w is the z of the view's
// translation, the denominator's w the triangle's confidence.
flat out vec4 numerator[VIEWS], denominator;
// Layers of the views' photographs. HIDES: plus 4096 times the layers of their shadow maps, counted from 1;
// 0: no map.
flat out vec4 layers[(VIEWS + 3) / 4];
#ifndef ONE_CAMERA
flat out vec4 to_uv[VIEWS];  // of (x, y) / z: scale, offset
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
flat out vec4 size[VIEWS], k[VIEWS], more[VIEWS];
#endif
#ifdef HIDES
flat out vec4 shadow_map[VIEWS];
#endif
#endif
#ifndef ONE_EXPOSURE
flat out vec4 light[VIEWS];  // of (x, y) of the photograph, size 1: to feathers; black, scale
#endif
#ifdef CORRECTED
flat out vec4 correction[VIEWS];  // times the view's scale, in place of which light has falloff_r4
#endif
#ifdef SHOW_FIELD
flat out vec4 color_of_view[VIEWS];
#endif

void main() {
  FanBatch batch = batches[uint(gl_VertexID) / 3u];
  vec3 r0 = triangles[batch.triangle].row[0].xyz;
  vec3 r1 = triangles[batch.triangle].row[1].xyz;
  vec3 r2 = triangles[batch.triangle].row[2].xyz;
  denominator = vec4(r0 + r1 + r2, triangles[batch.triangle].row[0].w);
  for (uint n = 0u; n < VIEWS; ++n) {
    // Unused views read what the last one reads, with weight 0.
    Fan fan = fans[batch.first + min(n, batch.count - 1u)];
    vec4 weights = n < batch.count ? fan.weights : vec4(0.0);
    View v = ViewAt(int(fan.view));
    right[n] = v.row0;
    down[n] = v.row1;
    numerator[n] = vec4(weights.x * r0 + weights.y * r1 + weights.z * r2, v.row2.w);
    float layer = float(v.place.y);
#ifdef HIDES
    layer += 4096.0 * float(v.place.w + 1);
#endif
    layers[n / 4u][n % 4u] = layer;
#ifndef ONE_CAMERA
    to_uv[n] = v.intrinsics / v.size.xyxy;
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
    size[n] = v.size;
    k[n] = v.k;
    more[n] = v.more;
#endif
#ifdef HIDES
    shadow_map[n] = v.shadow_map;
#endif
#endif
#ifndef ONE_EXPOSURE
    light[n] = vec4(v.size.xy / v.size.z, v.more.yz);
#endif
#ifdef CORRECTED
    correction[n] = vec4(v.more.z * v.correction.rgb, v.correction.w);
    light[n].w = v.color.w;
#endif
#ifdef SHOW_FIELD
    color_of_view[n] = v.color;
#endif
  }
  gl_Position = ClipPosition(batch.triangle, uint(gl_VertexID) % 3u);
}
