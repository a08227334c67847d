// The content of one picture file, in one form whatever the file's kind.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ulf {

// What a file says of its numbers (colours, orientation): without it they show another picture.
struct PictureNote {
  enum class Kind {
    kTagged,  // by a colour profile, or the mark of orientation: ImageMagick understands it, too
    kOther,
  };
  std::string meaning;     // a sentence that begins with "its": "its colours are of the profile 'P3'"
  std::string conversion;  // how the sentence goes on for ulf: " and converted to sRGB"
  Kind kind = Kind::kOther;
  std::string Words() const { return meaning + conversion; }
};

struct StoredPicture {
  // Rows and columns in the file's own order; orientation for display is not applied. One channel, or B, G,
  // R. CV_8U and CV_16U are encoded as sRGB, CV_32F is linear light with sRGB's primaries, 1 at full scale.
  cv::Mat pixels;
  cv::Mat alpha;                        // one channel of the same depth, not premultiplied; empty: opaque
  std::vector<PictureNote> notes = {};  // conversions and orientations
  // Sentences that begin with "its" or "it". Remarks only inform, such as that the file holds more pictures.
  // Warnings tell what was not understood and how it was interpreted.
  std::vector<std::string> remarks = {}, warnings = {};
};

// Sets pixels and alpha from `pixels` of one to four channels: grey or B, G, R, and alpha behind them if any.
void TakePixels(const cv::Mat& pixels, StoredPicture& picture);

// Removes words that begin with a digit from a sentence, so that a folder's repeated fault is reported once.
std::string WithoutNumbers(const std::string& sentence);

// Notes an orientation for display (Exif's 2 to 8; others add nothing), which is not applied.
void NoteOrientation(int orientation, StoredPicture& picture);

// Checks CV_32F pixels of a file, before any conversion, for numbers that are no light, and changes none. A
// warning counts infinities and NaN, whose pixels get no weight in renderings (photograph.h). If more than
// half of the numbers above 0 are brighter than white, which is 1, a warning gives the median and the
// largest: they may be levels of integers, or light in physical units.
void CheckFloatNumbers(StoredPicture& picture);

}  // namespace ulf
