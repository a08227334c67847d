flat in vec4 row0, row1, row2, intrinsics, size, k, more, color_of_view;
flat in ivec4 place;
flat in vec3 numerator, denominator;
out vec4 color;  // added up: light times weight, weight

void main() {
  vec3 ray = RayOfPixel();
  float weight = dot(numerator, ray) / max(dot(denominator, ray), 1e-30);
  View v = View(row0, row1, row2, intrinsics, size, k, more, color_of_view, vec4(0.0), place);
  vec2 img;
  weight = max(weight, 0.0) * See(v, ray * DepthOf(ray), img);
  // Nothing is discarded: that would keep the depth test from coming first.
  color = weight > 0.0 ? vec4(weight * LightOf(v, img), weight) : vec4(0.0);
}
