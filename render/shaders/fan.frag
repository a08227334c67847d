flat in vec4 row0, row1, row2, intrinsics, size, k, more, color_of_view;
#ifdef HIDES
flat in vec4 sight;
#else
const vec4 sight = vec4(0.0);
#endif
flat in ivec4 place;
flat in vec3 numerator, denominator;
out vec4 color;  // added up: light times weight, weight

void main() {
  vec3 ray = RayOfPixel();
  float weight = dot(numerator, ray) / max(dot(denominator, ray), 1e-30);
  View v = View(row0, row1, row2, intrinsics, size, k, more, color_of_view, vec4(0.0), sight, place);
  vec2 img;
  weight = max(weight, 0.0) * See(v, ray * DepthOf(ray), img);
  float share;
  vec3 light = LightOf(v, img, share);
  // Nothing is discarded: that would keep the depth test from coming first.
  color = weight * share > 0.0 ? weight * share * vec4(light, 1.0) : vec4(0.0);
}
