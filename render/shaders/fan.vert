// Second pass: every triangle once for each view that weighs in it. All that the fragments need of the view and of its
// weight is constant over the triangle and travels flat, in the form that takes them the fewest steps: what is linear
// in the ray is linear in the pixel (x, y, 1).
struct Fan {
  uint triangle;
  uint view;
  uint unused[2];
  vec4 weights;    // of the view at the triangle's corners
};
layout(std430, binding = 2) readonly buffer Fans { Fan fans[]; };
uniform vec4 camera;  // fx fy cx cy
uniform vec4 plane;   // normal, offset

invariant gl_Position;
flat out vec4 row0, row1, row2;  // point in the view over its depth, from (x, y, 1, 1 / depth)
flat out vec4 to_uv;             // of (x, y) / z: scale, offset
flat out vec4 light;             // of (x, y) of the photograph, size 1: to feathers; black, scale
flat out vec3 nearness;          // 1 / depth of the plane, from (x, y, 1)
// The weight is numerator . (x, y, 1) / denominator . (x, y, 1).
flat out vec3 numerator, denominator;
flat out float confidence;
flat out ivec4 place;
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
flat out vec4 size, k, more;
#endif
#ifdef SHOW_FIELD
flat out vec4 color_of_view;
#endif
#ifdef HIDES
flat out vec4 sight;
#endif

vec3 OfPixel(vec3 of_ray) {
  vec2 scaled = of_ray.xy / camera.xy;
  return vec3(scaled, of_ray.z - dot(scaled, camera.zw));
}

void main() {
  Fan fan = fans[uint(gl_VertexID) / 3u];
  vec3 r0 = triangles[fan.triangle].row[0].xyz;
  vec3 r1 = triangles[fan.triangle].row[1].xyz;
  vec3 r2 = triangles[fan.triangle].row[2].xyz;
  numerator = OfPixel(fan.weights.x * r0 + fan.weights.y * r1 + fan.weights.z * r2);
  denominator = OfPixel(r0 + r1 + r2);
  nearness = OfPixel(plane.xyz) / plane.w;
  confidence = triangles[fan.triangle].row[0].w;
  View v = ViewAt(int(fan.view));
  row0 = vec4(OfPixel(v.row0.xyz), v.row0.w);
  row1 = vec4(OfPixel(v.row1.xyz), v.row1.w);
  row2 = vec4(OfPixel(v.row2.xyz), v.row2.w);
  to_uv = v.intrinsics / v.size.xyxy;
  light = vec4(v.size.xy / v.size.z, v.more.yz);
  place = v.place;
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
  size = v.size;
  k = v.k;
  more = v.more;
#endif
#ifdef SHOW_FIELD
  color_of_view = v.color;
#endif
#ifdef HIDES
  sight = v.sight;
#endif
  gl_Position = ClipPosition(fan.triangle, uint(gl_VertexID) % 3u);
}
