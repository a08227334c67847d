// Light over weight where something covered the pixel; alpha: the confidence.
layout(binding = 14) uniform sampler2D confidence;
layout(binding = 15) uniform sampler2D drawn;
uniform float least_weight;
out vec4 color;

void main() {
  vec4 sum = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  if (sum.a < least_weight) discard;
  color = vec4(sum.rgb / sum.a, texelFetch(confidence, ivec2(gl_FragCoord.xy), 0).r * min(1.0, sum.a));
}
