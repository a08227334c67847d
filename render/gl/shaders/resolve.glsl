// A pixel after its own views are drawn: light over weight, and the confidence as alpha. Where their weight
// is too small and other views must fill it up, alpha is -4 - (confidence in 1023 parts) - (weight, 0 to 1).
// Where none of its own views sees it, alpha is -2.
uniform float least_weight;
uniform float whole_weight;  // other views fill up a smaller weight

vec4 Resolved(vec3 light, float weight, float confidence) {
  if (!(weight > 0.0) || weight < least_weight) return vec4(0.0, 0.0, 0.0, -2.0);
  if (weight >= whole_weight) return vec4(light, confidence * min(1.0, weight));
  return vec4(light, -4.0 - floor(1023.0 * confidence + 0.5) - weight);
}

bool IsOpen(vec4 resolved) { return resolved.a < 0.0; }

// The light and weight of the own views, and the confidence.
vec4 Own(vec4 resolved, out float confidence) {
  float packed_alpha = -4.0 - resolved.a;
  confidence = floor(packed_alpha) / 1023.0;
  return packed_alpha > 0.0 ? vec4(resolved.rgb, fract(packed_alpha)) : vec4(0.0);
}
