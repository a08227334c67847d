#include "core/light_field/exchange/exported_photographs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/exif_insertion.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/jpeg_codec.h"
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

cv::Mat Resampled(const UndistortionMap& map, const cv::Mat& pixels) {
  return map.x.empty() ? pixels : Undistorted(map, pixels);
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

bool StaysAsItIs(const View& view, const std::vector<Undistortion>& cameras, const ExportOptions& options) {
  if (options.resampling && options.resampling->views.contains(view.id)) return false;
  return cameras.empty() || cameras[static_cast<std::size_t>(view.camera)].is_identity;
}

bool IsCopied(const LightField& light_field, const View& view, bool stays, const ExportOptions& options) {
  const fs::path original = light_field.root / view.image_path;
  if (!stays || options.even_light || IsRawFile(original) || !fs::is_regular_file(original)) return false;
  const std::string ending = LowercaseEnding(view.image_path);
  return options.format == PhotographFormat::kAsTheyAre ||
         (options.format == PhotographFormat::kJpeg && (ending == ".jpg" || ending == ".jpeg"));
}

std::string EndingInExport(const LightField& light_field, const View& view, bool stays,
                           const ExportOptions& options) {
  if (IsCopied(light_field, view, stays, options)) return fs::path(view.image_path).extension().string();
  const bool is_exr = options.format == PhotographFormat::kAsTheyAre && !options.even_light &&
                      LowercaseEnding(view.image_path) == ".exr";
  if (is_exr) return fs::path(view.image_path).extension().string();
  return options.format == PhotographFormat::kExr    ? ".exr"
         : options.format == PhotographFormat::kJpeg ? ".jpg"
                                                     : ".png";
}

std::string DepthPathOf(const std::string& image_path) {
  return "depths/" + fs::path(image_path).stem().string();
}

ExportedPhotographs::ExportedPhotographs(const LightField& from, const LightField& to,
                                         const std::vector<Undistortion>& cameras, MaskPlace masks,
                                         const ExportOptions& options, const fs::path& folder)
    : from_(from),
      to_(to),
      cameras_(cameras),
      masks_(masks),
      options_(options),
      folder_(folder),
      knows_gains_(std::ranges::any_of(from.views, [](const View& view) { return view.gain != 1; })) {
  for (const Undistortion& undistortion : cameras)
    maps_.push_back(undistortion.is_identity ? UndistortionMap{} : MapOf(undistortion));
}

UndistortionMap ExportedPhotographs::MapFor(const View& view, const View& exported) const {
  if (options_.resampling && options_.resampling->views.contains(view.id))
    return options_.resampling->map_of(view, to_.CameraOf(exported));
  return StaysAsItIs(view, cameras_, options_) ? UndistortionMap{}
                                               : maps_[static_cast<std::size_t>(view.camera)];
}

// If one view has a mask, every view gets one, because nerfstudio takes all or none. What lies outside the
// photograph is masked, too.
cv::Mat ExportedPhotographs::MaskFor(const Task& task) const {
  const CameraModel& camera = from_.CameraOf(task.view);
  cv::Mat mask = ReadViewMask(from_, task.view);
  if (mask.empty()) mask = cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(255));
  if (task.map.x.empty()) return mask;
  constexpr double kHalf = 0.5;  // the first pixel's centre is 0
  const cv::Mat inside = (task.map.x >= -kHalf) & (task.map.x <= camera.width - kHalf) &
                         (task.map.y >= -kHalf) & (task.map.y <= camera.height - kHalf);
  return UndistortedMask(task.map, mask) & inside;
}

ExportedFiles ExportedPhotographs::Of(std::size_t index) const {
  const View &view = from_.views[index], &exported = to_.views[index];
  const Task task{view, exported, MapFor(view, exported)};
  ExportedFiles files = PhotographOf(task);
  files.has_mask = !exported.mask_path.empty();
  cv::Mat mask;
  if (files.has_mask || (options_.depths && HasMask(from_, view))) mask = MaskFor(task);
  if (files.has_mask)
    files.contents.emplace_back(folder_ / exported.mask_path,
                                Encoded(".png", masks_ == MaskPlace::kDynamic ? cv::Mat(mask == 0) : mask));
  if (options_.depths) AddDepth(task, mask, files);
  return files;
}

ExportedFiles ExportedPhotographs::PhotographOf(const Task& task) const {
  const ExifFacts exposure = options_.with_exposures ? ExposureOf(task.view) : ExifFacts{};
  const bool copies = masks_ != MaskPlace::kAlpha && IsCopied(from_, task.view, task.map.x.empty(), options_);
  ExportedFiles files;
  if (copies)
    files = CopyOf(task);
  else
    files.contents.emplace_back(folder_ / task.exported.image_path, Made(task, exposure));
  if (!exposure.exposure_s && !exposure.f_number && !exposure.iso) return files;
  std::string& bytes = files.contents.front().second;
  std::optional<std::string> with_exif = WithExif(bytes, exposure);
  if (with_exif || (!copies && LowercaseEnding(task.exported.image_path) == ".exr"))
    files.exposure = exposure;
  if (with_exif) bytes = std::move(*with_exif);
  return files;
}

