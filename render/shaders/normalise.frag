// Light over weight where its own views cover the pixel; alpha: the confidence.
layout(binding = 11) uniform sampler2D drawn;
layout(binding = 14) uniform sampler2D confidence;  // times weight; weight, seen or not
uniform float least_weight;
uniform float whole_weight;  // less is filled up
out vec4 color;

void main() {
  vec4 sum = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  vec2 all = texelFetch(confidence, ivec2(gl_FragCoord.xy), 0).rg;
  if (sum.a <= 0.0 || all.g < least_weight || sum.a < whole_weight * all.g) discard;
  color = vec4(sum.rgb / sum.a, all.r / all.g * min(1.0, sum.a / all.g));
}
