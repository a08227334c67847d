// A camera's raw file (NEF, CR2, CR3, ARW, DNG and others) as linear light, through LibRaw.
//
// What comes out is three channels of 16 bits, B, G, R, proportional to light, with the primaries and the
// white of sRGB: black level subtracted, the white balance that the file says (as shot; where it says none,
// the camera's daylight) or that the caller gives, the mosaic interpolated (AHD; X-Trans by Markesteijn's
// method, where a side is shorter than 512 pixels by bilinear interpolation), the camera's own colour matrix.
// Nothing depends on what the picture shows: no automatic brightness, no maximum taken from the pixels. Full
// scale is where the sensor's least amplified colour is full; colours beyond are clipped there, none is made
// up. What the sensor measured stands in the sensor's orientation: the mark by which other programs turn
// pictures is in `exif`. Corrections of the lens that a camera notes for converters (distortion, vignetting)
// are not applied.
//
// The visible area of a sensor is some pixels larger than the camera's JPEG. A picture is cropped as the
// camera crops it where the file says how, else it is all that is visible; where the caller knows the size
// (that of the camera model) it is cropped to that.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "core/image/files/exif.h"

namespace ulf {

// Factors of the sensor's red, green and blue; green is 1.
using WhiteBalance = std::array<double, 3>;

struct RawFacts {
  cv::Size size;     // as the camera crops it; all that is visible where the file does not say how
  cv::Size visible;  // of the sensor
  ExifFacts exif;
  std::string maker, model;
  bool has_white_balance = false;  // as shot; else the camera's daylight is used
  WhiteBalance white_balance{1, 1, 1};
  bool has_color_matrix = false;  // else the colours are the sensor's own
};

// The white balance of the pictures of one light field: for each camera (maker and model) that of the first
// raw file that was asked about. May be used by several threads.
class LockedWhiteBalance {
 public:
  // By what a raw file is to be developed; none: by its own.
  std::optional<WhiteBalance> InPlaceOf(const RawFacts& facts);

 private:
  Mutex mutex_;
  std::map<std::pair<std::string, std::string>, WhiteBalance> first_ ULF_GUARDED_BY(mutex_);
};

// kQuick: bilinear, half the time (24 megapixels: 0.7 s of processor for 1.4); for following and showing.
enum class RawQuality { kQuick, kBest };

// Whether a raw file of these facts can be cropped to `wanted`.
bool CanCropRaw(const RawFacts& facts, cv::Size wanted);

// All functions below throw Error that begins with `path` (or `name`), says what is wrong, and the way out:
// for files that are missing, cut short or damaged, of a kind that LibRaw does not read, and of sensors whose
// pixels are not square.

// Without decoding the pixels.
RawFacts ReadRawFacts(const std::string& path);

// CV_16UC3, B, G, R. `wanted`: the size to crop to; none: RawFacts::size. Throws Error where that cannot be.
// `white_balance`: none: RawFacts::white_balance. `clipped`: becomes what ClippedPixels() (clipped.h) means,
// found in the mosaic: 255 where the sensor, times its white balance, goes beyond full scale. The colour
// matrix hides that.
cv::Mat ReadRawFile(const std::string& path, std::optional<cv::Size> wanted = std::nullopt,
                    const std::optional<WhiteBalance>& white_balance = std::nullopt,
                    cv::Mat* clipped = nullptr);

struct RawPhotograph {
  cv::Mat light;  // as ReadRawFile() returns it
  RawFacts facts;
};
// The same from the bytes of a file.
RawFacts RawFactsOf(const std::string& bytes, const std::string& name);
RawPhotograph DecodeRaw(const std::string& bytes, const std::string& name, RawQuality quality,
                        std::optional<cv::Size> wanted = std::nullopt,
                        const std::optional<WhiteBalance>& white_balance = std::nullopt,
                        cv::Mat* clipped = nullptr);

}  // namespace ulf
