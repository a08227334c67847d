// Weights of a wide aperture's rings, whether their views see the point or not.
flat in vec3 numerator, denominator;
flat in float confidence;
out vec4 color;  // added up: weight times confidence, weight

void main() {
  vec3 ray = RayOfPixel();
  float weight = max(dot(numerator, ray) / max(dot(denominator, ray), 1e-30), 0.0);
  color = vec4(weight * confidence, weight, 0.0, 0.0);
}
