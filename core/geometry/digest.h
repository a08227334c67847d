// Checksums of 64 bits that tell whether values have changed, without security: FNV-1a, and a faster one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf {

class Digest {
 public:
  void Add(std::span<const std::byte> bytes);
  void Add(double number);
  void Add(const Rigid3& pose);
  void Add(const CameraModel& camera);
  void Add(const std::string& text);
  std::uint64_t Value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

// Returns the FNV-1a of the bytes.
std::uint64_t ChecksumOf(std::string_view bytes);

// Returns another checksum, for large arrays: some gigabytes a second. Every change of one 64-bit word
// changes it. `seed` may be the checksum of what comes before.
std::uint64_t FastChecksumOf(std::string_view bytes, std::uint64_t seed = 0);

// Formats a checksum as files contain it: 16 hexadecimal digits.
std::string ChecksumText(std::uint64_t checksum);

}  // namespace ulf
