// The soft field's pixel, as render/renderer/soft_pixel.h defines it; constants come from there. Between
// passes, when not all photographs are resident at the same time, each pass adds the mean of its own views,
// balanced among themselves, by their share of all weight.
layout(binding = 10) uniform isamplerBuffer nearest_first;  // views of each tile
#ifdef MAPS
layout(binding = 14) uniform sampler2DArray depth_maps;  // inverse depth over the view's unit; 0: unknown
#endif
layout(binding = 15) uniform sampler2D before;
flat in ivec2 looks_through;  // first and end in nearest_first
uniform bool goes_on;         // after passes over other views
uniform bool in_passes;       // other views have or will have a pass
uniform float resolution_penalty;
uniform float zero_penalty;
uniform float width_of_fourth;
out vec4 color;  // light times weight, weight

int chosen[SOFT_VIEWS];
float penalty[SOFT_VIEWS];
float weights[SOFT_VIEWS];
vec2 asides[SOFT_VIEWS];  // how far a view's direction is beside the virtual camera's, seen from the point
float reach;
int count = 0;

float Gaussian(float value, float width) { return exp(-0.5 * value * value / (width * width)); }

void Choose(vec3 point) {
  float to_virtual = length(point);
  vec3 back = -point / to_virtual;
  vec3 right = normalize(vec3(-back.z, 0.0, back.x)), up = cross(right, back);
  vec4 least = vec4(1e30);  // the four smallest penalties, ascending
  float largest = 0.0;
  for (int n = looks_through.x; n < looks_through.y && count < SOFT_VIEWS; ++n) {
    int i = texelFetch(nearest_first, n).r;
    View v = ViewAt(i);
    vec2 img;
    if (Frame(v, InView(v, point), img) <= 0.0) continue;
    vec3 to_view = v.center.xyz - point;
    float inverse_length = inversesqrt(dot(to_view, to_view));
    float p = atan(length(cross(back, to_view)) * inverse_length, dot(back, to_view) * inverse_length) +
              resolution_penalty * max(0.0, 1.0 / (inverse_length * to_virtual) - 1.0);
    chosen[count] = i;
    penalty[count] = p;
    asides[count] = vec2(dot(to_view, right), dot(to_view, up)) * inverse_length;
    ++count;
    largest = max(largest, p);
    float q = p;
    for (int k = 0; k < 4; ++k) {
      float low = min(least[k], q);
      q = max(least[k], q);
      least[k] = low;
    }
  }
  float fourth = max(zero_penalty, count > 3 ? least.w : largest);
  float width = width_of_fourth * fourth;
  reach = width;
  float nothing = count == SOFT_VIEWS ? max(LEAST_WEIGHT, Gaussian(largest, width)) : LEAST_WEIGHT;
  nothing = min(nothing, MOST_TAKEN * Gaussian(least.x, width));
  // Views without weight go, so that loops over the others end sooner.
  int weighing = 0;
  for (int n = 0; n < count; ++n) {
    float own = OWN_SHARE * fourth / max(penalty[n], zero_penalty);
    float weight = max(0.0, Gaussian(penalty[n], width) - nothing) * (1.0 + own * own);
    if (weight > 0.0) {  // in order of penalty
      int view = chosen[n], at = weighing;
      vec2 aside = asides[n];
      float p = penalty[n];
      for (; at > 0 && penalty[at - 1] > p; --at) {
        chosen[at] = chosen[at - 1];
        penalty[at] = penalty[at - 1];
        weights[at] = weights[at - 1];
        asides[at] = asides[at - 1];
      }
      chosen[at] = view;
      penalty[at] = p;
      weights[at] = weight;
      asides[at] = aside;
      ++weighing;
    }
  }
  count = weighing;
}

