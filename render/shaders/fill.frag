// Where nothing covered the pixel (the depth test knows): the nearest view that sees it, or has it in its image though
// the proxy hides it. Alpha: -1 filled, -2 empty;
// where the nearest view is the field itself, its feather.
layout(std430, binding = 4) readonly buffer NearestFirst { int nearest_first[]; };
uniform int view_count;  // 0: fill nothing
uniform bool nearest_is_the_field;
out vec4 color;

void main() {
  color = vec4(0.0, 0.0, 0.0, -2.0);
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  for (int n = 0; n < view_count; ++n) {
    int i = nearest_first[n];
    vec2 img;
    vec3 in_view = InView(views[i], point);
    float feather = Frame(views[i], in_view, img);
    if (feather <= 0.0) continue;
    float seen = feather * SightShare(views[i], in_view);
    if (seen <= 0.0 && color.a > -2.0) continue;
    float share;
    vec3 light = LightOf(views[i], img, share);
    if (share <= 0.0) continue;
    color = vec4(light, nearest_is_the_field && seen > 0.0 ? seen * share : -1.0);
    if (seen > 0.0) break;
  }
}
