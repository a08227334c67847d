#include "core/geometry/digest.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>

namespace ulf {

void Digest::Add(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) {
    value_ ^= static_cast<std::uint64_t>(byte);
    value_ *= 1099511628211ull;
  }
}

void Digest::Add(double number) { Add(std::as_bytes(std::span(&number, 1))); }

void Digest::Add(const Rigid3& pose) {
  for (int i = 0; i < 4; ++i) Add(pose.rotation.coeffs()(i));
  for (int i = 0; i < 3; ++i) Add(pose.translation(i));
}

void Digest::Add(const CameraModel& camera) {
  for (const double number : {static_cast<double>(camera.width), static_cast<double>(camera.height),
                              camera.fx, camera.fy, camera.cx, camera.cy})
    Add(number);
  Add(static_cast<double>(camera.distortion));
  for (const double coefficient : camera.coefficients) Add(coefficient);
}

void Digest::Add(const std::string& text) {
  Add(static_cast<double>(text.size()));
  Add(std::as_bytes(std::span(text)));
}

std::uint64_t ChecksumOf(std::string_view bytes) {
  Digest digest;
  digest.Add(std::as_bytes(std::span(bytes)));
  return digest.Value();
}

std::string ChecksumText(std::uint64_t checksum) { return fmt::format("{:016x}", checksum); }

// The processor computes four sums in parallel. Every step is invertible, so that no change of one word is
// lost.
std::uint64_t FastChecksumOf(std::string_view bytes, std::uint64_t seed) {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15;
  const auto mix = [](std::uint64_t sum, std::uint64_t word) { return std::rotl((sum ^ word) * kOdd, 29); };
  std::array<std::uint64_t, 4> sums{seed + 1, seed + 2, seed + 3, seed + 4};
  std::size_t at = 0;
  for (; at + 32 <= bytes.size(); at += 32) {
    std::array<std::uint64_t, 4> words;
    std::memcpy(words.data(), bytes.data() + at, 32);
    for (std::size_t n = 0; n < 4; ++n) sums[n] = mix(sums[n], words[n]);
  }
  std::array<std::uint64_t, 4> rest{};
  if (at < bytes.size()) std::memcpy(rest.data(), bytes.data() + at, bytes.size() - at);
  std::uint64_t all = bytes.size();
  for (std::size_t n = 0; n < 4; ++n) all = mix(mix(all, sums[n]), rest[n]);
  return all;
}

}  // namespace ulf
