// DIRECT: every triangle has one batch, and its pixels are finished at once.
flat in vec4 right[VIEWS], down[VIEWS], numerator[VIEWS], layers[(VIEWS + 3) / 4];
flat in vec4 denominator;
#ifdef ONE_CAMERA
#define OF_CAMERA(what, n) what
#else
flat in vec4 to_uv[VIEWS];
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
flat in vec4 size[VIEWS], k[VIEWS], more[VIEWS];
#endif
#ifdef HIDES
flat in vec4 shadow_map[VIEWS];
#endif
#define OF_CAMERA(what, n) what[n]
#endif
#if defined(FISHEYE) || defined(RADIAL_TANGENTIAL)
#define DISTORT(n, q, p) Distort(OF_CAMERA(size, n), OF_CAMERA(k, n), OF_CAMERA(more, n), q, p)
#else
#define DISTORT(n, q, p) Distort(vec4(0.0), vec4(0.0), vec4(0.0), q, p)
#endif
#ifdef ONE_EXPOSURE
#define LIGHT(n) light
#else
flat in vec4 light[VIEWS];
#define LIGHT(n) light[n]
#endif
#ifdef CORRECTED
flat in vec4 correction[VIEWS];
// The principal point and the photograph's size in one unit, the feather's width.
#define SCALE(n, uv) Correction(correction[n], LIGHT(n).w, (uv - OF_CAMERA(to_uv, n).zw) * LIGHT(n).xy, LIGHT(n).xy)
#else
#define SCALE(n, uv) LIGHT(n).w
#endif
#ifdef SHOW_FIELD
flat in vec4 color_of_view[VIEWS];
#endif
out vec4 color;  // a finished pixel (resolve.glsl), or to be added up: light times weight, weight

void main() {
  vec3 ray = RayOfPixel();
  float inverse_depth = 1.0 / DepthOf(ray);
  float share = 1.0 / max(dot(denominator.xyz, ray), 1e-30);
  vec4 all = vec4(0.0);
  for (int n = 0; n < VIEWS; ++n) {
    vec3 forward = cross(right[n].xyz, down[n].xyz);
    vec3 in_view = vec3(dot(right[n].xyz, ray), dot(down[n].xyz, ray), dot(forward, ray)) +
                   inverse_depth * vec3(right[n].w, down[n].w, numerator[n].w);  // over its depth in this camera
    vec2 p;
    bool before = DISTORT(n, in_view, p);
    vec2 uv = OF_CAMERA(to_uv, n).xy * p + OF_CAMERA(to_uv, n).zw;
    vec2 to_edge = min(uv, 1.0 - uv) * LIGHT(n).xy;
    float weight = dot(numerator[n].xyz, ray) * share * clamp(min(to_edge.x, to_edge.y), 0.0, 1.0);
    float layer = layers[n / 4][n % 4];
#ifdef HIDES
    float shadow_map_layer = floor(layer / 4096.0);
    layer -= 4096.0 * shadow_map_layer;
    weight *= ShadowMapVisibility(OF_CAMERA(shadow_map, n), ivec4(0, 0, 0, int(shadow_map_layer) - 1), in_view / inverse_depth);
#endif
    weight = before ? max(weight, 0.0) : 0.0;
#ifdef SHOW_FIELD
    all += weight * vec4(color_of_view[n].rgb, 1.0);
#else
    vec4 of_photograph = textureLod(photographs[0], vec3(uv, layer), 0.0);
#ifdef GAPS
    weight *= of_photograph.a;
    of_photograph.rgb /= max(of_photograph.a, 1e-6);
    if (weight > 0.0)
#endif
    all += weight * vec4((of_photograph.rgb - LIGHT(n).z) * SCALE(n, uv), 1.0);
#endif
  }
#ifdef DIRECT
  color = Resolved(all.rgb / all.a, all.a, denominator.w);
  gl_FragDepth = IsOpen(color) ? 0.0 : 1.0;
#else
  color = all;
#endif
}
