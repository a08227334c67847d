// The matching costs of four planes of the sweep at a pixel, computed as in render/stereo/plane_sweep.cpp.
// The program defines RADIUS, NEIGHBOURS, KEEP and COST_UNIT. Computed and not drawn: some GPUs draw with a
// few of their cores only.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2DArray own;  // one layer
layout(binding = 1) uniform sampler2DArray others;
// Of each neighbour: three rows of the map at infinity, each with its factor of the plane's inverse depth;
// the size.
layout(binding = 2) uniform samplerBuffer carriers;
layout(std430, binding = 2) readonly buffer InverseDepths { float inverse_depths[]; };  // of the planes
layout(std430, binding = 3) writeonly buffer Costs { uint costs[]; };  // of the band's pixels, four planes in one
uniform int first_row, end_row;                                        // of the band
uniform int planes, quads;  // quads: of planes, with padding
uniform float noise_floor;
uniform float truncation;

const int kSide = 2 * RADIUS + 1;
const float kArea = float(kSide * kSide);
const float kUnseen = 4.0;

// The four texels are gathered at the corner where they meet, so that rounding cannot choose others.
float Neighbour(int layer, vec2 pixel, vec2 size) {
  vec2 at = clamp(pixel, vec2(0.0), size - 1.001);
  vec2 corner = floor(at);
  vec2 share = at - corner;
  vec4 around = textureGather(others, vec3((corner + 1.0) / vec2(textureSize(others, 0).xy), float(layer)));
  vec2 rows = mix(around.wx, around.zy, share.x);  // the upper two, the lower two
  return mix(rows.x, rows.y, share.y);
}

void main() {
  ivec2 here = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
  ivec2 last = textureSize(own, 0).xy - 1;
  if (here.x > last.x || here.y >= end_row) return;
  int first_plane = 4 * int(gl_GlobalInvocationID.z);
  uvec4 bytes = uvec4(255);  // padding
  float window[kSide * kSide];
  float own_sum = 0.0, own_square = 0.0;
  for (int dy = 0; dy < kSide; ++dy)
    for (int dx = 0; dx < kSide; ++dx) {
      float value = texelFetch(own, ivec3(clamp(here + ivec2(dx, dy) - RADIUS, ivec2(0), last), 0), 0).r;
      window[dy * kSide + dx] = value;
      own_sum += value;
      own_square += value * value;
    }
  float own_spread = max(0.0, own_square - own_sum * own_sum / kArea) + noise_floor;

  for (int plane = 0; plane < min(4, planes - first_plane); ++plane) {
    float inverse_depth = inverse_depths[first_plane + plane];
    float best[KEEP];
    for (int k = 0; k < KEEP; ++k) best[k] = kUnseen;
    for (int n = 0; n < NEIGHBOURS; ++n) {
      mat3x4 carrier = mat3x4(texelFetch(carriers, 4 * n), texelFetch(carriers, 4 * n + 1), texelFetch(carriers, 4 * n + 2));
      vec2 size = texelFetch(carriers, 4 * n + 3).xy;
      vec3 moved = inverse_depth * vec3(carrier[0].w, carrier[1].w, carrier[2].w);
      float value = 0.0, square = 0.0, product = 0.0;
      for (int dy = 0; dy < kSide; ++dy)
        for (int dx = 0; dx < kSide; ++dx) {
          // Above and below the image the window repeats its edge; left and right of it the window continues.
          vec3 pixel = vec3(float(here.x + dx - RADIUS) + 0.5, float(clamp(here.y + dy - RADIUS, 0, last.y)) + 0.5, 1.0);
          vec3 to = vec3(dot(carrier[0].xyz, pixel), dot(carrier[1].xyz, pixel), dot(carrier[2].xyz, pixel)) + moved;
          float c = Neighbour(n, to.xy / max(to.z, 1e-6) - 0.5, size);
          value += c;
          square += c * c;
          product += c * window[dy * kSide + dx];
        }
      float covariance = product - value * own_sum / kArea;
      float spread = max(0.0, square - value * value / kArea) + noise_floor;
      vec3 middle = vec3(vec2(here) + 0.5, 1.0);
      vec3 to = vec3(dot(carrier[0].xyz, middle), dot(carrier[1].xyz, middle), dot(carrier[2].xyz, middle)) + moved;
      bool inside = to.z > 1e-6 && all(greaterThan(to.xy, vec2(0.0))) && all(lessThan(to.xy, size * to.z));
      float rest = inside ? 1.0 - covariance / sqrt(spread * own_spread) : kUnseen;
      for (int k = 0; k < KEEP; ++k) {
        float kept = min(best[k], rest);
        rest = max(best[k], rest);
        best[k] = kept;
      }
    }
    float sum = 0.0, seen = 0.0;
    for (int k = 0; k < KEEP; ++k)
      if (best[k] < kUnseen) {
        sum += min(best[k], truncation);
        seen += 1.0;
      }
    bytes[plane] = uint((seen > 0.0 ? sum / seen : truncation) * COST_UNIT + 0.5);
  }
  uint at = uint(((here.y - first_row) * (last.x + 1) + here.x) * quads) + gl_GlobalInvocationID.z;
  costs[at] = bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24;
}
