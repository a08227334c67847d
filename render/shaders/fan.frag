flat in vec4 row0, row1, row2, to_uv, light;
flat in vec3 nearness, numerator, denominator;
flat in ivec4 place;
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
flat in vec4 size, k, more;
#else
const vec4 size = vec4(0.0), k = vec4(0.0), more = vec4(0.0);
#endif
#ifdef SHOW_FIELD
flat in vec4 color_of_view;
#endif
#ifdef HIDES
flat in vec4 sight;
#endif
out vec4 color;  // added up: light times weight, weight

void main() {
  vec3 pixel = vec3(gl_FragCoord.xy, 1.0);
  float inverse_depth = max(dot(nearness, pixel), 1.0 / far_depth);
#ifdef TRIANGLES
  float depth = texelFetch(proxy_depth, ivec2(gl_FragCoord.xy), 0).r;
  if (depth > 0.0) inverse_depth = 1.0 / depth;
#endif
  vec4 h = vec4(pixel, inverse_depth);
  vec3 in_view = vec3(dot(row0, h), dot(row1, h), dot(row2, h));
  vec2 p;
  bool before = Distort(size, k, more, in_view, p);
  vec2 uv = to_uv.xy * p + to_uv.zw;
  vec2 to_edge = min(uv, 1.0 - uv) * light.xy;
  float weight = dot(numerator, pixel) / max(dot(denominator, pixel), 1e-30) * clamp(min(to_edge.x, to_edge.y), 0.0, 1.0);
#ifdef HIDES
  weight *= SightShare(sight, place, in_view / inverse_depth);
#endif
  weight = before ? max(weight, 0.0) : 0.0;
  // Nothing is discarded: that would keep the depth test from coming first.
#ifdef SHOW_FIELD
  color = weight * vec4(color_of_view.rgb, 1.0);
#else
  vec4 of_photograph = Photograph(place, uv);
#ifdef GAPS
  weight *= of_photograph.a;
  of_photograph.rgb /= max(of_photograph.a, 1e-6);
  color = weight > 0.0 ? weight * vec4((of_photograph.rgb - light.z) * light.w, 1.0) : vec4(0.0);
#else
  color = weight * vec4((of_photograph.rgb - light.z) * light.w, 1.0);
#endif
#endif
}