#ifdef MAPS
// The map's inverse depth where it shows the point; 0: unknown.
float MapAt(View v, DepthMap map, vec3 in_view, out ivec2 at) {
  at = ivec2(0);
  if (in_view.z <= 0.0) return 0.0;
  vec2 pixel = floor(map.intrinsics.xy * in_view.xy / in_view.z + map.intrinsics.zw);
  at = ivec2(pixel);
  if (any(lessThan(pixel, vec2(0.0))) || any(greaterThanEqual(pixel, map.more.xy))) return 0.0;
  return texelFetch(depth_maps, ivec3(at, v.place.z), 0).r * map.more.z;
}

float candidates[SOFT_PROPOSERS + 1];  // inverse depths, from near to far
int found = 0;

void Insert(float inverse_depth) {
  int at = found;
  while (at > 0 && candidates[at - 1] < inverse_depth) {
    candidates[at] = candidates[at - 1];
    --at;
  }
  candidates[at] = inverse_depth;
  ++found;
}

// Where the view's map meets the ray.
void Propose(int i, vec3 ray, float inverse_depth) {
  View v = ViewAt(i);
  DepthMap map = DepthMapAt(i);
  float at = inverse_depth;
  bool settled = false;
  for (int step = 0; step < SEARCH_STEPS; ++step) {
    settled = false;
    vec3 in_view = InView(v, ray / at);
    if (in_view.z <= 0.0) break;
    ivec2 pixel;
    float surface = MapAt(v, map, in_view, pixel);
    if (surface <= 0.0) break;
    vec3 on_surface = vec3((vec2(pixel) + 0.5 - map.intrinsics.zw) / map.intrinsics.xy, 1.0) / surface;
    vec3 moved = on_surface - vec3(v.row0.w, v.row1.w, v.row2.w);
    float depth = dot(vec3(v.row0.z, v.row1.z, v.row2.z), moved);
    if (depth <= 0.0) break;
    settled = abs(1.0 / depth - at) < SEARCH_END * map.more.w;
    at = 1.0 / depth;
  }
  if (settled) Insert(at);
}
#endif

