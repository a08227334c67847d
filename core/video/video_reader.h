// Reads a video by FFmpeg's libraries. What the stream says of its numbers counts: matrix, range, primaries
// and transfer curve; how the pictures are turned; how wide a pixel is. What it does not say is taken as
// players take it, and said. ITU-R BT.601, BT.709 and BT.2020 (matrices and primaries), BT.2100 (PQ and HLG),
// BT.2408 (reference white).
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace ulf {

struct VideoFacts {
  int width = 0, height = 0;          // of the pictures, turned as the file asks
  double frame_rate = 0;              // pictures a second on average; 0: the file does not say
  double frames = 0;                  // how many the file announces, often a guess; 0: it does not say
  double pixel_aspect = 1;            // width of a pixel over its height, turned
  std::vector<std::string> notes;     // what was decided, one sentence without its dot each
  std::vector<std::string> warnings;  // what may not be as its maker meant it
};

struct VideoPicture {
  Image image;  // B, G, R: 8 bits in sRGB, or float in linear light where the video has a high dynamic range
  double time_s = 0;  // by the container, from the first picture on; never the same twice
};

class VideoReader {
 public:
  // Opens local files only, whatever they refer to. Throws Error where it is no video, or where its pictures
  // cannot be understood.
  explicit VideoReader(const std::filesystem::path& file);
  VideoReader(const VideoReader&) = delete;
  VideoReader& operator=(const VideoReader&) = delete;
  ~VideoReader();

  const VideoFacts& Facts() const;
  // None at the end.
  std::optional<VideoPicture> Next();
  // What was wrong so far, in words: a part that is missing or damaged, pictures of another size that were
  // left out. Empty: nothing.
  std::string Problem() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
