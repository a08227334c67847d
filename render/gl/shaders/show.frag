// The picture for a screen: brightened, in sRGB, row 0 on top, and on request with stripes where its
// confidence is low. What the views' masks leave out is grey.
layout(binding = 15) uniform sampler2D resolved;  // linear light; alpha: confidence, negative for none, -2 for empty
layout(binding = 14) uniform sampler2D masks;     // the same of the masks
uniform vec4 size;                                // of the picture, of the screen
uniform float brighter;
uniform bool hatches_doubt;
uniform bool is_cut_out;
uniform vec4 shares;  // of the masks, up to which and from which on a pixel is outside and inside
out vec4 color;

void main() {
  ivec2 at = ivec2(gl_FragCoord.x, size.y - gl_FragCoord.y);
  vec4 drawn = texelFetch(resolved, at, 0);
  vec3 light = clamp(drawn.rgb * brighter, 0.0, 1.0);
  vec3 srgb = mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308)));
  if (hatches_doubt) {
    vec2 on_screen = gl_FragCoord.xy * size.zw / size.xy;
    float stripe = step(0.5, fract((on_screen.x + on_screen.y) / 16.0));
    float doubt = 1.0 - clamp(drawn.a, 0.0, 1.0);
    srgb = mix(srgb, mix(vec3(0.15), vec3(1.0, 0.55, 0.1), stripe), 0.7 * doubt);
  }
  if (is_cut_out) {
    vec4 mask = texelFetch(masks, at, 0);
    float share = drawn.a == -2.0 || mask.a == -2.0 ? 0.0 : mask.g;
    float inside = clamp((share - shares.x) / (shares.y - shares.x), 0.0, 1.0);
    srgb = mix(vec3(0.25), srgb, inside);
  }
  color = vec4(srgb, 1.0);
}
