// Fills a pixel that its own views hardly cover (the depth test decides): with lumigraph weights of the
// nearest views that see its point, or from the nearest view that has the point in its image although the
// proxy hides it. Alpha: -1 filled, -2 empty, else the confidence; where the nearest view is the field
// itself, the view's feather. Between passes, when not all photographs are resident at the same time: light
// times weight, weight - 8. Skips views whose photographs have no light there, as far as the photographs are
// resident. MARK: draws nothing; marks the views that the pixel needs, whether their photographs are resident
// or not, and views whose shadow maps are needed and missing.
layout(binding = 10) uniform isamplerBuffer nearest_first;  // views of each tile
flat in ivec2 looks_through;  // first and end in nearest_first
uniform int asked;            // views to find that have light everywhere; 1: the first view gets all weight
uniform bool waits;           // all photographs are drawn, a few at a time
uniform float resolution_penalty;
uniform float zero_penalty;
uniform float above_tie;
uniform float above_largest;
#ifdef MARK
layout(early_fragment_tests) in;
layout(std430, binding = 3) writeonly buffer Needed { int needed[]; };
#else
layout(binding = 11) uniform sampler2D resolved;  // the target, or a copy of it
layout(binding = 15) uniform sampler2D before;
uniform bool nearest_is_the_field;
uniform bool goes_on;  // after passes over nearer views
uniform bool last;
out vec4 color;
#endif

const int kMost = 9;
int chosen[kMost];
float penalty[kMost];
int count = 0;
bool hidden = false;       // the point is hidden from the chosen views
bool passed_over = false;  // a view sees the point but has no light there
bool elsewhere = false;    // a view that sees the point is drawn in another pass

// False where the photograph is known to have no light there.
bool MayHaveLight(View v, vec2 img) {
#if defined(GAPS) && !defined(MARK) && !defined(SHOW_FIELD)
  if (v.place.x >= 0) return Photograph(v.place, img / v.size.xy).a > 0.0;
#endif
  return true;
}

// Whether the view certainly has light there, so that the search can end with it.
bool HasLight(View v) {
#if defined(GAPS) && !defined(MARK) && !defined(SHOW_FIELD)
  if (v.place.x >= 0) return true;
#endif
  return v.center.w <= 0.0;
}

bool IsThere(View v) {
#if defined(MARK) || defined(SHOW_FIELD)
  return true;
#else
  return waits || v.place.x >= 0;
#endif
}

void Choose(vec3 point) {
  float to_virtual = length(point);
  vec3 back = -point / to_virtual;
  int left = asked;
#ifdef MARK
  int unknown = 0;
#endif
  for (int n = looks_through.x; n < looks_through.y; ++n) {
    int i = texelFetch(nearest_first, n).r;
    View v = ViewAt(i);
    if (!IsThere(v)) continue;
    vec2 img;
    vec3 in_view = InView(v, point);
    float feather = Frame(v, in_view, img);
    if (feather <= 0.0) continue;
#if defined(MARK) && defined(HIDES)
    if (v.place.w < 0) {  // without a map the point may be hidden: maps are requested a few at a time
      needed[i] = 1;
      if (++unknown == 4) break;
      continue;
    }
#endif
    if (feather * ShadowMapVisibility(v.shadow_map, v.place, in_view) <= 0.0) continue;
    if (!MayHaveLight(v, img)) {
      passed_over = true;
      continue;
    }
#ifdef MARK
    needed[i] = 1;
    ++count;
    if (HasLight(v) && --left == 0) return;
    continue;
#endif
#ifndef SHOW_FIELD
    if (asked == 1 && v.place.x < 0) {  // passes go from near to far: a nearer view has been drawn before
      elsewhere = true;
      continue;
    }
#endif
    vec3 to_view = v.center.xyz - point;
    float inverse_length = inversesqrt(dot(to_view, to_view));
    penalty[count] = atan(length(cross(back, to_view)) * inverse_length, dot(back, to_view) * inverse_length) +
                     resolution_penalty * max(0.0, 1.0 / (inverse_length * to_virtual) - 1.0);
    chosen[count] = i;
    if (++count == kMost) return;
    if (HasLight(v) && --left == 0) return;
  }
#ifdef HIDES
  if (count > 0 || elsewhere) return;
  hidden = true;
  for (int n = looks_through.x; n < looks_through.y; ++n) {
    int i = texelFetch(nearest_first, n).r;
    View v = ViewAt(i);
    vec2 img;
    if (!IsThere(v) || Frame(v, InView(v, point), img) <= 0.0 || !MayHaveLight(v, img)) continue;
#ifdef MARK
    needed[i] = 1;
#else
    chosen[count] = i;
    if (++count == kMost) return;
#endif
    if (HasLight(v)) return;
  }
#endif
}

#ifdef MARK
void main() {
  vec3 ray = RayOfPixel();
  Choose(ray * DepthOf(ray));
}
#else
// Adds a view in whose image the point is at `img`.
void Add(View v, float weight, vec2 img) {
#ifndef SHOW_FIELD
  if (v.place.x < 0) return;
#endif
  float share;
  vec3 light = LightOf(v, img, share);
  if (weight * share > 0.0) color += weight * share * vec4(light, 1.0);
}

void main() {
  color = vec4(0.0);
  if (goes_on) color = texelFetch(before, ivec2(gl_FragCoord.xy), 0) + vec4(0.0, 0.0, 0.0, 8.0);
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  Choose(point);
  bool first_only = hidden || asked == 1;
  float largest = 0.0, second = 0.0, least = 1e30;
  int worst = 0;
  for (int n = 0; n < count; ++n) {
    second = max(second, min(largest, penalty[n]));
    if (penalty[n] >= largest) worst = n;
    largest = max(largest, penalty[n]);
    least = min(least, penalty[n]);
  }
  float threshold = count >= asked ? max(largest, above_tie * second) : above_largest * largest;
  float total = 0.0;
  for (int n = 0; n < count && !first_only; ++n) {
    penalty[n] = least <= zero_penalty ? (penalty[n] == least ? 1.0 : 0.0)
                                       : max(0.0, 1.0 - penalty[n] / threshold) / penalty[n];
    if (count >= asked && n == worst) penalty[n] = 0.0;  // this view only gives the threshold
    total += penalty[n];
  }
  for (int n = 0; n < count; ++n) {
    if (first_only && color.a > 0.0) break;
    View v = ViewAt(chosen[n]);
    vec3 in_view = InView(v, point);
    vec2 img;
    float feather = Frame(v, in_view, img);
    float seen = hidden ? 1.0 : feather * ShadowMapVisibility(v.shadow_map, v.place, in_view);
    Add(v, first_only ? seen : penalty[n] / total * seen, img);
  }
  if (!last) {
    color.a -= 8.0;
    return;
  }
  float own_confidence;
  vec4 own = Own(texelFetch(resolved, ivec2(gl_FragCoord.xy), 0), own_confidence);
  float own_share = min(1.0, own.a / whole_weight);
  if (own_share <= 0.0 && color.a <= 0.0) {
    color = vec4(0.0, 0.0, 0.0, -2.0);
  } else if (own_share <= 0.0) {
    color = vec4(color.rgb / color.a, nearest_is_the_field && !hidden && !passed_over ? color.a : -1.0);
  } else {
    vec3 light = own.rgb;
    if (color.a > 0.0) light = mix(color.rgb / color.a, light, own_share);
    color = vec4(light, own_confidence * own.a);
  }
}
#endif
