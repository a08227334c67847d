// What is known of a pixel once its own views are drawn: light over weight, and in alpha the confidence; where they weigh
// too little, and others are to fill it up, less than -4: the confidence in 1023 parts and the weight, 0 to 1, added up;
// where there is nothing of its own, -2.
uniform float least_weight;
uniform float whole_weight;  // of less others fill up the rest

vec4 Resolved(vec3 light, float weight, float confidence) {
  if (!(weight > 0.0) || weight < least_weight) return vec4(0.0, 0.0, 0.0, -2.0);
  if (weight >= whole_weight) return vec4(light, confidence * min(1.0, weight));
  return vec4(light, -4.0 - floor(1023.0 * confidence + 0.5) - weight);
}

bool IsOpen(vec4 resolved) { return resolved.a < 0.0; }

// Light, and its weight; the confidence.
vec4 Own(vec4 resolved, out float confidence) {
  float told = -4.0 - resolved.a;
  confidence = floor(told) / 1023.0;
  return told > 0.0 ? vec4(resolved.rgb, fract(told)) : vec4(0.0);
}
