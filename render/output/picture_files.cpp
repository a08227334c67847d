#include "render/output/picture_files.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/png_picture.h"
#include "render/output/tiled_rendering.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettingsFile = "render.json";

cv::Mat LightFor(const Rendering& picture, const PictureEncoding& encoding) {
  return encoding.closes_narrow_gaps ? WithNarrowGapsClosed(picture.linear, picture.drawn) : picture.linear;
}

// Blends like `light` after brightening by the exposure, which does not affect the background.
cv::Mat OverBackground(const cv::Mat& light, const cv::Mat& alpha, const PictureEncoding& encoding) {
  cv::Vec3f behind(0, 0, 0);
  if (encoding.background)
    for (int c = 0; c < 3; ++c)
      behind[c] = LinearFromSrgb(static_cast<float>((*encoding.background)[c])) /
                  static_cast<float>(std::exp2(encoding.exposure_stops));
  cv::Mat over(light.size(), CV_32FC3);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const float a = alpha.at<float>(y, x);
      over.at<cv::Vec3f>(y, x) = a * light.at<cv::Vec3f>(y, x) + (1 - a) * behind;
    }
  return over;
}

// Converts to B G R and alpha, not premultiplied.
template <typename Value>
cv::Mat WithAlpha(const cv::Mat& bgr, const cv::Mat& alpha) {
  constexpr float kFull = static_cast<float>(std::numeric_limits<Value>::max());
  cv::Mat with(bgr.size(), CV_MAKETYPE(bgr.depth(), 4));
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const auto color = bgr.at<cv::Vec<Value, 3>>(y, x);
      const auto a = cv::saturate_cast<Value>(kFull * alpha.at<float>(y, x));
      with.at<cv::Vec<Value, 4>>(y, x) =
          a == 0 ? cv::Vec<Value, 4>() : cv::Vec<Value, 4>(color[0], color[1], color[2], a);
    }
  return with;
}

bool KeepsAlpha(const Rendering& picture, const PictureEncoding& encoding) {
  return !picture.alpha.empty() && !encoding.background;
}

cv::Mat ShownLight(const Rendering& picture, const PictureEncoding& encoding) {
  const cv::Mat light = LightFor(picture, encoding);
  return picture.alpha.empty() ? light : OverBackground(light, picture.alpha, encoding);
}

cv::Mat DisplaySrgb16(const cv::Mat& linear, double exposure_stops) {
  return Srgb16FromLinear(linear * std::exp2(exposure_stops));
}

std::string ExrOf(const Rendering& picture, const PictureEncoding& encoding) {
  // EXR has premultiplied light.
  const cv::Mat color = HalfFromFloat(
      picture.alpha.empty() ? picture.linear : OverBackground(picture.linear, picture.alpha, encoding));
  cv::Mat alpha = picture.alpha;
  if (!KeepsAlpha(picture, encoding)) picture.drawn.convertTo(alpha, CV_32F, 1.0 / 255);
  std::vector<ExrChannel> channels{{"B", color, 0},
                                   {"G", color, 1},
                                   {"R", color, 2},
                                   {"A", HalfFromFloat(alpha)},
                                   {"confidence.Y", HalfFromFloat(picture.confidence)}};
  if (!picture.depth.empty()) channels.push_back({"Z", picture.depth});
  for (const ViewWeights& view : picture.weights)
    channels.push_back({fmt::format("weight.{:06}.Y", view.view_id), view.weight});
  std::map<std::string, std::string> attributes;
  if (!encoding.knows_colors)
    attributes["comments"] = "linear light in the sensor's own colours: the camera had no colour profile";
  return ExrBytes(channels, encoding.exr_compression,
                  encoding.knows_colors ? ExrColors(kRec709) : std::nullopt, attributes);
}

const char* EndingOf(PictureFormat format) { return format == PictureFormat::kExr ? ".exr" : ".png"; }

std::map<std::string, std::string> ReadSettings(const fs::path& file) {
  try {
    return JsonFromText(ReadWholeFile(file)).get<std::map<std::string, std::string>>();
  } catch (const nlohmann::json::exception&) {
    return {};  // written by another version of the program: the settings count as different
  }
}

std::string FirstDifference(const std::map<std::string, std::string>& stored,
                            const std::map<std::string, std::string>& asked) {
  for (const auto& [key, value] : asked) {
    const auto found = stored.find(key);
    const std::string was = found == stored.end() ? "unknown" : found->second;
    if (was != value) return fmt::format("{} was {}, now {}", key, was, value);
  }
  return {};
}

std::vector<fs::path> PicturesIn(const fs::path& folder) {
  static const std::regex numbered("frame_[0-9]{5,}\\.(png|exr)");
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && std::regex_match(entry.path().filename().string(), numbered))
      pictures.push_back(entry.path());
  return pictures;
}

