#include "core/geometry/digest.h"

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

}  // namespace ulf
