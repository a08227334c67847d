// Estimates the still background behind a turning subject, as a standing camera sees it: for every pixel its
// recurring colour, and how certain it is.
//
// The colour of a pixel is the one on which most of its pictures agree. Time tells that it is the
// background's and not the subject's: an uncovered background stays so over several neighbouring pictures,
// while the subject changes from one to the next. Pixels that are never uncovered have none.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace ulf::render {

struct StillBackground {
  cv::Mat color;  // CV_32FC3, levels of 255
  cv::Mat known;  // CV_32F, 0: never seen, to 1
  cv::Mat still;  // CV_8U, 255: all pictures agree
  cv::Mat noise;  // CV_32F, standard deviation of a picture's pixel, levels
};

// `pictures` are CV_8UC3 in order of time, of one size. `turning` has a CV_8U for each, 255 where it is known
// to show the turning subject, whatever its look; empty means nowhere.
StillBackground EstimateBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> turning);

// Returns CV_8U, 255 at pixels that never change and are connected to the picture's rim: the background's.
// What they enclose may be the subject, even where it looks still.
cv::Mat StillConnectedToRim(const StillBackground& background);

// A histogram of the background's colours outside the subject.
class BackgroundColors {
 public:
  BackgroundColors(const StillBackground& background, const cv::Mat& outside);
  bool IsReliable() const { return is_reliable_; }  // false: too little of the picture is outside
  // Returns the share of outside pixels with about this colour (levels).
  float ShareAround(const cv::Vec3f& color) const;

 private:
  static constexpr int kBins = 16;  // a channel
  static int BinOf(float level);
  static std::size_t Index(int b, int g, int r);
  std::vector<float> shares_;
  bool is_reliable_ = false;
};

// Marks the background inside as unknown if its colour does not occur outside: it is probably a smooth part
// of the subject.
void DropForeignColors(StillBackground& background, const cv::Mat& outside, const BackgroundColors& colors);

// Returns the shift of `picture` against the background in pixels, from the still part. It is found up to
// some three pixels, and 0 if nothing still has edges.
cv::Point2d ShiftAgainst(const StillBackground& background, const cv::Mat& picture);

}  // namespace ulf::render
