// Lumigraph weights at every pixel over all views: the k best are kept while going through them.
uniform int view_count;
uniform int k_best;  // at most 8
uniform float resolution_penalty;
uniform float zero_penalty;
uniform float above_tie;
uniform float above_largest;
out vec4 color;

float Penalty(vec3 point, vec3 center) {
  vec3 to_virtual = -point, to_view = center - point;
  float angle = atan(length(cross(to_virtual, to_view)), dot(to_virtual, to_view));
  return angle + resolution_penalty * max(0.0, length(to_view) / length(to_virtual) - 1.0);
}

void main() {
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  int best[9];
  float penalty[9];
  int count = 0;
  for (int i = 0; i < view_count; ++i) {
    float p = Penalty(point, views[i].center.xyz);
    if (count == k_best + 1 && p >= penalty[count - 1]) continue;
    vec2 img;
    if (See(i, point, img) <= 0.0) continue;
    if (count < k_best + 1) ++count;
    int at = count - 1;
    while (at > 0 && penalty[at - 1] > p) {
      penalty[at] = penalty[at - 1];
      best[at] = best[at - 1];
      --at;
    }
    penalty[at] = p;
    best[at] = i;
  }
  if (count == 0) {
    color = vec4(0.0);
    return;
  }
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
  vec3 light = vec3(0.0);
  float sum = 0.0;
  for (int n = 0; n < count; ++n) {
    vec2 img;
    float weight = weights[n] / total * See(best[n], point, img);
    if (weight <= 0.0) continue;
    light += weight * LightOf(best[n], img);
    sum += weight;
  }
  color = Normalised(light, sum, 1.0);
}