[[noreturn]] void RefuseUnknown(const fs::path& folder) {
  throw Refusal(
      Parameter("output"), folder.string(),
      "holds pictures (frame_...) but no render.json that tells what they show, and they are not replaced",
      "choose another folder, or remove them yourself");
}

[[noreturn]] void RefuseOther(const fs::path& folder, const std::string& difference) {
  throw Refusal(Parameter("output"), folder.string(),
                fmt::format("holds pictures of another render ({})", difference),
                fmt::format("choose another folder, or {}", Parameter("overwrite")));
}

// Called before the new settings are written, so that the folder is consistent if the program is killed in
// between.
void RemoveFormer(const fs::path& folder, const std::vector<fs::path>& pictures,
                  const std::string& difference) {
  for (const fs::path& picture : pictures) fs::remove(picture);
  spdlog::warn("{} {}: {} of another render removed ({})", Parameter("output"), folder.string(),
               Counted(pictures.size(), "picture"), difference);
}

// Removes the temporary files of a process that was killed while it wrote this picture.
void RemoveLeftovers(const fs::path& picture) {
  constexpr std::chrono::minutes kLeastAge{5};  // another process may still write younger ones. Guessed.
  const std::string begins = picture.filename().string() + ".";
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(picture.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begins) && name.ends_with(kTemporaryEnding) &&
        entry.last_write_time(ignored) < fs::file_time_type::clock::now() - kLeastAge)
      fs::remove(entry.path(), ignored);
  }
}

}  // namespace

PictureFormat FormatOf(const fs::path& out, const std::string& format) {
  const std::string ending = out.extension().string();
  const bool exr = ending == ".exr", png = ending == ".png", video = IsVideo(out);
  if ((exr && !format.empty() && format != "exr") || (png && format == "exr") || (video && !format.empty()))
    throw Refusal(Parameter("output"), out.string(),
                  fmt::format("its ending contradicts {} {}", Parameter("format"), format),
                  "leave one of them out");
  if (out.has_extension() && !exr && !png && !video && !fs::is_directory(out))
    throw Refusal(Parameter("output"), out.string(),
                  "pictures are written as OUT.mp4, OUT.png, OUT.exr or into a folder", "");
  if (exr || format == "exr") return PictureFormat::kExr;
  return format == "png16" ? PictureFormat::kPng16 : PictureFormat::kPng;
}

bool IsSinglePicture(const fs::path& out) { return out.extension() == ".png" || out.extension() == ".exr"; }

bool IsVideo(const fs::path& out) { return out.extension() == ".mp4"; }

cv::Mat DisplaySrgb8(const cv::Mat& linear, double exposure_stops) {
  return Srgb8FromLinear(exposure_stops == 0 ? linear : cv::Mat(linear * std::exp2(exposure_stops)));
}

cv::Mat DisplayPicture(const Rendering& picture, const PictureEncoding& encoding) {
  return DisplaySrgb8(ShownLight(picture, encoding), encoding.exposure_stops);
}

std::string PictureBytes(const Rendering& picture, const PictureEncoding& encoding) {
  switch (encoding.format) {
    case PictureFormat::kPng16:
      if (KeepsAlpha(picture, encoding))
        return PngBytes(WithAlpha<std::uint16_t>(
            DisplaySrgb16(LightFor(picture, encoding), encoding.exposure_stops), picture.alpha));
      return PngBytes(DisplaySrgb16(ShownLight(picture, encoding), encoding.exposure_stops));
    case PictureFormat::kExr:
      return ExrOf(picture, encoding);
    default:
      if (KeepsAlpha(picture, encoding))
        return PngBytes(WithAlpha<std::uint8_t>(
            DisplaySrgb8(LightFor(picture, encoding), encoding.exposure_stops), picture.alpha));
      return PngBytes(DisplayPicture(picture, encoding));
  }
}

std::uint64_t MemoryForPicture(int width, int height, const PictureEncoding& encoding) {
  constexpr std::uint64_t kRendered = 12 + 4 + 1, kDepth = 4;  // light, confidence, drawn
  constexpr std::uint64_t kTargets = 60;                       // OpenGL's images and their copies in memory
  const auto encoded = [&]() -> std::uint64_t {
    switch (encoding.format) {
      case PictureFormat::kPng:
        return 3 * 3;  // pixels, the file, its copy
      case PictureFormat::kPng16:
        return 3 * 6;
      default:
        return kDepth + 10 + 4 +
               2 * 14;  // half floats; the file, at worst as large, and its copy while it grows
    }
  }();
  const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  const auto tile = static_cast<std::uint64_t>(std::min(width, kTilePx)) *
                    static_cast<std::uint64_t>(std::min(height, kTilePx));
  return pixels * (kRendered + encoded) + tile * kTargets;
}

