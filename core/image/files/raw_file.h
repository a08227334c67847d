// Reads a camera's raw file (NEF, CR2, CR3, ARW, DNG and others) as linear light, through LibRaw.
//
// The result has three channels of 16 bits, B, G, R, proportional to light, with the primaries and the white
// of sRGB: black level subtracted, white balance of the file (as shot, or else the camera's daylight) or of
// the caller, the mosaic interpolated (AHD; X-Trans by Markesteijn's method, bilinear if a side is shorter
// than 512 pixels), the camera's own colour matrix. Nothing depends on the picture's content: no automatic
// brightness, no maximum taken from the pixels. Full scale is where the sensor's least amplified colour is
// full; colours beyond are clipped there, none is invented. Rows and columns are the sensor's: `exif` holds
// the orientation for display. Lens corrections in the file (distortion, vignetting) are not applied.
//
// The visible area of a sensor is some pixels larger than the camera's JPEG. A picture is cropped to the size
// that the caller gives (that of the camera model), or else as the camera crops it if the file says how.
#pragma once

#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>

#include "core/base/mutex.h"
#include "core/image/files/exif.h"

namespace ulf {

// Factors of the sensor's red, green and blue; green is 1.
using WhiteBalance = std::array<double, 3>;

struct RawFacts {
  cv::Size size;     // px, as the camera crops it; equal to `visible` if the file does not say how
  cv::Size visible;  // px, the sensor's visible area
  ExifFacts exif;
  std::string maker, model;
  bool has_white_balance = false;       // the file holds one as shot
  WhiteBalance white_balance{1, 1, 1};  // as shot, or else the camera's daylight
  bool has_color_matrix = false;        // otherwise the colours are the sensor's own
};

// Keeps one white balance for the pictures of a light field: for each camera (maker and model) that of its
// first raw file. Several threads may use it.
class LockedWhiteBalance {
 public:
  // Returns the white balance to develop a raw file of these facts with; none means its own.
  std::optional<WhiteBalance> WhiteBalanceFor(const RawFacts& facts);

 private:
  Mutex mutex_;
  std::map<std::pair<std::string, std::string>, WhiteBalance> first_ ULF_GUARDED_BY(mutex_);
};

// kQuick, for tracking and display, is bilinear and takes half the CPU time (0.7 s for 24 megapixels).
enum class RawQuality { kQuick, kBest };

// Returns whether a raw file of these facts can be cropped to `wanted`: at most 5 % of a side are cut off.
bool CanCropRaw(const RawFacts& facts, cv::Size wanted);

// All functions below throw an Error that begins with `path` (or `name`), with the fault and the remedy, if a
// file is missing, truncated, damaged or of a kind that LibRaw does not read, or its pixels are not square.

// Reads the facts without decoding the pixels.
RawFacts ReadRawFacts(const std::string& path);

// Returns CV_16UC3, B, G, R. `wanted` is the size to crop to, by default RawFacts::size; throws Error if
// CanCropRaw() says no. `white_balance` is by default RawFacts::white_balance. `*clipped` becomes a mask as
// of ClippedPixels() (clipped.h), 255 where the sensor times its white balance goes beyond full scale; it is
// found in the mosaic because the colour matrix hides clipping.
cv::Mat ReadRawFile(const std::string& path, std::optional<cv::Size> wanted = std::nullopt,
                    const std::optional<WhiteBalance>& white_balance = std::nullopt,
                    cv::Mat* clipped = nullptr);

struct RawPhotograph {
  cv::Mat light;  // as ReadRawFile() returns it
  RawFacts facts;
};
// These do the same from the bytes of a file.
RawFacts RawFactsOf(const std::string& bytes, const std::string& name);
RawPhotograph DecodeRaw(const std::string& bytes, const std::string& name, RawQuality quality,
                        std::optional<cv::Size> wanted = std::nullopt,
                        const std::optional<WhiteBalance>& white_balance = std::nullopt,
                        cv::Mat* clipped = nullptr);

}  // namespace ulf
