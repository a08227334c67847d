#include "core/light_field/formats/raw_beside.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "core/base/counted.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_kind.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

fs::path FileBeside(const fs::path& file, const std::function<bool(const fs::path&)>& is_meant) {
  std::error_code unknown;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(file.parent_path(), unknown))
    if (entry.path().stem() == file.stem() && is_meant(entry.path()) && entry.is_regular_file(unknown))
      found.push_back(entry.path());
  std::ranges::sort(found);
  return found.empty() ? fs::path() : found.front();
}

bool IsJpegPath(const fs::path& path) {
  const std::string ending = Lowercase(path.extension().string());
  return ending == ".jpg" || ending == ".jpeg";
}

cv::Mat GreyPatch(const cv::Mat& srgb8, const cv::Rect& patch) {
  cv::Mat grey, levels;
  cv::cvtColor(srgb8(patch), grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(levels, CV_32F);
  return levels;
}

}  // namespace

fs::path RawBeside(const fs::path& photograph) {
  if (!IsJpegPath(photograph)) return {};
  return FileBeside(photograph, [](const fs::path& path) { return IsRawFile(path); });
}

fs::path JpegBeside(const fs::path& raw) { return FileBeside(raw, IsJpegPath); }

std::optional<double> LargestShiftPx(const cv::Mat& srgb8, const cv::Mat& other_srgb8) {
  // The middle of a patch of a sixth of the picture is searched in the other picture's patch, so that shifts
  // of a quarter of the patch are found. Patches with less contrast in levels, or less correlation, do not
  // count. Guessed.
  constexpr double kLeastContrast = 3, kLeastCorrelation = 0.7;
  const int side = std::clamp(std::min(srgb8.cols, srgb8.rows) / 6, 32, 256), margin = side / 4;
  if (srgb8.size() != other_srgb8.size() || srgb8.cols < 2 * side || srgb8.rows < 2 * side)
    return std::nullopt;
  std::optional<double> largest;
  const auto compare = [&](int x, int y) {
    const cv::Rect patch(x, y, side, side);
    const cv::Rect middle(margin, margin, side - 2 * margin, side - 2 * margin);
    const cv::Mat looked_for = GreyPatch(srgb8, patch)(middle), searched = GreyPatch(other_srgb8, patch);
    cv::Scalar mean, contrast;
    cv::meanStdDev(looked_for, mean, contrast);
    if (contrast[0] < kLeastContrast) return;
    cv::Mat correlations;
    cv::matchTemplate(searched, looked_for, correlations, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(correlations, nullptr, &best, nullptr, &at);
    if (best > kLeastCorrelation)
      largest = std::max(largest.value_or(0), std::hypot(at.x - margin, at.y - margin));
  };
  const int right = srgb8.cols - side, low = srgb8.rows - side;
  compare(right / 2, low / 2);
  for (const int x : {0, right})
    for (const int y : {0, low}) compare(x, y);
  return largest;
}

void NoteRawFacts(const RawFacts& facts, View& view) {
  if (view.exposure_s <= 0 && facts.exif.exposure_s) {
    view.exposure_s = *facts.exif.exposure_s;
    view.gain = facts.exif.iso.value_or(100) / 100;
  }
  if (!view.f_number) view.f_number = facts.exif.f_number;
  if (!view.focal_mm) view.focal_mm = facts.exif.focal_mm;
  if (view.lens.empty()) view.lens = facts.exif.lens;
}

std::optional<WhiteBalance> RawSetDoubts::Add(const std::string& file, const RawFacts& facts) {
  if (!facts.has_color_matrix) no_matrix_.push_back(file);
  if (!facts.has_white_balance) no_balance_.push_back(file);
  if (first_.empty()) first_ = file;
  const std::optional<WhiteBalance> locked = white_balance_.WhiteBalanceFor(facts);
  if (locked) other_balance_.push_back(file);
  return locked;
}

void RawSetDoubts::AddUnlike(const std::string& file, double shift_px) {
  unlike_.push_back(file);
  largest_shift_px_ = std::max(largest_shift_px_, shift_px);
}

std::vector<std::string> RawSetDoubts::Lines() const {
  std::vector<std::string> lines = unusable_;
  const auto add = [&](const std::vector<std::string>& files, const std::string& words) {
    if (!files.empty())
      lines.push_back(fmt::format("{} ({}{}): {}", Counted(files.size(), "raw file"), files.front(),
                                  files.size() > 1 ? ", ..." : "", words));
  };
  add(unlike_,
      fmt::format(
          "not used, because the JPEG shows things up to {:.1f} px elsewhere: the camera corrects its "
          "JPEGs for the lens, or crops them otherwise; switch the correction off in the camera, or "
          "pose pictures developed from the raw files",
          largest_shift_px_));
  add(other_balance_,
      "another white balance than " + first_ +
          ": developed with that one, so that colours agree between views; JPEGs keep their own, so set the "
          "camera to one white balance, not to automatic");
  add(no_balance_, "no white balance: the camera's daylight is used");
  add(no_matrix_, "no colour matrix of this camera is known: the colours are those of its sensor");
  return lines;
}

}  // namespace ulf
