// Writes and reads numbers as little-endian bytes, for binary files of ulf and of COLMAP. A pose is its
// quaternion x y z w, then its translation, as doubles; Count() is a 32-bit count.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/geometry/rigid3.h"

namespace ulf {

static_assert(std::endian::native == std::endian::little, "files hold numbers as they are in memory");

class ByteWriter {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Put(const Eigen::Vector2d& v) { Put(v.x()), Put(v.y()); }
  void Put(const Eigen::Vector3d& v) { Put(v.x()), Put(v.y()), Put(v.z()); }
  void Put(const Rigid3& pose) {
    for (int i = 0; i < 4; ++i) Put(pose.rotation.coeffs()(i));
    Put(pose.translation);
  }
  void Count(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }
  void PutText(std::string_view text) { bytes_.append(text); }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

// Reads bytes, which must outlive it. Reading past the end gives zeros; IsShort() tells so afterwards.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  T Get() {
    T value{};
    if (sizeof value > bytes_.size() - at_) {
      short_ = true;
      at_ = bytes_.size();
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  Eigen::Vector2d Get2() {
    const double x = Get<double>(), y = Get<double>();
    return {x, y};
  }
  Eigen::Vector3d Get3() {
    const double x = Get<double>(), y = Get<double>(), z = Get<double>();
    return {x, y, z};
  }
  Rigid3 GetPose() {
    Rigid3 pose;
    for (int i = 0; i < 4; ++i) pose.rotation.coeffs()(i) = Get<double>();
    pose.translation = Get3();
    return pose;
  }
  // Reads a 32-bit count of things of at least `least` bytes each, which is at least 1. Returns 0, and sets
  // IsShort(), if fewer bytes are left.
  std::size_t Count(std::size_t least) {
    const std::size_t count = Get<std::uint32_t>();
    if (count * least > bytes_.size() - at_) short_ = true;
    return short_ ? 0 : count;
  }
  // Does the same for counts of eight bytes.
  std::size_t Count64(std::size_t least) {
    const auto count = Get<std::uint64_t>();
    if (count > (bytes_.size() - at_) / least) short_ = true;
    return short_ ? 0 : static_cast<std::size_t>(count);
  }
  // Reads text up to a zero byte and skips that byte. Without one, returns "" and sets IsShort().
  std::string GetText() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string_view::npos) {
      short_ = true;
      at_ = bytes_.size();
      return {};
    }
    std::string text(bytes_.substr(at_, end - at_));
    at_ = end + 1;
    return text;
  }
  bool IsShort() const { return short_; }
  bool AtEnd() const { return at_ == bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool short_ = false;
};

}  // namespace ulf
