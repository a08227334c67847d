// What every fragment shader knows: where a point falls in a view, and the plane of the proxy.
// Points are in the virtual camera's frame (x right, y down, z forward); row 0 of the target is the image's top.

layout(binding = 0) uniform sampler2DArray photographs[ARRAYS];

uniform vec4 camera;     // fx fy cx cy
uniform vec4 plane;      // normal, offset
uniform float far_depth;

vec3 RayOfPixel() { return vec3((gl_FragCoord.xy - camera.zw) / camera.xy, 1.0); }

float DepthOf(vec3 ray) {
  float slope = dot(plane.xyz, ray);
  return slope * far_depth <= plane.w ? far_depth : plane.w / slope;
}

// Software rasterisers walk through both sides of every branch: distortions that no view has are left out.
bool Distort(View v, vec3 q, out vec2 p) {
#ifdef FISHEYE
  if (v.more.w > 1.5) {
    float rho = length(q.xy);
    float theta = atan(rho, q.z);
    if (theta > v.size.w) return false;
    float t2 = theta * theta;
    float radius = theta * (1.0 + t2 * (v.k.x + t2 * (v.k.y + t2 * (v.k.z + t2 * v.k.w))));
    p = rho > 1e-9 ? q.xy * (radius / rho) : q.xy / q.z;
    return true;
  }
#endif
  p = q.xy / q.z;
#ifdef RADIAL_TANGENTIAL
  if (v.more.w > 0.5) {
    float r2 = dot(p, p);
    if (r2 > v.size.w) return false;
    float radial = 1.0 + r2 * (v.k.x + r2 * (v.k.y + r2 * v.more.x));
    p = p * radial + vec2(2.0 * v.k.z * p.x * p.y + v.k.w * (r2 + 2.0 * p.x * p.x),
                          v.k.z * (r2 + 2.0 * p.y * p.y) + 2.0 * v.k.w * p.x * p.y);
  }
#endif
  return q.z > 1e-12;
}

// Where the view sees the point, and its feather, 0 when it does not see it.
float See(View v, vec3 point, out vec2 img) {
  vec4 h = vec4(point, 1.0);
  vec2 p;
  if (!Distort(v, vec3(dot(v.row0, h), dot(v.row1, h), dot(v.row2, h)), p)) return 0.0;
  img = v.intrinsics.xy * p + v.intrinsics.zw;
  vec2 to_edge = min(img, v.size.xy - img);
  return clamp(min(to_edge.x, to_edge.y) / v.size.z, 0.0, 1.0);
}

vec3 Photograph(ivec4 place, vec2 uv) {
  vec3 at = vec3(uv, float(place.y));
  float level = float(place.z);
  if (ARRAYS == 1) return textureLod(photographs[0], at, level).rgb;
  vec3 light = vec3(0.0);
  for (int n = 0; n < ARRAYS; ++n)
    if (n == place.x) light = textureLod(photographs[n], at, level).rgb;
  return light;
}

vec3 LightOf(View v, vec2 img) {
#ifdef SHOW_FIELD
  return v.color.rgb;
#else
  return (Photograph(v.place, img / v.size.xy) - v.more.y) * v.more.z;
#endif
}
