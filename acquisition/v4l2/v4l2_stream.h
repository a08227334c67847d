// The buffers that a driver fills: its own, mapped into this process (mmap), or the process's (userptr).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/v4l2/v4l2_node.h"

namespace ulf::acquisition {

enum class V4l2Io { kMmap, kUserPtr };

// Streams from construction to destruction.
class V4l2Stream {
 public:
  // `image_bytes`: the size of a picture as the driver reports it. Throws Error.
  V4l2Stream(const V4l2Node& node, V4l2Io io, std::size_t image_bytes);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  struct Filled {
    v4l2_buffer header;
    std::span<const std::uint8_t> bytes;
  };
  // 0 and a filled buffer, to be returned with Requeue(); or the error number, EAGAIN when none is filled
  // yet.
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

// A webcam's Motion JPEG picture as a JPEG file: the bytes from the start marker (SOI) to the end marker
// (EOI), with the Huffman tables of ITU-T T.81, Annex K inserted if the camera omitted them (many do; not
// every program reads such files). None when a marker is missing, because part of the picture did not arrive.
std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes);

}  // namespace ulf::acquisition
