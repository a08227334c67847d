// What was drawn, for a screen: brightened, in sRGB, row 0 on top, and on request with stripes where it is in doubt.
layout(binding = 15) uniform sampler2D resolved;  // linear light; alpha: confidence, negative where none
uniform vec4 size;                                // of what was drawn, of the screen
uniform float brighter;
uniform bool hatches_doubt;
out vec4 color;

// Between the four pixels around.
vec4 Drawn(vec2 at) {
  ivec2 last = ivec2(size.xy) - 1;
  ivec2 corner = ivec2(floor(at - 0.5));
  vec2 share = at - 0.5 - vec2(corner);
  ivec2 low = clamp(corner, ivec2(0), last), high = clamp(corner + 1, ivec2(0), last);
  return mix(mix(texelFetch(resolved, low, 0), texelFetch(resolved, ivec2(high.x, low.y), 0), share.x),
             mix(texelFetch(resolved, ivec2(low.x, high.y), 0), texelFetch(resolved, high, 0), share.x), share.y);
}

void main() {
  vec2 at = vec2(gl_FragCoord.x, size.w - gl_FragCoord.y) * size.xy / size.zw;
  vec4 drawn = size.xy == size.zw ? texelFetch(resolved, ivec2(at), 0) : Drawn(at);
  vec3 light = clamp(drawn.rgb * brighter, 0.0, 1.0);
  vec3 srgb = mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, greaterThan(light, vec3(0.0031308)));
  if (hatches_doubt) {
    float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 16.0));
    float doubt = 1.0 - clamp(drawn.a, 0.0, 1.0);
    srgb = mix(srgb, mix(vec3(0.15), vec3(1.0, 0.55, 0.1), stripe), 0.7 * doubt);
  }
  color = vec4(srgb, 1.0);
}
