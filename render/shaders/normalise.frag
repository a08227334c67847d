// Light over weight where something covered the pixel; alpha: the confidence.
layout(binding = 14) uniform sampler2D confidence;  // times weight; weight, seen or not
layout(binding = 15) uniform sampler2D drawn;
uniform float least_weight;
out vec4 color;

void main() {
  vec4 sum = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  vec2 all = texelFetch(confidence, ivec2(gl_FragCoord.xy), 0).rg;
  if (sum.a <= 0.0 || all.g < least_weight || sum.a < least_weight * all.g) discard;
  color = vec4(sum.rgb / sum.a, all.r / all.g * min(1.0, sum.a / all.g));
}
