// The error of a light field at a viewpoint that it does not have: a frame that was not recorded, compared
// with what the recorded views predict of it (frame_predictor.h). By how many pixels the prediction lies off
// (misregistration), and what differs where it does not (in dB).
//
// Neither the frame's own noise nor the uncertainty of its pose is the light field's error. The noise
// variance is estimated from the frame and subtracted. Displacements that a small motion of the frame's
// camera explains, within the pose's uncertainty, are taken out by the most probable motion; what of it goes
// beyond is told apart (PredictionError::pose_off_sigmas).
//
// Pixels are those of the frame that is given, grey values 0 to 255, display-encoded.
#pragma once

#include <optional>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/prediction/block_alignment.h"
#include "render/prediction/frame_predictor.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct PoseUncertainty {
  // Standard deviation of the camera's centre, world units; none: unknown, half a pixel at the subject.
  std::optional<double> center_sigma;
  double least_px = 0.1;  // of the pictures; no pose is surer than this. Guessed.
};

struct PredictionErrorOptions {
  BlockAlignmentOptions blocks;
};

// A part of the picture.
struct RegionError {
  int blocks = 0;     // of the part, seen by views or not
  int seen = 0;       // of these, by the views that predict
  int alignable = 0;  // of these, every other one, for which alignment is tried
  int measured = 0;   // of these, with texture enough to say how far off they are
  // Root mean square over the measured blocks; nine of ten are below `worst_px`.
  double misregistration_px = 0, worst_px = 0;
  // Peak signal to noise ratio of the seen blocks as predicted, after their displacement, and after a factor
  // of brightness for each block.
  double db = 0, db_aligned = 0, db_leveled = 0;
  double contrast = 0;  // root mean square of what the frame shows in a block, about its mean: 0 no texture

  double SeenShare() const { return blocks > 0 ? static_cast<double>(seen) / blocks : 0; }
  double MeasuredShare() const { return alignable > 0 ? static_cast<double>(measured) / alignable : 0; }
};

struct BlockError {
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  // Root mean square over the views that predict it, by their weight, without what the pose explains and
  // without noise.
  double off_px = 0;
  Eigen::Vector2d off_mean_px = Eigen::Vector2d::Zero();  // what all these views have in common
  bool measured = false, inside = false, on_mesh = false;
  double mse = 0, mse_aligned = 0, mse_leveled = 0;  // without the noise
  double mse_by_view =
      0;  // mean over the views when each is aligned by itself, without the noise; where measured
  double variance_of_views = 0;  // among each other, without their noise
};

struct PredictionError {
  RegionError inside, outside;  // of the subject's silhouette
  std::vector<BlockError> blocks;
  double noise_sigma = 0;         // of the difference of frame and prediction, grey values
  double pose_px = 0;             // displacement at the subject that the frame's pose explains
  double pose_off_sigmas = 0;     // how far the most probable motion lies outside the pose's uncertainty
  double nearest_view_angle = 0;  // radians
  double gain_spread = 0;  // largest over smallest factor by which views were brought to the frame's exposure
  // Mean square gradient of the frame over that of the prediction, inside the silhouette, both without noise:
  // below 1 the frame has less detail.
  double detail_ratio = 1;
  double on_mesh_share = 0;  // of the silhouette's blocks: where there is geometry at all
};

// Standard deviation of the noise of a frame that has not been smoothed, grey values. From parts of the image
// with the least detail: too large where there is detail everywhere.
double NoiseSigma(const cv::Mat& grey);

PredictionError MeasureError(const StereoView& frame, const PredictedFrame& predicted, const Subject& subject,
                             const PoseUncertainty& pose, const PredictionErrorOptions& options = {});

}  // namespace ulf::render
