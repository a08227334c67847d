// A level of the pyramid of inverse depths: the mean of the known pixels among four of the finer level; 0:
// none.
layout(binding = 15) uniform sampler2D finer;
uniform bool of_depths;  // the finer level holds depths
out vec4 color;

void main() {
  ivec2 size = textureSize(finer, 0);
  ivec2 first = 2 * ivec2(gl_FragCoord.xy);
  float sum = 0.0, known = 0.0;
  for (int n = 0; n < 4; ++n) {
    ivec2 at = first + ivec2(n & 1, n >> 1);
    if (any(greaterThanEqual(at, size))) continue;
    float value = texelFetch(finer, at, 0).r;
    if (value <= 0.0) continue;
    sum += of_depths ? 1.0 / value : value;
    known += 1.0;
  }
  color = vec4(known > 0.0 ? sum / known : 0.0);
}
