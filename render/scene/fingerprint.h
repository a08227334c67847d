// A short text that differs where what was added to it differs: FNV-1a over what numbers are made of.
#pragma once

#include <fmt/core.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/pyramid_file.h"

namespace ulf::render {

class Fingerprint {
 public:
  void Add(double value) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
    for (int n = 0; n < 8; ++n, bits >>= 8) hash_ = (hash_ ^ (bits & 0xff)) * 0x100000001b3;
  }
  void Add(const Rigid3& pose) {
    for (const double value : pose.rotation.coeffs()) Add(value);
    for (const double value : pose.translation) Add(value);
  }
  void Add(const CameraModel& camera) {
    for (const double value : {1.0 * camera.width, 1.0 * camera.height, camera.fx, camera.fy, camera.cx,
                               camera.cy, 1.0 * static_cast<int>(camera.distortion)})
      Add(value);
    for (const double value : camera.coefficients) Add(value);
  }
  // Of numbers without padding between them.
  template <typename T>
  void AddAll(const std::vector<T>& values) {
    hash_ = Checksum({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)}, hash_);
  }
  std::string Text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace ulf::render
