// Divides the sums of light and weight.
layout(binding = 11) uniform sampler2D drawn;
layout(binding = 14) uniform sampler2D confidence;  // confidence times weight; weight, whether seen or not
out vec4 color;

void main() {
  vec4 sum = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  vec2 all = texelFetch(confidence, ivec2(gl_FragCoord.xy), 0).rg;
  color = all.g < least_weight ? vec4(0.0, 0.0, 0.0, -2.0) : Resolved(sum.rgb / sum.a, sum.a / all.g, all.r / all.g);
  gl_FragDepth = IsOpen(color) ? 0.0 : 1.0;
}
