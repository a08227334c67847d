// Pixels that nothing covered take the nearest view that sees them. Alpha: the confidence; -1 filled, -2 empty.
layout(std430, binding = 4) readonly buffer NearestFirst { int nearest_first[]; };
layout(binding = 15) uniform sampler2D drawn;
uniform int view_count;
uniform bool fill;
uniform bool nearest_is_the_field;
out vec4 color;

void main() {
  color = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  if (color.a > 0.0) return;
  color = vec4(0.0, 0.0, 0.0, -2.0);
  if (!fill && !nearest_is_the_field) return;
  vec3 ray = RayOfPixel();
  vec3 point = ray * DepthOf(ray);
  for (int n = 0; n < view_count; ++n) {
    int i = nearest_first[n];
    vec2 img;
    float feather = See(i, point, img);
    if (feather <= 0.0) continue;
    color = vec4(LightOf(i, img), nearest_is_the_field ? feather : -1.0);
    return;
  }
}
