#include "acquisition/gphoto2/photograph_pairing.h"

#include <utility>

#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

// How long a photograph that was delivered without its second file is remembered. Guessed.
constexpr double kRememberedS = 60;

}  // namespace

std::string StemOf(const std::string& file_name) {
  return Lowercase(file_name.substr(0, file_name.rfind('.')));
}

std::string ExtensionOf(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  const std::string extension = dot == std::string::npos ? "" : Lowercase(file_name.substr(dot));
  return extension == ".jpeg" || extension == ".jpe" ? ".jpg" : extension;
}

void PhotographPairing::ExpectFormat(const std::string& image_format) {
  const PhotographFiles files = FilesOf(image_format);
  expects_raw_ = files.raw;
  expects_jpeg_ = files.jpeg;
}

bool PhotographPairing::IsComplete(const DownloadedPhotograph& photograph) const {
  const bool jpeg = !photograph.jpeg.name.empty(), raw = !photograph.raw.name.empty();
  return (jpeg || !expects_jpeg_) && (raw || !expects_raw_);
}

std::optional<DownloadedFile> PhotographPairing::LateFile(const std::string& file_name, double now_s) const {
  const auto other = incomplete_.find(StemOf(file_name));
  const bool is_jpeg = ExtensionOf(file_name) == ".jpg";
  if (other == incomplete_.end() || other->second.was_jpeg == is_jpeg ||
      now_s - other->second.at_s > kRememberedS)
    return std::nullopt;
  DownloadedFile late = other->second.times;
  late.name = file_name;
  late.is_late = true;
  return late;
}

void PhotographPairing::Add(DownloadedFile file, double now_s) {
  const std::string stem = StemOf(file.name);
  const bool is_jpeg = ExtensionOf(file.name) == ".jpg";
  if (file.is_late) {
    incomplete_.erase(stem);
    DownloadedPhotograph rest;
    (is_jpeg ? rest.jpeg : rest.raw) = std::move(file);
    ready_.push_back(std::move(rest));
    return;
  }
  Waiting& waiting = waiting_[stem];
  const bool taken = !(is_jpeg ? waiting.photograph.jpeg : waiting.photograph.raw).name.empty();
  // A second file of this name is of another photograph: the camera's count has started again.
  if (taken) ready_.push_back(std::exchange(waiting, {}).photograph);
  if (waiting.photograph.First().name.empty()) waiting.since_s = now_s;
  (is_jpeg ? waiting.photograph.jpeg : waiting.photograph.raw) = std::move(file);
  if (!IsComplete(waiting.photograph)) return;
  ready_.push_back(std::move(waiting.photograph));
  waiting_.erase(stem);
}

std::vector<DownloadedPhotograph> PhotographPairing::Take(double now_s, const OnItsWay& on_its_way) {
  std::erase_if(incomplete_, [&](const auto& entry) { return now_s - entry.second.at_s > kRememberedS; });
  for (auto entry = waiting_.begin(); entry != waiting_.end();) {
    auto& [stem, waiting] = *entry;
    if (on_its_way(stem)) waiting.since_s = now_s;
    if (now_s - waiting.since_s < patience_s_) {
      ++entry;
      continue;
    }
    const DownloadedFile& half = waiting.photograph.First();
    incomplete_[stem] = {
        {.name = "", .bytes = "", .announced_s = half.announced_s, .released_s = half.released_s},
        !waiting.photograph.jpeg.name.empty(),
        now_s};
    ready_.push_back(std::move(waiting.photograph));
    entry = waiting_.erase(entry);
  }
  return std::exchange(ready_, {});
}

std::vector<DownloadedPhotograph> PhotographPairing::TakeAll() {
  for (auto& [stem, waiting] : waiting_) ready_.push_back(std::move(waiting.photograph));
  waiting_.clear();
  return std::exchange(ready_, {});
}

Frame FrameOf(DownloadedPhotograph photograph, const ExifFacts& exif, const CameraSettings& settings,
              double shutter_lag_s) {
  Frame frame;
  frame.kind = FrameKind::kStill;
  const DownloadedFile& first = photograph.First();
  const bool asked = first.released_s > 0;
  if (asked && !first.is_late) frame.requested_s = first.released_s;
  frame.device_time_s = asked ? first.released_s + shutter_lag_s : first.announced_s;
  frame.exposure_s = exif.exposure_s.value_or(settings.Number(ShotSetting::kShutter).value_or(0));
  frame.gain = exif.iso.value_or(settings.Number(ShotSetting::kIso).value_or(100)) / 100;
  frame.f_number = exif.f_number ? exif.f_number : settings.Number(ShotSetting::kAperture);
  frame.focal_mm = exif.focal_mm;
  frame.lens = exif.lens;
  const auto file = [](DownloadedFile& from, const std::string& extension) {
    return EncodedImage{extension, std::make_shared<const std::string>(std::move(from.bytes))};
  };
  if (!photograph.jpeg.bytes.empty()) frame.encoded = file(photograph.jpeg, ".jpg");
  if (!photograph.raw.bytes.empty()) frame.raw = file(photograph.raw, ExtensionOf(photograph.raw.name));
  return frame;
}

}  // namespace ulf::acquisition
