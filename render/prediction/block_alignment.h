// Measures the displacement of one picture against another, block by block: the translation of a block that
// makes them alike (Lucas and Kanade 1981, coarse to fine), and its covariance.
//
// A block's mean brightness is ignored, so that differing light is not taken for displacement. Blocks without
// texture, and along straight edges, cannot be measured in every direction: their covariance says so.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ulf::render {

// The side of a block. Guessed: smaller blocks are noisier, larger ones mix surfaces. It is fixed, so that a
// row of a block is one vector operation.
inline constexpr int kBlockPx = 12;

// Noise variance of a smoothed picture's gradients, along x or y, over that of its pixels: from both kernels.
inline constexpr double kGradientNoiseShare = 0.417;

struct BlockAlignmentOptions {
  bool every_other = false;  // only the black squares of a chessboard
};

struct BlockShift {
  int column = 0, row = 0;                              // in the grid of blocks
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  // of the block, px of the frame
  // The frame at x shows what the prediction shows at x + shift.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance =
      Eigen::Matrix2d::Identity();  // px^2, from the pictures' noise and the residual
  bool converged = false;           // false: the search left the valid pixels, or went beyond 6 px
  // Mean squares of the difference, grey values squared: as predicted, after the shift, and after shift and a
  // brightness factor of the block.
  double mse = 0, mse_shifted = 0, mse_leveled = 0;
  double detail = 0, predicted_detail = 0;  // mean square gradients of the frame and of the prediction
  double contrast = 0;                      // mean square of the frame's differences from the block's mean
};

class BlockAlignment {
 public:
  // Both pictures are CV_32F of one size; `valid` has one channel, not 0 where `predicted` has a value.
  BlockAlignment(const cv::Mat& frame, const cv::Mat& predicted, const cv::Mat& valid,
                 const BlockAlignmentOptions& options = {});

  // Returns the blocks of which three quarters are valid, row by row. The noise variances are those of the
  // frame, smoothed by Smoothed() of frame_predictor.h, and of the difference of the two pictures.
  std::vector<BlockShift> Blocks(double frame_noise_variance, double noise_variance) const;
  // Returns what BlockShift::mse would be after another shift.
  double MeanSquareAfter(const BlockShift& block, const Eigen::Vector2d& shift_px) const;

 private:
  // Both pictures at one size, with the frame's gradients.
  struct Level {
    cv::Mat frame, predicted, valid;  // valid: CV_32F, 1 or 0
    cv::Mat by_x, by_y, predicted_gradient2;
  };
  struct Sums;
  struct Found;
  static Level MakeLevel(const cv::Mat& frame, const cv::Mat& predicted, const cv::Mat& valid);
  static Level Halved(const Level& fine);
  static Sums SumsOf(const Level& level, const cv::Rect& block, const Eigen::Vector2d& shift);
  static void SetDetail(const Level& level, const cv::Rect& rect, BlockShift& block);
  static Eigen::Matrix2d CovarianceOf(const Sums& sums, double frame_noise_variance, double noise_variance);
  Found Align(const Level& level, const cv::Rect& block, const Eigen::Vector2d& start, double least_pixels,
              double most_px) const;
  static cv::Rect BlockAt(const Eigen::Vector2d& center_px, const cv::Size& size);

  BlockAlignmentOptions options_;
  Level fine_, coarse_;
};

}  // namespace ulf::render
