// Where nothing covered the pixel (the depth test knows): the nearest view that sees it, or has it in its image though
// the proxy hides it. Alpha: -1 filled, -2 empty; where the nearest view is the field itself, its feather. Between
// passes, when photographs are not there all at once: -1.5 filled by a view from which the proxy hides it.
// With MARK nothing is drawn: which views would be needed is marked, whether their photographs are there or not, and
// those of which it is not known yet what the proxy hides from them.
layout(binding = 10) uniform isamplerBuffer nearest_first;  // views of each tile
flat in ivec2 looks_through;  // of nearest_first
uniform bool nearest_is_the_field;

#ifdef MARK
layout(early_fragment_tests) in;
layout(std430, binding = 3) writeonly buffer Needed { int needed[]; };

void main() {
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  bool filled = false;
  int unknown = 0;
  for (int n = looks_through.x; n < looks_through.y; ++n) {
    int i = texelFetch(nearest_first, n).r;
    View v = ViewAt(i);
    vec2 img;
    vec3 in_view = InView(v, point);
    float feather = Frame(v, in_view, img);
    if (feather <= 0.0) continue;
#ifdef HIDES
    if (v.place.w < 0) {  // it may be hidden from there: a few at a time are found out
      needed[i] = 1;
      if (++unknown == 4) break;
      continue;
    }
#endif
    float seen = feather * SightShare(v.sight, v.place, in_view);
    if (seen <= 0.0 && filled) continue;
    needed[i] = 1;
    if (v.center.w > 0.0) continue;  // there may be no light
    filled = true;
    if (seen > 0.0) break;
  }
}
#else
layout(binding = 15) uniform sampler2D before;
uniform bool goes_on;  // after passes over nearer views
uniform bool last;
out vec4 color;

void main() {
  color = vec4(0.0, 0.0, 0.0, -2.0);
  if (goes_on) color = texelFetch(before, ivec2(gl_FragCoord.xy), 0);
  if (color.a > -1.25) return;
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  for (int n = looks_through.x; n < looks_through.y; ++n) {
    int i = texelFetch(nearest_first, n).r;
    View v = ViewAt(i);
#ifndef SHOW_FIELD
    if (v.place.x < 0) continue;
#endif
    vec2 img;
    vec3 in_view = InView(v, point);
    float feather = Frame(v, in_view, img);
    if (feather <= 0.0) continue;
    float seen = feather * SightShare(v.sight, v.place, in_view);
    if (seen <= 0.0 && color.a > -2.0) continue;
    float share;
    vec3 light = LightOf(v, img, share);
    if (share <= 0.0) continue;
    color = vec4(light, seen <= 0.0 ? -1.5 : nearest_is_the_field ? seen * share : -1.0);
    if (seen > 0.0) break;
  }
  if (last && color.a == -1.5) color.a = -1.0;
}
#endif
