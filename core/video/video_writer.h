// Writes a video through FFmpeg's libraries that every player and browser shows with the colours of its
// pictures: an MP4 of H.264 (without it MPEG-4 Part 2, which few browsers show) in BT.709's limited range,
// which the stream names, with the index before the pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>

namespace ulf {

class VideoWriter {
 public:
  // Width and height must be even. The rate is in pictures a second. Throws Error if the file cannot be
  // written, or Refusal for a rate or size that the codec does not support.
  VideoWriter(const std::filesystem::path& mp4, const cv::Size& size, double frame_rate);
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;
  ~VideoWriter();  // without Close() the file is no video

  // Adds a picture of this size, CV_8UC3, B, G, R. Throws Error or DiskFullError, as Close() does.
  void Add(const cv::Mat& srgb8);
  void Close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf
