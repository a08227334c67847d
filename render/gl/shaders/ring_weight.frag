// The weights of a wide aperture's rings, whether their views see the point or not.
flat in vec4 numerator[VIEWS], denominator;
uniform vec4 camera;  // fx fy cx cy
out vec4 color;  // to be added up: weight times confidence, weight

void main() {
  vec3 ray = vec3((gl_FragCoord.xy - camera.zw) / camera.xy, 1.0);
  float weight = max(dot(numerator[0].xyz, ray) / max(dot(denominator.xyz, ray), 1e-30), 0.0);
  color = vec4(weight * denominator.w, weight, 0.0, 0.0);
}
