// Second pass: every triangle once for each view that weighs in it. All that the fragments need of the view and of its
// weight is constant over the triangle and travels flat, so that fragments read no buffers.
struct Fan {
  uint triangle;
  uint view;
  uint unused[2];
  vec4 weights;    // of the view at the triangle's corners
};
layout(std430, binding = 2) readonly buffer Fans { Fan fans[]; };

invariant gl_Position;
flat out vec4 row0, row1, row2, intrinsics, size, k, more, color_of_view;
#ifdef HIDES
flat out vec4 sight;
#endif
flat out ivec4 place;
// The weight is numerator . ray / denominator . ray.
flat out vec3 numerator, denominator;
flat out float confidence;

void main() {
  Fan fan = fans[uint(gl_VertexID) / 3u];
  vec3 r0 = triangles[fan.triangle].row[0].xyz;
  vec3 r1 = triangles[fan.triangle].row[1].xyz;
  vec3 r2 = triangles[fan.triangle].row[2].xyz;
  numerator = fan.weights.x * r0 + fan.weights.y * r1 + fan.weights.z * r2;
  denominator = r0 + r1 + r2;
  confidence = triangles[fan.triangle].row[0].w;
  View v = views[fan.view];
  row0 = v.row0;
  row1 = v.row1;
  row2 = v.row2;
  intrinsics = v.intrinsics;
  size = v.size;
  k = v.k;
  more = v.more;
  color_of_view = v.color;
#ifdef HIDES
  sight = v.sight;
#endif
  place = v.place;
  gl_Position = ClipPosition(fan.triangle, uint(gl_VertexID) % 3u);
}
