#include "render/scene/photograph.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/image/exr_file.h"
#include "core/image/image.h"

namespace ulf::render {
namespace {

cv::Size HalfOf(const cv::Size& size) { return {std::max(1, size.width / 2), std::max(1, size.height / 2)}; }

class HeldPhotograph : public Photograph {
 public:
  explicit HeldPhotograph(ViewPyramid pyramid)
      : Photograph(pyramid.front().size(), pyramid.front().depth() == CV_16F), pyramid_(std::move(pyramid)) {
    for (cv::Mat& level : pyramid_)
      if (!level.isContinuous()) level = level.clone();
  }
  cv::Mat Level(int level) const override { return pyramid_[static_cast<std::size_t>(level)]; }

 private:
  ViewPyramid pyramid_;
};

class CoarserPhotograph : public Photograph {
 public:
  CoarserPhotograph(std::shared_ptr<const Photograph> whole, int first)
      : Photograph(whole->LevelSize(first), whole->linear()), whole_(std::move(whole)), first_(first) {}
  cv::Mat Level(int level) const override { return whole_->Level(first_ + level); }

 private:
  std::shared_ptr<const Photograph> whole_;
  int first_;
};

}  // namespace

ViewPyramid MakePyramid(const cv::Mat& srgb8) {
  ViewPyramid levels{srgb8};
  cv::Mat linear = LinearFloat({.pixels = srgb8, .transfer = Transfer::kSrgb});
  while (linear.cols > 1 || linear.rows > 1) {
    cv::Mat half;
    cv::resize(linear, half, HalfOf(linear.size()), 0, 0, cv::INTER_AREA);
    levels.push_back(Srgb8FromLinear(half));
    linear = half;
  }
  return levels;
}

ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size) {
  cv::Mat level(linear.size(), CV_32FC4);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const cv::Vec3f& light = linear.at<cv::Vec3f>(y, x);
      const bool finite = std::isfinite(light[0]) && std::isfinite(light[1]) && std::isfinite(light[2]);
      level.at<cv::Vec4f>(y, x) = finite ? cv::Vec4f(light[0], light[1], light[2], 1) : cv::Vec4f(0, 0, 0, 0);
    }
  if (!size.empty() && size != level.size()) cv::resize(level.clone(), level, size, 0, 0, cv::INTER_AREA);
  ViewPyramid levels{HalfFromFloat(level)};
  while (level.cols > 1 || level.rows > 1) {
    cv::Mat half;
    cv::resize(level, half, HalfOf(level.size()), 0, 0, cv::INTER_AREA);
    levels.push_back(HalfFromFloat(half));
    level = half;
  }
  return levels;
}

int Photograph::LevelCount() const {
  int count = 1;
  for (cv::Size size = size_; size.width > 1 || size.height > 1; size = HalfOf(size)) ++count;
  return count;
}

cv::Size Photograph::LevelSize(int level) const {
  cv::Size size = size_;
  for (int n = 0; n < level; ++n) size = HalfOf(size);
  return size;
}

std::size_t Photograph::LevelBytes(int level) const {
  return static_cast<std::size_t>(LevelSize(level).area()) * static_cast<std::size_t>(CV_ELEM_SIZE(type()));
}

std::shared_ptr<const Photograph> HoldPhotograph(ViewPyramid pyramid) {
  return std::make_shared<HeldPhotograph>(std::move(pyramid));
}

std::shared_ptr<const Photograph> FromLevel(std::shared_ptr<const Photograph> photograph, int first) {
  if (first == 0) return photograph;
  return std::make_shared<CoarserPhotograph>(std::move(photograph), first);
}

}  // namespace ulf::render
