// Counts the frames that a camera numbered but that never arrived.
//
// GigE Vision 1.x numbers frames with 16 bits from 1 to 65535 and wraps to 1 (0 is not a frame number); GigE
// Vision 2 and USB3 Vision count with 64 bits. After a loss frames may arrive out of order. A frame whose
// first packet was lost arrives without its number; it fills one gap, which then does not count.
#pragma once

#include <cstdint>
#include <optional>

namespace ulf::acquisition {

class FrameIdCounter {
 public:
  void Arrived(std::uint64_t id);
  // Call it when the camera restarts its numbers.
  void Restarted() { newest_.reset(); }
  void ArrivedWithoutId() { ++without_id_; }
  std::uint64_t Missing() const { return missing_; }
  // Frames that arrived after a later one.
  std::uint64_t OutOfOrder() const { return out_of_order_; }

 private:
  std::optional<std::uint64_t> newest_;
  std::uint64_t without_id_ = 0;  // each fills one gap
  std::uint64_t missing_ = 0;
  std::uint64_t out_of_order_ = 0;
};

}  // namespace ulf::acquisition
