#include "acquisition/gphoto2/photograph_frame.h"

#include <utility>

namespace ulf::acquisition {

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
  const auto file = [](DownloadedFile& from, const std::string& extension) {
    return EncodedImage{extension, std::make_shared<const std::string>(std::move(from.bytes))};
  };
  if (!photograph.jpeg.bytes.empty()) frame.encoded = file(photograph.jpeg, ".jpg");
  if (!photograph.raw.bytes.empty()) frame.raw = file(photograph.raw, ExtensionOf(photograph.raw.name));
  return frame;
}

}  // namespace ulf::acquisition
