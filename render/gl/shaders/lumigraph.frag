// Lumigraph weights at every pixel over all views. The k best views are added up in the order of the views,
// as far as their photographs are resident: the sum is the same in one pass or in several. MARK: draws
// nothing; marks the views that decide, whether their photographs are resident or not. Nothing is hidden from
// a view without a shadow map.
uniform int view_count;
uniform int k_best;  // at most 8
uniform float resolution_penalty;
uniform float zero_penalty;
uniform float above_tie;
uniform float above_largest;
#ifdef MARK
layout(std430, binding = 3) writeonly buffer Needed { int needed[]; };
vec4 color;
#else
layout(binding = 15) uniform sampler2D before;
uniform bool goes_on;  // after passes over other views
out vec4 color;        // light times weight, weight
#endif

void main() {
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  float to_virtual = length(point);
  vec3 back = -point / to_virtual;
  int best[9];
  float penalty[9];
  int count = 0;
  float least_cosine = -2.0;  // of an angle as large as the worst kept penalty; it skips most views
  for (int i = 0; i < view_count; ++i) {
    View v = ViewAt(i);
    vec3 to_view = v.center.xyz - point;
    float inverse_length = inversesqrt(dot(to_view, to_view));
    float cosine = dot(back, to_view) * inverse_length;
    if (cosine < least_cosine) continue;
    float p = atan(length(cross(back, to_view)) * inverse_length, cosine) +
              resolution_penalty * max(0.0, 1.0 / (inverse_length * to_virtual) - 1.0);
    if (count == k_best + 1 && p >= penalty[count - 1]) continue;
    vec2 img;
    if (See(v, point, img) <= 0.0) continue;
    if (count < k_best + 1) ++count;
    int at = count - 1;
    while (at > 0 && penalty[at - 1] > p) {
      penalty[at] = penalty[at - 1];
      best[at] = best[at - 1];
      --at;
    }
    penalty[at] = p;
    best[at] = i;
    if (count == k_best + 1) least_cosine = cos(min(penalty[count - 1], 3.14159265)) - 1e-6;
  }
  color = vec4(0.0);
#ifdef MARK
  for (int n = 0; n < count; ++n) needed[best[n]] = 1;
#else
  if (goes_on) color = texelFetch(before, ivec2(gl_FragCoord.xy), 0);
#endif
  if (count == 0) return;
  float threshold = above_largest * penalty[count - 1];
  if (count > k_best) {
    threshold = max(penalty[k_best], above_tie * penalty[k_best - 1]);
    count = k_best;
  }
  float weights[9];
  float total = 0.0;
  for (int n = 0; n < count; ++n) {
    weights[n] = penalty[0] <= zero_penalty ? (n == 0 ? 1.0 : 0.0) : max(0.0, 1.0 - penalty[n] / threshold) / penalty[n];
    total += weights[n];
  }
#ifndef MARK
  for (int n = 1; n < count; ++n)
    for (int at = n; at > 0 && best[at - 1] > best[at]; --at) {
      int view = best[at];
      best[at] = best[at - 1];
      best[at - 1] = view;
      float weight = weights[at];
      weights[at] = weights[at - 1];
      weights[at - 1] = weight;
    }
  for (int n = 0; n < count; ++n) {
    View v = ViewAt(best[n]);
#ifndef SHOW_FIELD
    if (v.place.x < 0) continue;
#endif
    vec2 img;
    float weight = weights[n] / total * See(v, point, img);
    float share;
    vec3 light = LightOf(v, img, share);
    if (weight * share > 0.0) color += weight * share * vec4(light, 1.0);
  }
#endif
}
