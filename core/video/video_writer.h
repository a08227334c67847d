// Writes a video by FFmpeg's libraries that every player and browser shows with the colours of its pictures:
// H.264 (MPEG-4 Part 2 if the libraries have no H.264), BT.709, limited range, both named in the stream, with
// the index first.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf {

class VideoWriter {
 public:
  // `size` must be even. Throws Error, or Refusal for a rate that the codec does not support.
  VideoWriter(const std::filesystem::path& mp4, const cv::Size& size, double frame_rate);
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;
  ~VideoWriter();  // without Close() the file is no video

  void Add(const cv::Mat& srgb8);  // throws Error, DiskFullError
  void Close();                    // throws the same

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
