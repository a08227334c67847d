// Writes a video by FFmpeg's libraries that every player and browser shows with the colours of its pictures:
// H.264 (MPEG-4 Part 2 where the libraries have no H.264), BT.709, limited range, both named in the stream;
// the index stands first.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf {

class VideoWriter {
 public:
  // `size`: even numbers. Throws Error, Refusal for a rate that the codec cannot have.
  VideoWriter(const std::filesystem::path& mp4, const cv::Size& size, double frame_rate);
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;
  ~VideoWriter();  // without Close(): what was written is no video

  void Add(const cv::Mat& srgb8);  // of this size. Throws Error, DiskFullError
  void Close();                    // the same

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
