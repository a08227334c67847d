// Fills the unknown pixels of a level of the pyramid from the coarser one.
layout(binding = 14) uniform sampler2D coarser;
layout(binding = 15) uniform sampler2D own;
uniform bool of_depths;  // this level holds depths
out vec4 color;

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  if (texelFetch(own, here, 0).r > 0.0) discard;
  ivec2 last = textureSize(coarser, 0) - 1;
  ivec2 at = here / 2;
  ivec2 beside = clamp(at + 2 * (here & 1) - 1, ivec2(0), last);
  float value = (9.0 * texelFetch(coarser, at, 0).r + 3.0 * texelFetch(coarser, ivec2(beside.x, at.y), 0).r +
                 3.0 * texelFetch(coarser, ivec2(at.x, beside.y), 0).r + texelFetch(coarser, beside, 0).r) / 16.0;
  color = vec4(of_depths && value > 0.0 ? 1.0 / value : value);
}
