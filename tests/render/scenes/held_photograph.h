// A photograph whose levels a test has made: in memory, without a file.
#pragma once

#include <memory>
#include <utility>

#include "render/photographs/photograph.h"

namespace ulf::test {

class HeldPhotograph : public render::Photograph {
 public:
  explicit HeldPhotograph(render::ViewPyramid pyramid)
      : Photograph(pyramid.front().size(), pyramid.front().depth() == CV_16F), pyramid_(std::move(pyramid)) {
    for (cv::Mat& level : pyramid_)
      if (!level.isContinuous()) level = level.clone();
  }
  cv::Mat Level(int level) const override { return pyramid_[static_cast<std::size_t>(level)]; }

 private:
  render::ViewPyramid pyramid_;
};

inline std::shared_ptr<const render::Photograph> HoldPhotograph(render::ViewPyramid pyramid) {
  return std::make_shared<HeldPhotograph>(std::move(pyramid));
}

}  // namespace ulf::test
