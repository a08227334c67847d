// What every fragment shader knows: the views, where a point falls in them, and the plane of the proxy.
// Points are in the virtual camera's frame (x right, y down, z forward); row 0 of the target is the image's top.

struct View {
  vec4 row0, row1, row2;  // view_from_cam, 3x4
  vec4 intrinsics;        // fx fy cx cy
  vec4 size;              // width, height, feather in pixels, how far the distortion is trusted (r^2, or theta)
  vec4 k;                 // k1 k2 p1 p2, or k1 k2 k3 k4
  vec4 more;              // k3, black, scale, distortion: 0 none, 1 radial-tangential, 2 fisheye
  vec4 color;             // of the blending field's picture
  vec4 center;            // of the view
  ivec4 place;            // texture array, layer, level
};
layout(std430, binding = 0) readonly buffer Views { View views[]; };

layout(binding = 0) uniform sampler2DArray photographs[ARRAYS];

uniform vec4 camera;     // fx fy cx cy
uniform vec4 plane;      // normal, offset
uniform float far_depth;
uniform bool show_field;
uniform float least_weight;

vec3 RayOfPixel() { return vec3((gl_FragCoord.xy - camera.zw) / camera.xy, 1.0); }

float DepthOf(vec3 ray) {
  float slope = dot(plane.xyz, ray);
  return slope * far_depth <= plane.w ? far_depth : plane.w / slope;
}

bool Distort(int i, vec3 q, out vec2 p) {
  if (views[i].more.w > 1.5) {
    float rho = length(q.xy);
    float theta = atan(rho, q.z);
    if (theta > views[i].size.w) return false;
    vec4 k = views[i].k;
    float t2 = theta * theta;
    float radius = theta * (1.0 + t2 * (k.x + t2 * (k.y + t2 * (k.z + t2 * k.w))));
    p = rho > 1e-9 ? q.xy * (radius / rho) : q.xy / q.z;
    return true;
  }
  if (q.z <= 1e-12) return false;
  p = q.xy / q.z;
  if (views[i].more.w > 0.5) {
    float r2 = dot(p, p);
    if (r2 > views[i].size.w) return false;
    vec4 k = views[i].k;
    float radial = 1.0 + r2 * (k.x + r2 * (k.y + r2 * views[i].more.x));
    p = p * radial + vec2(2.0 * k.z * p.x * p.y + k.w * (r2 + 2.0 * p.x * p.x),
                          k.z * (r2 + 2.0 * p.y * p.y) + 2.0 * k.w * p.x * p.y);
  }
  return true;
}

// Where view i sees the point, and its feather, 0 when it does not see it.
float See(int i, vec3 point, out vec2 img) {
  vec4 h = vec4(point, 1.0);
  vec2 p;
  if (!Distort(i, vec3(dot(views[i].row0, h), dot(views[i].row1, h), dot(views[i].row2, h)), p)) return 0.0;
  img = views[i].intrinsics.xy * p + views[i].intrinsics.zw;
  vec2 to_edge = min(img, views[i].size.xy - img);
  return clamp(min(to_edge.x, to_edge.y) / views[i].size.z, 0.0, 1.0);
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

vec3 LightOf(int i, vec2 img) {
  if (show_field) return views[i].color.rgb;
  return (Photograph(views[i].place, img / views[i].size.xy) - views[i].more.y) * views[i].more.z;
}

vec4 Normalised(vec3 light, float weight, float confidence) {
  return weight < least_weight ? vec4(0.0) : vec4(light / weight, confidence * min(1.0, weight));
}
