// What stands still behind something that turns, as a camera that stands sees it: for every pixel the colour
// that comes back, and how far it is known.
//
// The colour of a pixel is the one on which most of its pictures agree. That it is the background's and not
// the subject's is told by time: a background that is uncovered stays so over several neighbouring pictures,
// where what turns changes from one to the next. Pixels that are never uncovered have none.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace ulf::render {

struct StillBackground {
  cv::Mat color;  // CV_32FC3, levels of 255
  cv::Mat known;  // CV_32F, 0: never seen, to 1
  cv::Mat still;  // CV_8U, 255: all pictures agree
  cv::Mat noise;  // CV_32F, one standard deviation of a picture's pixel, levels
};

// `pictures`: CV_8UC3 in order of time, of one size. `turning`: CV_8U of each, 255 where it is known to show
// what turns, whatever it looks like; empty: nowhere.
StillBackground LearnBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> turning);

// Pixels that never change, as far as they hang together with the picture's rim: the background's. What they
// enclose may be the subject, even where it looks still. CV_8U, 255 there.
cv::Mat StillToTheRim(const StillBackground& background);

// The colours of the background where it is sure.
class OutsideColors {
 public:
  OutsideColors(const StillBackground& background, const cv::Mat& outside);
  bool Tell() const { return tell_; }  // false: too little of the picture is outside
  // Of the outside's pixels, those whose colour (levels) is about this one.
  float ShareAround(const cv::Vec3f& color) const;

 private:
  static constexpr int kBins = 16;  // a channel
  static int BinOf(float level);
  static std::size_t Index(int b, int g, int r);
  std::vector<float> shares_;
  bool tell_ = false;
};

// Inside, a background of a colour that is nowhere outside is rather the subject, a smooth part of which
// comes back: it is known no more.
void DoubtForeignColors(StillBackground& background, const cv::Mat& outside, const OutsideColors& colors);

// By how much `picture` is shifted against the background, pixels, from where that is still. Found up to some
// three pixels; 0 where nothing that is still has edges.
cv::Point2d ShiftAgainst(const StillBackground& background, const cv::Mat& picture);

}  // namespace ulf::render
