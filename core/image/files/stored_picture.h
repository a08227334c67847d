// What one picture file holds, in one form whatever the file's kind.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ulf {

struct StoredPicture {
  // The file's own order of rows and columns: marks that turn a picture for display are not applied. One
  // channel, or B, G, R. CV_8U and CV_16U are encoded as sRGB, CV_32F is linear light with sRGB's primaries,
  // 1 at full scale.
  cv::Mat pixels;
  cv::Mat alpha;  // one channel of the same depth, colours not multiplied by it; empty: opaque
  // Sentences that begin with "its" or "it". Notes: what was converted, or is turned for display, so that the
  // file's own numbers show another picture. Remarks: what is only said, such as that the file holds more
  // pictures. Warnings: what was not understood, and how it was taken.
  std::vector<std::string> notes = {}, remarks = {}, warnings = {};
};

// A sentence without the words that begin with a digit: what makes it one of a kind, where a folder's fault
// is said once.
std::string WithoutNumbers(const std::string& sentence);

// Notes a mark (Exif's numbers, 1 to 8) that turns or mirrors the picture for display, which is not applied.
void NoteOrientation(int orientation, StoredPicture& picture);

// Numbers of floating-point pictures that are no light, or are not likely to be of a white at 1: infinities
// and NaN, levels, absolute light.

// Of pixels as the file has them, before any conversion; other depths than CV_32F are passed over. All
// numbers stay as they are: those that are not finite are counted in a warning, and pixels that have one get
// no weight in renderings (photograph.h). Where more than half of the numbers above 0 are brighter than
// white, a warning says so with the median and the largest.
void CheckFloatNumbers(StoredPicture& picture);

}  // namespace ulf
