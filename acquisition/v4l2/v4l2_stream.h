// Buffers that a driver fills: its own, mapped into this process, or ours, whose addresses it is given.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acquisition/v4l2/v4l2_node.h"

namespace ulf::acquisition {

enum class V4l2Io { kMmap, kUserPtr };

// Streams from its making to its end.
class V4l2Stream {
 public:
  // `image_bytes` is what the driver said a picture takes. Throws Error.
  V4l2Stream(const V4l2Node& node, V4l2Io io, std::size_t image_bytes);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  struct Filled {
    v4l2_buffer header;
    std::span<const std::uint8_t> bytes;
  };
  // A filled buffer, or the error number: EAGAIN when there is none yet. To be given back with Requeue.
  int Dequeue(std::optional<Filled>& filled);
  // 0, or the error number.
  int Requeue(const Filled& filled);

 private:
  struct Buffer {
    std::uint8_t* data = nullptr;
    std::size_t size = 0;
  };
  v4l2_buffer Header(std::uint32_t index) const;
  void Release();

  const V4l2Node& node_;
  const std::uint32_t memory_;
  std::vector<Buffer> buffers_;
};

}  // namespace ulf::acquisition
