// The operator display without a window over a staged capture: what the tests of the display share.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "coverage/operator/operator_display.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test {

inline const StageOptions kRendered{.rendered = true};
inline const cv::Size kSmall(640, 480);             // the live picture's own size
inline const cv::Rect kMiddle(230, 160, 180, 130);  // the subject, and what no panel hides

inline const cv::Rect kBeside(230, 160, 66, 130);  // its left part, beside the mark of the nearest view
inline const cv::Rect kAbove(230, 90, 180, 70);    // over it, where no view is marked

inline double Likeness(const cv::Mat& a, const cv::Mat& b, const cv::Rect& where = kMiddle) {
  return cv::PSNR(a(where), b(where));
}

// A display whose clock goes on by one picture of so many a second with each Step().
inline DisplayOptions AtFps(double fps, DisplayOptions options = {}) {
  options.clock_s = [fps, pictures = 0]() mutable { return pictures++ / fps; };
  return options;
}

struct Stage {
  explicit Stage(cv::Size size = {1280, 960}, double scale = 1, const StageOptions& options = {},
                 const DisplayOptions& display_options = AtFps(30))
      : capture(options), surface(size, scale), display(surface, feed, requests, display_options) {}
  cv::Mat Show(std::shared_ptr<const CaptureState> state) {
    feed.Publish(std::move(state));
    EXPECT_TRUE(display.Step());
    return surface.Read();
  }
  void Press(Key key, bool shift = false) { surface.Push(KeyPressed{key, shift}); }
  void Type(char32_t character) { surface.Push(Typed{character}); }
  template <typename Request>
  std::vector<Request> Asked() {
    display.Step();
    std::vector<Request> found;
    for (const CaptureRequest& request : requests.Take())
      if (const auto* kind = std::get_if<Request>(&request)) found.push_back(*kind);
    return found;
  }
  Eigen::Vector2d OnScreen(const Eigen::Vector2d& img) const {
    return Placement::Letterboxed({capture.camera().width, capture.camera().height}, surface.Size())
        .ScreenFromImg(img);
  }

  StagedCapture capture;
  OffscreenSurface surface;
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display;
};

}  // namespace ulf::test
