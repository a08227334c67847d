// Selects the intrinsics that a bundle adjustment may change. fx and fy change by one common factor.
#pragma once

namespace ulf::tracking {

struct FreeIntrinsics {
  bool focal = false;
  bool principal_point = false;
  bool k1 = false;
  bool k2 = false;
  int Count() const { return focal + 2 * principal_point + k1 + k2; }
  bool operator==(const FreeIntrinsics&) const = default;
};

}  // namespace ulf::tracking
