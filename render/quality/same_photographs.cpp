#include "render/quality/same_photographs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/formats/image_names.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

// Pictures are compared at a quarter of their size, where noise that an encoder drops has no weight. They may
// differ by a root mean square of this share of the contrast (standard deviation) of the first one, or by
// this many steps of 8 bits. Guessed: JPEG of quality 60 loses half as much (measured on the test's drawn
// picture), and neighbouring views of a scene differ several times as much.
constexpr double kComparedSize = 0.25;
constexpr double kMostOfContrast = 0.1;
constexpr double kRoundingSteps = 1.5;

// Returns the file with the view's picture: the photograph, or the master that it follows from.
fs::path PictureFile(const LightField& light_field, const View& view) {
  std::error_code unknown;
  const fs::path photograph = light_field.root / view.image_path;
  if (view.master_path.empty() || fs::exists(photograph, unknown)) return photograph;
  return light_field.root / view.master_path;
}

std::map<std::uint64_t, std::vector<int>> ByLength(const LightField& light_field) {
  std::map<std::uint64_t, std::vector<int>> of_length;
  for (std::size_t i = 0; i < light_field.views.size(); ++i) {
    std::error_code unknown;
    const std::uint64_t length = fs::file_size(PictureFile(light_field, light_field.views[i]), unknown);
    if (!unknown) of_length[length].push_back(static_cast<int>(i));
  }
  return of_length;
}

std::string NameWithoutEnding(const View& view) {
  return fs::path(NameInImagesFolder(view.image_path)).replace_extension().generic_string();
}

bool ArePicturesAlike(const LightField& first, const View& a, const LightField& second, const View& b) {
  const cv::Size size = SizeOf(first.CameraOf(a));
  if (size != SizeOf(second.CameraOf(b))) return false;
  const auto small = [](const LightField& light_field, const View& view) {
    cv::Mat picture;
    cv::resize(Srgb8(ReadRecordedImage(light_field, view)), picture, {}, kComparedSize, kComparedSize,
               cv::INTER_AREA);
    return picture;
  };
  const cv::Mat in_first = small(first, a), in_second = small(second, b);
  const double numbers = static_cast<double>(in_first.total()) * in_first.channels();
  const double rms = cv::norm(in_first, in_second, cv::NORM_L2) / std::sqrt(numbers);
  cv::Scalar mean, deviation;
  cv::meanStdDev(in_first.reshape(1), mean, deviation);
  return rms <= std::max(kRoundingSteps, kMostOfContrast * deviation[0]);
}

// Pairs views (indices), each with at most one other.
class Pairing {
 public:
  Pairing(std::size_t first, std::size_t second) : of_first_(first, -1), is_taken_(second, false) {}
  bool IsFirstFree(int view) const { return of_first_[At(view)] < 0; }
  bool IsSecondFree(int view) const { return !is_taken_[At(view)]; }
  void Pair(int first, int second) {
    of_first_[At(first)] = second;
    is_taken_[At(second)] = true;
  }
  std::vector<SharedPhotograph> Found() const {
    std::vector<SharedPhotograph> found;
    for (std::size_t i = 0; i < of_first_.size(); ++i)
      if (of_first_[i] >= 0) found.push_back({static_cast<int>(i), of_first_[i]});
    return found;
  }

 private:
  std::vector<int> of_first_;  // the other's index; -1: none
  std::vector<bool> is_taken_;
};

void PairByContent(const LightField& first, const LightField& second, Pairing& pairing) {
  const auto in_second = ByLength(second);
  for (const auto& [length, views] : ByLength(first)) {
    const auto others = in_second.find(length);
    if (others == in_second.end()) continue;
    const auto content = [](const LightField& light_field, int view) {
      return FastChecksumOf(ReadWholeFile(PictureFile(light_field, light_field.views[At(view)])));
    };
    std::multimap<std::uint64_t, int> contents;
    for (const int other : others->second) contents.emplace(content(second, other), other);
    for (const int view : views)
      for (auto [same, end] = contents.equal_range(content(first, view)); same != end; ++same)
        if (pairing.IsFirstFree(view) && pairing.IsSecondFree(same->second)) pairing.Pair(view, same->second);
  }
}

}  // namespace

SharedPhotographs PhotographsInBoth(const LightField& first, const LightField& second) {
  Pairing pairing(first.views.size(), second.views.size());
  PairByContent(first, second, pairing);
  std::map<std::string, int> named;
  for (std::size_t i = 0; i < second.views.size(); ++i)
    if (pairing.IsSecondFree(static_cast<int>(i)))
      named.emplace(NameWithoutEnding(second.views[i]), static_cast<int>(i));
  SharedPhotographs shared;
  for (std::size_t i = 0; i < first.views.size(); ++i) {
    const View& view = first.views[i];
    const auto same = named.find(NameWithoutEnding(view));
    if (!pairing.IsFirstFree(static_cast<int>(i)) || same == named.end()) continue;
    if (ArePicturesAlike(first, view, second, second.views[At(same->second)]))
      pairing.Pair(static_cast<int>(i), same->second);
    else
      ++shared.other_pictures;
    named.erase(same);
  }
  shared.found = pairing.Found();
  return shared;
}

}  // namespace ulf::render