// A candidate's light; returns the share of the light that photographs have, times what the best view sees.
float Blend(vec3 ray, float inverse_depth, out vec3 mean, out float belief, out float resident) {
  vec3 point = ray / inverse_depth;
  float votes = 0.0, voters = 0.0, most_seen = 0.0, lit_sum = 0.0, sum = 0.0, wanted = 0.0;
  float sample_weight[SOFT_VIEWS];
  vec2 sample_aside[SOFT_VIEWS], aside = vec2(0.0);
  vec3 products = vec3(0.0);
  vec3 light[SOFT_VIEWS];
  int samples = 0;
  vec3 mean_root = vec3(0.0), mean_square = vec3(0.0);
  for (int n = 0; n < count; ++n) {
    View v = ViewAt(chosen[n]);
    vec3 in_view = InView(v, point);
    vec2 img;
    float feather = Frame(v, in_view, img);
    if (feather <= 0.0) continue;
    float seen = 1.0;
#ifdef MAPS
    DepthMap map = DepthMapAt(chosen[n]);
    ivec2 pixel;
    float surface = MapAt(v, map, in_view, pixel);
    if (surface > 0.0) {
      float in_front = (1.0 / in_view.z - surface) / map.more.w;  // of the surface, in steps
      votes += weights[n] * Gaussian(in_front, VOTE);
      if (in_front > -OCCLUDED) voters += weights[n];
      seen = clamp((in_front + OCCLUDED) / (OCCLUDED - VOTE), LEAST_SEEN, 1.0);
    }
#else
    seen = max(LEAST_SEEN, ShadowMapVisibility(v.shadow_map, v.place, in_view));
#endif
    wanted += weights[n] * seen * feather;
#ifndef SHOW_FIELD
    if (v.place.x < 0) continue;
#endif
    float share;
    vec3 bgr = LightOf(v, img, share);
    float lit = weights[n] * seen * feather * share;
    if (lit <= 0.0) continue;
    vec3 root = sqrt(max(bgr, vec3(0.0)));
    most_seen = max(most_seen, seen);
    lit_sum += lit;
    sum += lit / (feather * share);
    mean_root += lit * root;
    mean_square += lit * root * root;
    vec2 a = asides[n];
    aside += lit * a;
    products += lit * vec3(a.x * a.x, a.x * a.y, a.y * a.y);
    sample_aside[samples] = a;
    sample_weight[samples] = lit;
    light[samples] = bgr;
    ++samples;
  }
  belief = voters > 0.0 ? votes / voters : 0.0;
  resident = 0.0;
  mean = vec3(0.0);
  if (samples == 0) return 0.0;
  resident = wanted > 0.0 ? min(1.0, lit_sum / wanted) : 0.0;
  mean_root /= lit_sum;
  vec3 variance = max(vec3(0.0), mean_square / lit_sum - mean_root * mean_root);
  if (samples > 1) belief *= exp(-0.5 * (variance.r + variance.g + variance.b) / (AGREEING * AGREEING));
  aside /= lit_sum;
  products = products / lit_sum - vec3(aside.x * aside.x, aside.x * aside.y, aside.y * aside.y);
  products.xz += vec2(BALANCED * reach * reach);
  vec2 slope = vec2(products.z * aside.x - products.y * aside.y, products.x * aside.y - products.y * aside.x) /
               (products.x * products.z - products.y * products.y);
  float balanced_sum = 0.0;
  for (int n = 0; n < samples; ++n) {
    sample_weight[n] *= max(0.0, 1.0 - dot(slope, sample_aside[n] - aside));
    mean += sample_weight[n] * light[n];
    balanced_sum += sample_weight[n];
  }
  mean /= balanced_sum;
  for (int step = 0; step < ROBUST_STEPS; ++step) {
    vec3 root = sqrt(max(mean, vec3(0.0)));
    mean = vec3(0.0);
    float total = 0.0;
    for (int n = 0; n < samples; ++n) {
      vec3 off = sqrt(max(light[n], vec3(0.0))) - root;
      float robust = sample_weight[n] / (1.0 + dot(off, off) / (ROBUST * ROBUST));
      mean += robust * light[n];
      total += robust;
    }
    mean /= total;
  }
  return most_seen * lit_sum / sum;
}

void main() {
  color = vec4(0.0);
  if (goes_on) color = texelFetch(before, ivec2(gl_FragCoord.xy), 0);
  vec3 ray = RayOfPixel();
  float inverse_depth = 1.0 / DepthOf(ray);
  Choose(ray / inverse_depth);
  if (count == 0) return;
  vec3 light = vec3(0.0), mean;
  float left = 1.0, sum = 0.0, seen = 0.0, here = 0.0, belief, resident;
#ifdef MAPS
  Insert(inverse_depth);
  float step = 1e30;  // of the finest map
  for (int n = 0; n < min(count, SOFT_PROPOSERS); ++n) {
    Propose(chosen[n], ray, inverse_depth);
    step = min(step, DepthMapAt(chosen[n]).more.w);
  }
  // Of candidates that are nearly one, the nearest stays.
  int kept = 1;
  for (int n = 1; n < found; ++n)
    if (candidates[kept - 1] - candidates[n] > MERGED * step) candidates[kept++] = candidates[n];
  for (int n = 0; n < kept; ++n) {
    float lit = Blend(ray, candidates[n], mean, belief, resident);
    if (resident <= 0.0) continue;
    if (kept == 1) belief = 1.0;
    float share = min(left, belief) + 1e-6;
    light += share * mean;
    sum += share;
    seen += share * lit;
    here += share * resident;
    left -= min(left, belief);
    if (left < 0.001) break;
  }
#else
  seen = Blend(ray, inverse_depth, light, belief, here);
  sum = here > 0.0 ? 1.0 : 0.0;
#endif
  if (sum <= 0.0) return;
  float weight = seen / sum;
  if (in_passes) weight *= here / sum;
  color += weight * vec4(light / sum, 1.0);
}
