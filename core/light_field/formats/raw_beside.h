// Photographs of a set that exist twice, as the camera's raw file and as its JPEG: the raw file becomes the
// view's master, the JPEG its photograph, where the two show the same.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/files/raw_file.h"
#include "core/light_field/light_field.h"

namespace ulf {

// The raw file with the name of this photograph beside it; the JPEG with the name of this raw file. Empty:
// none.
std::filesystem::path RawBeside(const std::filesystem::path& photograph);
std::filesystem::path JpegBeside(const std::filesystem::path& raw);

// How far apart two pictures of one size show the same thing: the largest of the shifts in their middle and
// near their corners, in whole pixels. Pictures by other tone curves may be compared. None: neither shows
// enough to tell.
std::optional<double> LargestShiftPx(const cv::Mat& srgb8, const cv::Mat& other_srgb8);

// What the raw file says of the photograph becomes the view's, where the view does not know it.
void NoteRawFacts(const RawFacts& facts, View& view);

// What is worth a warning about the raw files of a set: lines for people.
class RawSetDoubts {
 public:
  // Returns the white balance by which the file is to be developed in place of its own: that of the set's
  // first raw file of this camera; none: its own.
  std::optional<WhiteBalance> Add(const std::string& file, const RawFacts& facts);
  // The raw file is not used beside its JPEG because they show different things.
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
