// Reads a video through FFmpeg's libraries, by the stream's matrix, range, primaries, transfer curve,
// orientation and pixel aspect; missing ones get players' defaults, which the notes say. The standards are
// ITU-R BT.601, BT.709 and BT.2020 (matrices and primaries), BT.2100 (PQ and HLG), BT.2408 (reference white).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace ulf {

struct VideoFacts {
  int width = 0, height = 0;          // size of the pictures in px, rotated as the file demands
  double frame_rate = 0;              // pictures a second on average; 0: unknown
  double frames = 0;                  // the number that the file announces, often a guess; 0: unknown
  double pixel_aspect = 1;            // width of a pixel over its height, after rotation
  std::vector<std::string> notes;     // decisions, as sentences without full stops
  std::vector<std::string> warnings;  // interpretations that may differ from the maker's intention
};

struct VideoPicture {
  Image image;        // B, G, R: 8 bits in sRGB, or float linear light for high dynamic range
  double time_s = 0;  // by the container, since the first picture; strictly increasing
};

class VideoReader {
 public:
  // Decodes the first picture. Opens local files only, whatever the file refers to. Throws Error if it is no
  // video, if its pictures cannot be interpreted, or if FFmpeg is not installed.
  explicit VideoReader(const std::filesystem::path& file);
  VideoReader(const VideoReader&) = delete;
  VideoReader& operator=(const VideoReader&) = delete;
  ~VideoReader();

  const VideoFacts& Facts() const;
  // Returns the next picture; none at the end. Throws Error if its pixels cannot be converted.
  std::optional<VideoPicture> Next();
  // Describes the faults so far: parts that are missing or damaged, pictures left out; empty if none.
  std::string Problem() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
