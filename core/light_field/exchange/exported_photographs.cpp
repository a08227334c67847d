#include "core/light_field/exchange/exported_photographs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/view_images.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// `colors` are those of an EXR.
std::string Encoded(const std::string& ending, const cv::Mat& pixels, const ExrColors& colors = {}) {
  if (ending == ".exr") {
    std::vector<ExrChannel> channels;
    const std::string names = pixels.channels() == 1 ? "Y" : "BGR";
    for (int c = 0; c < static_cast<int>(names.size()); ++c)
      channels.push_back({names.substr(static_cast<std::size_t>(c), 1), pixels, c});
    return ExrBytes(channels, ExrCompression::kZip, colors);
  }
  return PngBytes(pixels);
}

// Such pixels have been converted to sRGB's primaries.
bool IsExrWithColors(const fs::path& original) {
  return LowercaseEnding(original.string()) == ".exr" && fs::exists(original) && ExrColorsOf(original);
}

cv::Mat WithAlpha(const cv::Mat& bgr, const cv::Mat& alpha) {
  cv::Mat all;
  cv::merge(std::array{bgr, alpha}, all);
  return all;
}

// Unknown depths are NaN in the EXR, which no reader takes for a depth unnoticed, and 0 in the PNG, which is
// what its readers take for unknown.
std::string DepthExr(const PhotographDepth& depth) {
  cv::Mat z = depth.depth.clone();
  z.setTo(std::numeric_limits<float>::quiet_NaN(), depth.depth <= 0);
  std::vector<ExrChannel> channels{{"Z", z, 0}};
  if (!depth.confidence.empty()) channels.push_back({"confidence", depth.confidence, 0});
  return ExrBytes(channels, ExrCompression::kZip);
}

cv::Mat DepthPixels(const cv::Mat& depth, double unit, DepthSummary& summary) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  cv::Mat pixels = cv::Mat::zeros(depth.size(), CV_16UC1);
  summary = {.maps = 1, .pixels = depth.total()};
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const double steps = std::round(depth.at<float>(y, x) / unit);
      if (!(depth.at<float>(y, x) > 0)) continue;
      ++summary.known;
      if (steps > kMost)
        ++summary.beyond;
      else  // a known depth must not become 0
        pixels.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::max(1.0, steps));
    }
  return pixels;
}

}  // namespace

std::string LowercaseEnding(const std::string& path) {
  return Lowercase(fs::path(path).extension().string());
}

std::string MaskPathOf(MaskPlace place, const std::string& name) {
  switch (place) {
    case MaskPlace::kBeside:
      return "masks/" + name + ".png";
    case MaskPlace::kSuffix:
      return "masks/" + fs::path(name).stem().string() + "_mask.png";
    case MaskPlace::kDynamic:
      return "images/dynamic_mask_" + fs::path(name).stem().string() + ".png";
    case MaskPlace::kLayer:
      return "images/" + name + ".mask.png";
    case MaskPlace::kAlpha:
      break;
  }
  return {};
}

std::string DepthPathOf(const std::string& image_path) {
  return "depths/" + fs::path(image_path).stem().string();
}

ExportedPhotographs::ExportedPhotographs(const LightField& from, const LightField& to,
                                         const std::vector<Undistortion>& cameras, MaskPlace masks,
                                         const ExportOptions& options, const fs::path& folder)
    : from_(from), to_(to), cameras_(cameras), masks_(masks), options_(options), folder_(folder) {
  for (const Undistortion& undistortion : cameras)
    maps_.push_back(undistortion.is_identity ? UndistortionMap{} : MapOf(undistortion));
}

bool ExportedPhotographs::StaysAsItIs(const View& view) const {
  return cameras_.empty() || cameras_[static_cast<std::size_t>(view.camera)].is_identity;
}

const UndistortionMap& ExportedPhotographs::MapFor(const View& view) const {
  return maps_[static_cast<std::size_t>(view.camera)];
}

// If one view has a mask, every view gets one, because nerfstudio takes all or none.
cv::Mat ExportedPhotographs::MaskFor(const View& view) const {
  const CameraModel& camera = from_.CameraOf(view);
  cv::Mat mask = ReadViewMask(from_, view);
  if (mask.empty()) mask = cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(255));
  return StaysAsItIs(view) ? mask : UndistortedMask(MapFor(view), mask);
}

ExportedFiles ExportedPhotographs::Of(std::size_t index) const {
  const View &view = from_.views[index], &exported = to_.views[index];
  ExportedFiles files = PhotographOf(view, exported);
  files.has_mask = !exported.mask_path.empty();
  cv::Mat mask;
  if (files.has_mask || (options_.depths && HasMask(from_, view))) mask = MaskFor(view);
  if (files.has_mask)
    files.contents.emplace_back(folder_ / exported.mask_path,
                                Encoded(".png", masks_ == MaskPlace::kDynamic ? cv::Mat(mask == 0) : mask));
  if (options_.depths) AddDepth(view, exported, mask, files);
  return files;
}

ExportedFiles ExportedPhotographs::PhotographOf(const View& view, const View& exported) const {
  const bool stays = StaysAsItIs(view);
  const fs::path original = from_.root / view.image_path;
  const bool is_raw = IsRawFile(original);  // no other program reads it
  ExportedFiles files;
  files.copied = stays && !is_raw && masks_ != MaskPlace::kAlpha && fs::is_regular_file(original);
  Image image;
  if (files.copied) {
    files.stored = ReadPicture(original.string());
    files.stored.alpha.release();
  }
  LogWarnings(original.string(), files.stored);
  // The light field's own reader reports a wrong size.
  const CameraModel& camera = from_.CameraOf(view);
  if (!files.copied || files.stored.pixels.size() != cv::Size(camera.width, camera.height))
    image = ReadRecordedImage(from_, view);
  files.stored.pixels.release();
  if (masks_ == MaskPlace::kAlpha) {
    cv::Mat pixels = Srgb8(image);
    if (pixels.channels() == 1) cv::cvtColor(pixels, pixels, cv::COLOR_GRAY2BGR);
    if (!stays) pixels = Undistorted(MapFor(view), pixels);
    files.contents.emplace_back(folder_ / exported.image_path, PngBytes(WithAlpha(pixels, MaskFor(view))));
    return files;
  }
  if (is_raw) image.pixels = Srgb8(image);
  files.contents.emplace_back(folder_ / exported.image_path,
                              files.copied
                                  ? ReadWholeFile(original)
                                  : Encoded(LowercaseEnding(exported.image_path),
                                            stays ? image.pixels : Undistorted(MapFor(view), image.pixels),
                                            IsExrWithColors(original) ? ExrColors(kRec709) : std::nullopt));
  return files;
}

// What a mask excludes has no depth of its own.
void ExportedPhotographs::AddDepth(const View& view, const View& exported, const cv::Mat& mask,
                                   ExportedFiles& files) const {
  PhotographDepth depth = options_.depths->of(view, to_.CameraOf(exported));
  if (!mask.empty()) {
    depth.depth.setTo(0, mask == 0);
    if (!depth.confidence.empty()) depth.confidence.setTo(0, mask == 0);
  }
  const fs::path path = folder_ / DepthPathOf(exported.image_path);
  files.contents.emplace_back(path.string() + ".exr", DepthExr(depth));
  files.contents.emplace_back(path.string() + ".png",
                              PngBytes(DepthPixels(depth.depth, options_.depths->png_unit, files.depths)));
}

}  // namespace ulf