ExportedFiles ExportedPhotographs::CopyOf(const Task& task) const {
  const fs::path original = from_.root / task.view.image_path;
  ExportedFiles files;
  files.copied = true;
  files.stored = ReadPicture(original.string());
  files.stored.alpha.release();
  LogWarnings(original.string(), files.stored);
  // The light field's own reader reports a wrong size.
  if (files.stored.pixels.size() != SizeOf(from_.CameraOf(task.view))) ReadRecordedImage(from_, task.view);
  files.stored.pixels.release();
  files.contents.emplace_back(folder_ / task.exported.image_path, ReadWholeFile(original));
  return files;
}

std::string ExportedPhotographs::Made(const Task& task, const ExifFacts& exposure) const {
  if (masks_ == MaskPlace::kAlpha) return PngBytes(WithAlpha(EightBits(task), MaskFor(task)));
  switch (options_.format) {
    case PhotographFormat::kJpeg:
      return JpegBytes(EightBits(task), options_.jpeg_quality);
    case PhotographFormat::kPng16:
      return PngBytes(Srgb16FromLinear(LinearLight(task)));
    case PhotographFormat::kExr:
      return AsExr(task, exposure);
    case PhotographFormat::kAsTheyAre:
      break;
  }
  return options_.even_light ? PngBytes(EightBits(task)) : AsItIs(task);
}

std::string ExportedPhotographs::AsItIs(const Task& task) const {
  const fs::path original = from_.root / task.view.image_path;
  Image image = ReadRecordedImage(from_, task.view);
  if (IsRawFile(original)) image.pixels = Srgb8(image);  // no other program reads it
  return Encoded(LowercaseEnding(task.exported.image_path), Resampled(task.map, image.pixels),
                 IsExrWithColors(original) ? ExrColors(kRec709) : std::nullopt);
}

std::string ExportedPhotographs::AsExr(const Task& task, const ExifFacts& exposure) const {
  cv::Mat light = LinearLight(task);
  if (!options_.even_light) light = cv::max(light - cv::Scalar::all(task.view.black_level), 0);
  const bool has_profile = options_.even_light && from_.color_profiles.contains(task.view.camera);
  std::map<std::string, float> numbers;  // of OpenEXR's standard attributes
  if (exposure.exposure_s) numbers["expTime"] = static_cast<float>(*exposure.exposure_s);
  if (exposure.f_number) numbers["aperture"] = static_cast<float>(*exposure.f_number);
  if (exposure.iso) numbers["isoSpeed"] = static_cast<float>(*exposure.iso);
  return ExrBytes({{"B", light, 0}, {"G", light, 1}, {"R", light, 2}}, ExrCompression::kZip,
                  HasRec709Colors(task.view) || has_profile ? ExrColors(kRec709) : std::nullopt, {}, numbers);
}

cv::Mat ExportedPhotographs::EightBits(const Task& task) const {
  return options_.even_light ? Srgb8FromLinear(LinearLight(task))
                             : Resampled(task.map, Srgb8(ReadRecordedImage(from_, task.view)));
}

// The interpolation swings below 0 beside edges.
cv::Mat ExportedPhotographs::LinearLight(const Task& task) const {
  const cv::Mat light =
      options_.even_light ? options_.even_light(task.view) : LinearFloat(ReadRecordedLight(from_, task.view));
  return cv::max(Resampled(task.map, light), 0);
}

// The light field's facts, or else those of the photograph's own Exif data. ISO is 100 times the gain. A gain
// of 1 is known only where the camera told its exposure, or gains of other views, and no Exif data say more.
ExifFacts ExportedPhotographs::ExposureOf(const View& view) const {
  constexpr double kBaseIso = 100;
  const fs::path original = from_.root / view.image_path;
  ExifFacts facts = fs::is_regular_file(original) ? ExifOfPicture(ReadWholeFile(original)) : ExifFacts{};
  const bool has_own = facts.exposure_s || facts.iso;
  if (view.gain != 1 || (!has_own && (view.exposure_s > 0 || knows_gains_)))
    facts.iso = std::max(1.0, std::round(kBaseIso * view.gain));
  if (view.exposure_s > 0) facts.exposure_s = view.exposure_s;
  if (view.f_number) facts.f_number = view.f_number;
  if (view.focal_mm) facts.focal_mm = view.focal_mm;
  if (!view.lens.empty()) facts.lens = ExifText(view.lens);
  if (!from_.device_maker.empty()) facts.maker = ExifText(from_.device_maker);
  if (!from_.device_model.empty()) facts.model = ExifText(from_.device_model);
  return facts;
}

// What a mask excludes has no depth of its own.
void ExportedPhotographs::AddDepth(const Task& task, const cv::Mat& mask, ExportedFiles& files) const {
  PhotographDepth depth = options_.depths->of(task.view, to_.CameraOf(task.exported));
  if (!mask.empty()) {
    depth.depth.setTo(0, mask == 0);
    if (!depth.confidence.empty()) depth.confidence.setTo(0, mask == 0);
  }
  const fs::path path = folder_ / DepthPathOf(task.exported.image_path);
  files.contents.emplace_back(path.string() + ".exr", DepthExr(depth));
  files.contents.emplace_back(path.string() + ".png",
                              PngBytes(DepthPixels(depth.depth, options_.depths->png_unit, files.depths)));
}

}  // namespace ulf
