#include "render/photographs/photograph.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/geometry/digest.h"
#include "core/image/files/exr_file.h"
#include "core/image/image.h"

namespace ulf::render {
namespace {

cv::Size HalfOf(const cv::Size& size) { return {std::max(1, size.width / 2), std::max(1, size.height / 2)}; }

// Makes all levels from `finest`, in linear light, each encoded by `encode`; averages areas from level to
// level.
template <typename Encode>
ViewPyramid Halvings(cv::Mat finest, const Encode& encode) {
  ViewPyramid levels;
  for (cv::Mat level = std::move(finest);;) {
    levels.push_back(encode(level));
    if (level.cols <= 1 && level.rows <= 1) return levels;
    cv::Mat half;
    cv::resize(level, half, HalfOf(level.size()), 0, 0, cv::INTER_AREA);
    level = half;
  }
}

class CoarserPhotograph : public Photograph {
 public:
  CoarserPhotograph(std::shared_ptr<const Photograph> whole, int first)
      : Photograph(whole->LevelSize(first), whole->linear()), whole_(std::move(whole)), first_(first) {}
  cv::Mat Level(int level) const override { return whole_->Level(first_ + level); }
  std::uint64_t ContentDigest() const override {
    return FastChecksumOf({}, whole_->ContentDigest() + static_cast<std::uint64_t>(first_));
  }

 private:
  std::shared_ptr<const Photograph> whole_;
  int first_;
};

}  // namespace

CameraModel Within(const CameraModel& camera, int longest_px, int least_px) {
  const double scale = std::min(1.0, 1.0 * longest_px / std::max(camera.width, camera.height));
  return camera.ScaledTo(std::max(least_px, static_cast<int>(std::lround(scale * camera.width))),
                         std::max(least_px, static_cast<int>(std::lround(scale * camera.height))));
}

std::uint64_t Photograph::ContentDigest() const {
  const cv::Mat pixels = Level(0);
  return FastChecksumOf({pixels.ptr<char>(), pixels.total() * pixels.elemSize()});
}

ViewPyramid MakePyramid(const cv::Mat& srgb8) {
  const cv::Size size = srgb8.size();
  return Halvings(LinearFloat({.pixels = srgb8, .transfer = Transfer::kSrgb}), [&](const cv::Mat& level) {
    return level.size() == size ? srgb8 : Srgb8FromLinear(level);
  });
}

ViewPyramid MakeLinearPyramid(const cv::Mat& linear, cv::Size size, const cv::Mat& clipped) {
  cv::Mat level(linear.size(), CV_32FC4);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const cv::Vec3f& light = linear.at<cv::Vec3f>(y, x);
      const bool finite = std::isfinite(light[0]) && std::isfinite(light[1]) && std::isfinite(light[2]);
      level.at<cv::Vec4f>(y, x) = finite ? cv::Vec4f(light[0], light[1], light[2], 1) : cv::Vec4f(0, 0, 0, 0);
    }
  if (!size.empty() && size != level.size()) cv::resize(level.clone(), level, size, 0, 0, cv::INTER_AREA);
  if (clipped.empty()) return Halvings(std::move(level), HalfFromFloat);
  cv::Mat share(clipped.size(), CV_32FC1, cv::Scalar(1));
  share.setTo(kShareOfClipped, clipped);
  return Halvings(std::move(level), [&share](const cv::Mat& light) {
    if (share.size() != light.size()) cv::resize(share.clone(), share, light.size(), 0, 0, cv::INTER_AREA);
    cv::Mat shares, weighted;
    cv::merge(std::vector<cv::Mat>(4, share), shares);
    cv::multiply(light, shares, weighted);
    return HalfFromFloat(weighted);
  });
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

std::shared_ptr<const Photograph> FromLevel(std::shared_ptr<const Photograph> photograph, int first) {
  if (first == 0) return photograph;
  return std::make_shared<CoarserPhotograph>(std::move(photograph), first);
}

}  // namespace ulf::render
