// Streams from a Video4Linux2 node through buffers that the driver fills: its own, mapped into this process
// (mmap), or this process's (userptr). See the kernel's V4L2 API, "Input/Output".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/v4l2/v4l2_node.h"

namespace ulf::acquisition {

enum class V4l2Io { kMmap, kUserPtr };

// A stream runs from construction to destruction. It belongs to one thread; `node` must outlive it.
class V4l2Stream {
 public:
  // `image_bytes`: the largest size of a picture, from the driver. Throws Error when the driver refuses.
  V4l2Stream(const V4l2Node& node, V4l2Io io, std::size_t image_bytes);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  struct Filled {
    v4l2_buffer header;
    std::span<const std::uint8_t> bytes;
  };
  // Returns 0 and a filled buffer, whose bytes stay valid until it goes back by Requeue(); or an errno value,
  // EAGAIN when no buffer is filled yet. Never waits.
  int Dequeue(std::optional<Filled>& filled);
  // Gives a buffer back to the driver. Returns 0, or an errno value.
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

// Converts a webcam's Motion JPEG picture to a JPEG file: the bytes from the start marker (SOI) to the end
// marker (EOI), with the Huffman tables of ITU-T T.81, Annex K inserted if the camera omitted them, as many
// do. Returns none when a marker is missing, because part of the picture did not arrive.
std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes);

}  // namespace ulf::acquisition
