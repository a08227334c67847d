// Estimates the still background behind a turning subject, as a standing camera sees it: for every pixel its
// recurring colour, and how certain it is.
//
// A pixel's background is the colour on which most pictures agree. Time tells that this is not the subject's
// colour: the background stays uncovered over several successive pictures, while the subject changes from one
// to the next. The background of a pixel that is always covered remains unknown.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace ulf::render {

struct StillBackground {
  cv::Mat color;  // CV_32FC3, B G R, levels from 0 to 255
  cv::Mat known;  // CV_32F, belief in the colour: 0 (never seen) to 1
  cv::Mat still;  // CV_8U, 255 where nearly all pictures agree
  cv::Mat noise;  // CV_32F, standard deviation of a picture's pixel, levels
};

// `pictures` are CV_8UC3 in order of time, of one size. `turning` has a CV_8U for each, 255 where the picture
// is known to show the turning subject; empty means nowhere.
StillBackground EstimateBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> turning);

// Returns CV_8U, 255 at pixels that never change and are connected to the picture's rim: the background's.
// What they enclose may be the subject, even where it looks still.
cv::Mat StillConnectedToRim(const StillBackground& background);

// A histogram of the background's colours outside the subject: at the pixels where `outside` (CV_8U, as
// StillConnectedToRim() returns it) is not 0.
class BackgroundColors {
 public:
  BackgroundColors(const StillBackground& background, const cv::Mat& outside);
  bool IsReliable() const { return is_reliable_; }  // false: too little of the picture is outside
  // Returns the share of these pixels that have about this colour (B G R, levels).
  float ShareAround(const cv::Vec3f& color) const;

 private:
  static constexpr int kBins = 16;  // a channel
  static int BinOf(float level);
  static std::size_t Index(int b, int g, int r);
  std::vector<float> shares_;
  bool is_reliable_ = false;
};

// Lowers the belief in background that is not `outside` and whose colour hardly occurs there, down to 0: it
// is probably a smooth part of the subject.
void DropForeignColors(StillBackground& background, const cv::Mat& outside, const BackgroundColors& colors);

// Returns the shift of `picture` (CV_8UC3) in pixels, from the still part: the picture shows at x + shift
// what the background shows at x. Shifts up to some three pixels are found; 0 if what is still has no edges.
cv::Point2d ShiftAgainst(const StillBackground& background, const cv::Mat& picture);

}  // namespace ulf::render
