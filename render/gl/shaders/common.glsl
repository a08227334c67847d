// For all fragment shaders: where a point falls in a view, and the depth of the proxy. Points are in the
// virtual camera's frame (x right, y down, z forward); row 0 of the target is the image's top.

layout(binding = 0) uniform sampler2DArray photographs[ARRAYS];

uniform vec4 camera;     // fx fy cx cy
uniform vec4 plane;      // normal, offset
uniform float far_depth;
#ifdef TRIANGLES
layout(binding = 12) uniform sampler2D proxy_depth;  // 0 without a triangle
#endif
#ifdef HIDES
layout(binding = 13) uniform sampler2DArrayShadow shadow_maps;
#endif

vec3 RayOfPixel() { return vec3((gl_FragCoord.xy - camera.zw) / camera.xy, 1.0); }

// The proxy's depth at this pixel.
float DepthOf(vec3 ray) {
#ifdef TRIANGLES
  float depth = texelFetch(proxy_depth, ivec2(gl_FragCoord.xy), 0).r;
  if (depth > 0.0) return depth;
#endif
  float slope = dot(plane.xyz, ray);
  return slope * far_depth <= plane.w ? far_depth : plane.w / slope;
}

// Software rasterisers execute both sides of every branch: code for distortions that no view has is left out.
bool Distort(vec4 size, vec4 k, vec4 more, vec3 q, out vec2 p) {
  p = vec2(0.0);
#ifdef FISHEYE
  if (more.w > 1.5) {
    float rho = length(q.xy);
    float theta = atan(rho, q.z);
    if (theta > size.w) return false;
    float t2 = theta * theta;
    float radius = theta * (1.0 + t2 * (k.x + t2 * (k.y + t2 * (k.z + t2 * k.w))));
    p = rho > 1e-9 ? q.xy * (radius / rho) : q.xy / q.z;
    return true;
  }
#endif
  p = q.xy / q.z;
#ifdef RADIAL_TANGENTIAL
  if (more.w > 0.5) {
    float r2 = dot(p, p);
    if (r2 > size.w) return false;
    float radial = 1.0 + r2 * (k.x + r2 * (k.y + r2 * more.x));
    p = p * radial + vec2(2.0 * k.z * p.x * p.y + k.w * (r2 + 2.0 * p.x * p.x),
                          k.z * (r2 + 2.0 * p.y * p.y) + 2.0 * k.w * p.x * p.y);
  }
#endif
  return q.z > 1e-12;
}

// The point's place in the view's image; returns the feather, 0 outside the image.
float Frame(View v, vec3 in_view, out vec2 img) {
  vec2 p;
  if (!Distort(v.size, v.k, v.more, in_view, p)) return 0.0;
  img = v.intrinsics.xy * p + v.intrinsics.zw;
  vec2 to_edge = min(img, v.size.xy - img);
  return clamp(min(to_edge.x, to_edge.y) / v.size.z, 0.0, 1.0);
}

vec3 InView(View v, vec3 point) {
  vec4 h = vec4(point, 1.0);
  return vec3(dot(v.row0, h), dot(v.row1, h), dot(v.row2, h));
}

// The visibility of the point: 0 hidden by the proxy to 1 visible.
float ShadowMapVisibility(vec4 shadow_map, ivec4 place, vec3 in_view) {
#ifdef HIDES
  if (in_view.z <= 0.0 || place.w < 0) return 1.0;
  vec2 uv = shadow_map.xy * in_view.xy / in_view.z + shadow_map.zw;
  if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
  return texture(shadow_maps, vec4(uv, float(place.w), SHADOW_MAP_SCALE / in_view.z));
#else
  return 1.0;
#endif
}

// The point's place in the view's image; returns the feather times the visibility, 0 where the view does not
// see it.
float See(View v, vec3 point, out vec2 img) {
  vec3 in_view = InView(v, point);
  float feather = Frame(v, in_view, img);
  return feather > 0.0 ? feather * ShadowMapVisibility(v.shadow_map, v.place, in_view) : 0.0;
}

vec4 Photograph(ivec4 place, vec2 uv) {
  vec3 at = vec3(uv, float(place.y));
#if ARRAYS == 1
  return textureLod(photographs[0], at, 0.0);
#else
  vec4 light = vec4(0.0);
  for (int n = 0; n < ARRAYS; ++n)
    if (n == place.x) light = textureLod(photographs[n], at, 0.0);
  return light;
#endif
}

#ifdef CORRECTED
// What light on the common scale is multiplied by, for a view's correction. `from_axis`: from the principal
// point, in the units of `size`, the photograph's.
vec3 Correction(vec4 correction, float falloff_r4, vec2 from_axis, vec2 size) {
  float r2 = 4.0 * dot(from_axis, from_axis) / dot(size, size);
  return correction.rgb / (1.0 + r2 * (correction.w + r2 * falloff_r4));
}
#endif

// `share`: the share of the photograph's pixels there that have light at all.
vec3 LightOf(View v, vec2 img, out float share) {
  share = 1.0;
#ifdef SHOW_FIELD
  return v.color.rgb;
#else
  vec4 light = Photograph(v.place, img / v.size.xy);
#ifdef GAPS
  share = light.a;
  light.rgb /= max(light.a, 1e-6);
#endif
  vec3 above_black = light.rgb - v.more.y;
#ifdef CORRECTED
  above_black *= Correction(v.correction, v.color.w, img - v.intrinsics.zw, v.size.xy);
#endif
  return above_black * v.more.z;
#endif
}
