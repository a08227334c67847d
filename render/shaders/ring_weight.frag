// Weights of a wide aperture's rings, whether their views see the point or not.
flat in vec3 numerator, denominator;
flat in float confidence;
out vec4 color;  // added up: weight times confidence, weight

void main() {
  vec3 pixel = vec3(gl_FragCoord.xy, 1.0);
  float weight = max(dot(numerator, pixel) / max(dot(denominator, pixel), 1e-30), 0.0);
  color = vec4(weight * confidence, weight, 0.0, 0.0);
}
