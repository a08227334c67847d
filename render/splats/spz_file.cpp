#include "render/splats/spz_file.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/error.h"

namespace ulf::render {
namespace {

using Eigen::Vector3f;

constexpr float kColorUnit = 0.15f;  // of the constant harmonic; Niantic's number, as the next two
constexpr float kScaleUnit = 16, kScaleBegin = -10;  // steps of a logarithm, and its least
constexpr float kHarmonicUnit = 128;
// Twelve fractional bits reach the range. More are used where the scene is smaller: readers take their number
// from the header.
constexpr int kFewestBits = 12, kMostBits = 22;

static_assert(std::endian::native == std::endian::little, "SPZ's numbers are little-endian");

char SpzByte(float value) {
  return static_cast<char>(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f))));
}

void RequireInRange(const Gaussians& gaussians, float farthest) {
  if (!(farthest < kSpzRange))
    throw Error(
        "SPZ holds positions up to {:.0f} units from the origin (beyond, programs of others wrap them "
        "round); "
        "these reach {:.0f}; write a .ply or .glb, or scale the light field",
        kSpzRange, farthest);
  // The middle scale is the smaller one along the surface.
  const float least = std::exp(kScaleBegin), most = std::exp(kScaleBegin + 255 / kScaleUnit);
  std::size_t outside = 0;
  for (const Gaussian& gaussian : gaussians) {
    std::array<float, 3> scales{gaussian.scale.x(), gaussian.scale.y(), gaussian.scale.z()};
    std::ranges::sort(scales);
    outside += scales[1] < least || scales[2] > most;
  }
  constexpr std::size_t kOneOf = 100;
  if (outside * kOneOf > gaussians.size())
    throw Error(
        "SPZ holds sizes from {:.2g} to {:.0f} units; {:.0f} % of these Gaussians are smaller or larger; "
        "write "
        "a .ply or .glb, or scale the light field",
        least, most, 100.0 * static_cast<double>(outside) / static_cast<double>(gaussians.size()));
}

// Appends a coordinate in 24 bits, least significant byte first; what would round up to the end of the range
// stays inside.
void AppendPosition(std::string& bytes, float coordinate, int bits) {
  constexpr long kEnd = 1L << 23;
  const auto fixed = static_cast<std::int32_t>(
      std::clamp(std::lround(std::ldexp(static_cast<double>(coordinate), bits)), -kEnd, kEnd - 1));
  for (const int shift : {0, 8, 16}) bytes += static_cast<char>((fixed >> shift) & 0xff);
}

std::string Gzip(const std::string& bytes) {
  constexpr int kGzipWindow = 15 + 16, kMemory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK)
    throw Error("zlib does not begin to compress");
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error("zlib does not compress {} bytes", bytes.size());
  return packed;
}

}  // namespace

std::string SpzBytes(const Gaussians& gaussians) {
  float farthest = 0;
  for (const Gaussian& gaussian : gaussians)
    farthest = std::max(farthest, gaussian.position_in_world.cwiseAbs().maxCoeff());
  RequireInRange(gaussians, farthest);
  int bits = kMostBits;  // 23 without the sign
  while (bits > kFewestBits && std::ldexp(1.0f, 23 - bits) <= farthest + 1) --bits;

  constexpr std::uint32_t kMagic = 0x5053474e, kVersion = 2;
  const auto count = static_cast<std::uint32_t>(gaussians.size());
  std::string bytes;
  for (const std::uint32_t word : {kMagic, kVersion, count})
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
  bytes += {char{1}, static_cast<char>(bits), char{0}, char{0}};  // degree, fractional bits, flags, reserved

  // From x right, y down, z forward to x right, y up, z back.
  for (const Gaussian& gaussian : gaussians) {
    const Vector3f& at = gaussian.position_in_world;
    for (const float coordinate : {at.x(), -at.y(), -at.z()}) AppendPosition(bytes, coordinate, bits);
  }
  for (const Gaussian& gaussian : gaussians) bytes += SpzByte(255 * gaussian.opacity);
  for (const Gaussian& gaussian : gaussians)
    for (int c = 0; c < 3; ++c) bytes += SpzByte(255 * (kColorUnit * gaussian.harmonics[0][c] + 0.5f));
  for (const Gaussian& gaussian : gaussians)
    for (int axis = 0; axis < 3; ++axis)
      bytes +=
          SpzByte(kScaleUnit * (std::log(std::max(gaussian.scale[axis], std::numeric_limits<float>::min())) -
                                kScaleBegin));
  for (const Gaussian& gaussian : gaussians) {
    const auto& q = gaussian.world_from_axes;
    const float sign = q.w() < 0 ? -1 : 1;  // w follows from the others, not negative
    for (const float part : {q.x(), -q.y(), -q.z()}) bytes += SpzByte(127.5f * sign * part + 127.5f);
  }
  for (const Gaussian& gaussian : gaussians) {
    const auto& h = gaussian.harmonics;
    for (const Vector3f& rgb : {Vector3f(-h[1]), Vector3f(-h[2]), h[3]})
      for (int c = 0; c < 3; ++c) bytes += SpzByte(kHarmonicUnit * rgb[c] + kHarmonicUnit);
  }
  return Gzip(bytes);
}

}  // namespace ulf::render
