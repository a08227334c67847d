// Joins photographs of a set that exist as the camera's raw file and as its JPEG: the raw file becomes the
// view's master, the JPEG its photograph, if the two show the same.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/files/raw_file.h"
#include "core/light_field/light_field.h"

namespace ulf {

// These return the raw file of the same name beside a JPEG, and the JPEG beside a raw file; empty if none.
std::filesystem::path RawBeside(const std::filesystem::path& photograph);
std::filesystem::path JpegBeside(const std::filesystem::path& raw);

// Returns the misalignment of two pictures, whose tone curves may differ: the largest of the shifts in the
// middle and near the corners, in px; none if they are small, differ in size or lack texture.
std::optional<double> LargestShiftPx(const cv::Mat& srgb8, const cv::Mat& other_srgb8);

// Copies exposure, aperture, focal length and lens of the raw file to the view if the view lacks them.
void NoteRawFacts(const RawFacts& facts, View& view);

// Collects warnings about the raw files of a set, as lines for people.
class RawSetDoubts {
 public:
  // Notes what the raw file lacks. Returns the white balance to develop it with, that of the set's first raw
  // file of this camera; none means its own.
  std::optional<WhiteBalance> Add(const std::string& file, const RawFacts& facts);
  // Notes a raw file that is not used beside its JPEG because they show different things.
  void AddUnlike(const std::string& file, double shift_px);
  void AddUnusable(const std::string& why) { unusable_.push_back(why); }
  std::vector<std::string> Lines() const;

 private:
  std::string first_;
  LockedWhiteBalance white_balance_;
  std::vector<std::string> other_balance_, no_balance_, no_matrix_, unlike_, unusable_;
  double largest_shift_px_ = 0;
};

}  // namespace ulf