void RequireMemory(int width, int height, const PictureEncoding& encoding, std::uint64_t available) {
  const std::uint64_t needed = MemoryForPicture(width, height, encoding);
  if (needed > available)
    throw Error(
        "a picture of {}x{} takes about {:.1f} GB of memory and {:.1f} GB are free; give a smaller {} or {}",
        width, height, 1e-9 * static_cast<double>(needed), 1e-9 * static_cast<double>(available),
        Parameter("width"), Parameter("height"));
}

void RequireFolderFor(const fs::path& out, std::map<std::string, std::string> known,
                      const std::map<std::string, std::string>& beginnings, bool overwrite) {
  if (!fs::is_directory(out) || PicturesIn(out).empty()) return;
  if (!fs::is_regular_file(out / kSettingsFile)) RefuseUnknown(out);
  if (overwrite) return;
  const std::map<std::string, std::string> stored = ReadSettings(out / kSettingsFile);
  for (const auto& [key, first_word] : beginnings) {
    const auto found = stored.find(key);
    const bool fits =
        found != stored.end() && found->second.substr(0, found->second.find_first_of(", ")) == first_word;
    known[key] = fits ? found->second : first_word;
  }
  if (const std::string difference = FirstDifference(stored, known); !difference.empty())
    RefuseOther(out, difference);
}

PictureFiles::PictureFiles(fs::path out, const PictureEncoding& encoding,
                           const std::map<std::string, std::string>& settings, bool overwrite)
    : out_(std::move(out)), encoding_(encoding), overwrite_(overwrite) {
  if (IsSinglePicture(out_)) {
    if (out_.has_parent_path()) MakeFolder(out_.parent_path());
    return;
  }
  MakeFolder(out_);
  const fs::path file = out_ / kSettingsFile;
  const bool known = fs::is_regular_file(file);
  const std::vector<fs::path> pictures = PicturesIn(out_);
  if (!known && !pictures.empty()) RefuseUnknown(out_);
  const std::string difference = known ? FirstDifference(ReadSettings(file), settings) : "";
  if (!difference.empty() && !pictures.empty()) {
    if (!overwrite) RefuseOther(out_, difference);
    RemoveFormer(out_, pictures, difference);
  }
  if (!known || !difference.empty()) WriteFileAtomically(file, JsonText(nlohmann::json(settings), 1) + "\n");
}

fs::path PictureFiles::PathOf(int number) const {
  return IsSinglePicture(out_) ? out_
                               : out_ / fmt::format("frame_{:05}{}", number, EndingOf(encoding_.format));
}

bool PictureFiles::Has(int number) const {
  return !overwrite_ && !IsSinglePicture(out_) && fs::is_regular_file(PathOf(number));
}

void PictureFiles::Write(int number, const Rendering& picture) {
  const fs::path path = PathOf(number);
  WriteFileAtomically(path, PictureBytes(picture, encoding_));
  RemoveLeftovers(fs::absolute(path));
}

cv::Mat WithNarrowGapsClosed(const cv::Mat& linear, const cv::Mat& drawn) {
  const int known = cv::countNonZero(drawn);
  if (known == 0 || known == static_cast<int>(drawn.total())) return linear;
  cv::Mat distance, nearest;
  cv::distanceTransform(drawn == 0, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<cv::Vec3f> color_of(static_cast<std::size_t>(known) + 1);
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (drawn.at<std::uint8_t>(y, x))
        color_of[static_cast<std::size_t>(nearest.at<int>(y, x))] = linear.at<cv::Vec3f>(y, x);
  const float most = static_cast<float>(kNarrowGapShare * std::max(drawn.cols, drawn.rows));
  cv::Mat gap_of;
  const int gaps = cv::connectedComponents(drawn == 0, gap_of, 8, CV_32S);
  std::vector<bool> is_narrow(static_cast<std::size_t>(gaps), true);
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (distance.at<float>(y, x) > most) is_narrow[static_cast<std::size_t>(gap_of.at<int>(y, x))] = false;
  cv::Mat closed = linear.clone();
  for (int y = 0; y < drawn.rows; ++y)
    for (int x = 0; x < drawn.cols; ++x)
      if (!drawn.at<std::uint8_t>(y, x) && is_narrow[static_cast<std::size_t>(gap_of.at<int>(y, x))])
        closed.at<cv::Vec3f>(y, x) = color_of[static_cast<std::size_t>(nearest.at<int>(y, x))];
  return closed;
}

}  // namespace ulf::render
