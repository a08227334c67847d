#include "acquisition/v4l2/v4l2_stream.h"

#include <sys/mman.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#include "core/base/error.h"
#include "core/image/files/jpeg_codec.h"

namespace ulf::acquisition {
namespace {

constexpr std::uint32_t kBuffers = 4;  // one being filled, one being read, two in reserve; guessed
constexpr std::size_t kPage = 4096;

constexpr std::uint8_t kStart = 0xD8, kEndOfPicture = 0xD9, kScan = 0xDA, kHuffmanTables = 0xC4;

struct Segment {
  std::uint8_t marker = 0;
  std::size_t begin = 0, end = 0;  // with its marker
};

// Returns the segments of the header, up to that of the first scan.
std::vector<Segment> Segments(std::span<const std::uint8_t> jpeg) {
  std::vector<Segment> segments;
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF) {
    const std::size_t length = static_cast<std::size_t>(jpeg[at + 2] << 8 | jpeg[at + 3]);
    segments.push_back({jpeg[at + 1], at, at + 2 + length});
    if (jpeg[at + 1] == kScan) break;
    at += 2 + length;
  }
  return segments;
}

// Returns the standard's tables (ITU-T T.81, Annex K.3), taken from an encoder that does not optimise.
const std::string& StandardTables() {
  static const std::string tables = [] {
    const std::string encoded = JpegBytes(cv::Mat(16, 16, CV_8UC3, cv::Scalar(1, 2, 3)));
    const std::vector<std::uint8_t> jpeg(encoded.begin(), encoded.end());
    std::string found;
    for (const Segment& segment : Segments(jpeg))
      if (segment.marker == kHuffmanTables)
        found.append(jpeg.begin() + static_cast<std::ptrdiff_t>(segment.begin),
                     jpeg.begin() + static_cast<std::ptrdiff_t>(segment.end));
    return found;
  }();
  return tables;
}

}  // namespace

V4l2Stream::V4l2Stream(const V4l2Node& node, V4l2Io io, std::size_t image_bytes)
    : node_(node), memory_(io == V4l2Io::kMmap ? V4L2_MEMORY_MMAP : V4L2_MEMORY_USERPTR) {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = memory_;
  const int error = node.Call(VIDIOC_REQBUFS, &request);
  if (error == EINVAL && io == V4l2Io::kUserPtr)
    throw Error("{}: its driver does not support io=userptr; use io=mmap", node.Path());
  if (error != 0) node.Throw("request for buffers", error);
  if (request.count < 2)
    throw Error("{}: its driver grants {} buffers, too few to stream; free memory and try again", node.Path(),
                request.count);
  try {
    for (std::uint32_t i = 0; i < request.count; ++i) {
      Buffer buffer;
      v4l2_buffer header = Header(i);
      if (io == V4l2Io::kMmap) {
        node.CallOrThrow("buffer", VIDIOC_QUERYBUF, &header);
        void* mapped =
            mmap(nullptr, header.length, PROT_READ | PROT_WRITE, MAP_SHARED, node.Number(), header.m.offset);
        if (mapped == MAP_FAILED)
          throw Error("{}: its buffers cannot be mapped: {}; try io=userptr", node.Path(),
                      std::strerror(errno));
        buffer = {static_cast<std::uint8_t*>(mapped), header.length};
      } else {
        buffer.size = (image_bytes + kPage - 1) / kPage * kPage;
        buffer.data = static_cast<std::uint8_t*>(std::aligned_alloc(kPage, buffer.size));
        if (!buffer.data) throw std::bad_alloc();
      }
      buffers_.push_back(buffer);
      header = Header(i);
      node.CallOrThrow("queueing of a buffer", VIDIOC_QBUF, &header);
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    node.CallOrThrow("start of the stream", VIDIOC_STREAMON, &type);
  } catch (...) {
    Release();
    throw;
  }
}

V4l2Stream::~V4l2Stream() { Release(); }

void V4l2Stream::Release() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  node_.Call(VIDIOC_STREAMOFF, &type);
  for (const Buffer& buffer : buffers_) {
    if (memory_ == V4L2_MEMORY_MMAP)
      munmap(buffer.data, buffer.size);
    else
      std::free(buffer.data);
  }
  buffers_.clear();
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = memory_;
  node_.Call(VIDIOC_REQBUFS, &none);
}

v4l2_buffer V4l2Stream::Header(std::uint32_t index) const {
  v4l2_buffer header{};
  header.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  header.memory = memory_;
  header.index = index;
  if (memory_ == V4L2_MEMORY_USERPTR && index < buffers_.size()) {
    header.m.userptr = reinterpret_cast<unsigned long>(buffers_[index].data);
    header.length = static_cast<std::uint32_t>(buffers_[index].size);
  }
  return header;
}

int V4l2Stream::Dequeue(std::optional<Filled>& filled) {
  filled.reset();
  v4l2_buffer header{};
  header.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  header.memory = memory_;
  if (const int error = node_.Call(VIDIOC_DQBUF, &header); error != 0) return error;
  if (header.index >= buffers_.size()) return EIO;
  const Buffer& buffer = buffers_[header.index];
  filled = Filled{header, {buffer.data, std::min<std::size_t>(header.bytesused, buffer.size)}};
  return 0;
}

int V4l2Stream::Requeue(const Filled& filled) {
  v4l2_buffer header = Header(filled.header.index);
  return node_.Call(VIDIOC_QBUF, &header);
}

std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != kStart) return std::nullopt;
  // Padding may follow the end marker, which cannot occur inside the scan.
  std::size_t end = bytes.size();
  while (end >= 4 && !(bytes[end - 2] == 0xFF && bytes[end - 1] == kEndOfPicture)) --end;
  if (end < 4) return std::nullopt;
  std::string jpeg(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end));
  std::size_t scan = 0;
  for (const Segment& segment : Segments(bytes.first(end))) {
    if (segment.marker == kHuffmanTables) return jpeg;
    if (segment.marker == kScan) scan = segment.begin;
  }
  if (scan > 0) jpeg.insert(scan, StandardTables());
  return jpeg;
}

}  // namespace ulf::acquisition
