#include "acquisition/simulator/gige/gige_pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/parallel_for.h"

namespace ulf::acquisition {

GigePictures::GigePictures(const SimulationOptions& simulation, const std::optional<BoardSceneOptions>& board,
                           std::size_t loop)
    : simulation_(simulation), loop_(loop) {
  if (board)
    board_.emplace(*board);
  else
    camera_.emplace(simulation);
}

CameraModel GigePictures::StoredCamera() const {
  return board_ ? board_->options().camera : camera_->StoredCamera();
}

Frame GigePictures::Capture(double hand_s, const GigeSettings& now, double light_s) const {
  if (board_) return CaptureBoard(hand_s, now);
  return camera_->Capture({.open_s = hand_s,
                           .exposure_s = 1e-6 * std::max(10u, now.exposure_us),
                           .gain = std::pow(10, now.gain_tenths_db / 200.0),
                           .format = SensorFormatByCode(now.format).value_or(SensorFormat::kMono8),
                           .id = static_cast<std::uint64_t>(std::llround(hand_s * 1e6)),
                           .light = simulation_.faults.Light(light_s)});
}

Frame GigePictures::CaptureBoard(double hand_s, const GigeSettings& now) const {
  const auto id = static_cast<std::uint64_t>(std::llround(hand_s * 1e6));
  const double exposure_s = 1e-6 * std::max(10u, now.exposure_us);
  const Rigid3 cam_from_board = board_->HeldAtTime(hand_s + 0.5 * exposure_s);
  const cv::Mat light = board_->Light(cam_from_board, id);
  cv::Mat four;
  cv::merge(std::vector<cv::Mat>(4, light), four);
  Frame frame;
  frame.gain = std::pow(10, now.gain_tenths_db / 200.0);
  frame.image =
      Expose(four, {exposure_s, frame.gain, SensorFormatByCode(now.format).value_or(SensorFormat::kMono8),
                    simulation_.seed * 0x9E3779B97F4A7C15u + id, board_->options().noise_levels > 0});
  frame.id = id;
  frame.device_time_s = hand_s + 0.5 * exposure_s;
  frame.exposure_s = exposure_s;
  frame.known_cam_from_world = Rigid3{cam_from_board.rotation, 0.001 * cam_from_board.translation};
  return frame;
}

void GigePictures::RenderLoop() {
  loop_settings_ = {static_cast<std::uint32_t>(std::lround(1e6 * simulation_.exposure_s)),
                    static_cast<std::uint32_t>(std::lround(10 * simulation_.gain_db)),
                    PixelsOf(simulation_.format).code};
  ParallelFor(loop_.size(), [&](std::size_t i) {
    loop_[i] = Capture(static_cast<double>(i) / simulation_.fps, loop_settings_, 0);
  });
}

Frame GigePictures::At(double hand_s, const GigeSettings& now) {
  if (loop_.empty()) return Capture(hand_s, now, hand_s);
  if (!(now == loop_settings_)) {
    loop_.assign(loop_.size(), std::nullopt);
    loop_settings_ = now;
  }
  const auto step = static_cast<std::size_t>(std::llround(hand_s * simulation_.fps));
  const std::size_t last = loop_.size() - 1, place = last == 0 ? 0 : step % (2 * last);
  const std::size_t index = place <= last ? place : 2 * last - place;
  if (!loop_[index]) loop_[index] = Capture(static_cast<double>(index) / simulation_.fps, now, 0);
  return *loop_[index];
}

void PackImage(const cv::Mat& pixels, const cv::Rect& part, const PixelFormat& format, std::uint8_t* out) {
  const cv::Mat from = pixels(part);
  if (format.bits == 8) {
    CV_Assert(from.type() == CV_8UC(format.channels));
    cv::Mat to(part.height, part.width, from.type(), out);
    if (format.red_first)
      cv::cvtColor(from, to, cv::COLOR_BGR2RGB);
    else
      from.copyTo(to);
    return;
  }
  CV_Assert(from.type() == CV_16UC1);
  const int unused_bits = 16 - format.bits;
  std::uint32_t pending = 0;  // LSB packing: bits that do not fill a byte yet; they continue in the next row
  int pending_bits = 0;
  for (int y = 0; y < part.height; ++y) {
    const auto* row = from.ptr<std::uint16_t>(y);
    for (int x = 0; x < part.width; ++x) {
      const std::uint32_t value = row[x] >> unused_bits;
      if (format.packing == PixelPacking::kLsbPacked) {
        pending |= value << pending_bits;
        pending_bits += format.bits;
        for (; pending_bits >= 8; pending_bits -= 8, pending >>= 8)
          *out++ = static_cast<std::uint8_t>(pending);
      } else if (format.packing == PixelPacking::kWholeBytes) {
        *out++ = static_cast<std::uint8_t>(value);
        *out++ = static_cast<std::uint8_t>(value >> 8);
      } else {
        throw Error("the simulated camera does not send {}", format.name);
      }
    }
  }
  if (pending_bits > 0) *out = static_cast<std::uint8_t>(pending);
}

}  // namespace ulf::acquisition
