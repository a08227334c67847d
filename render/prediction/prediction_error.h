// Measures the error of a light field at a viewpoint that it does not have, by comparing an unrecorded frame
// with its prediction from the recorded views (frame_predictor.h): the displacement in pixels
// (misregistration), and the remaining difference (in dB).
//
// Neither the frame's own noise nor the uncertainty of its pose is the light field's error. The noise
// variance is estimated from the frame and subtracted. Displacements that a small motion of the frame's
// camera explains, within the pose's uncertainty, are removed by the most probable motion; the excess is
// reported separately (PredictionError::pose_off_sigmas).
//
// Pixels are those of the given frame, grey values are 0 to 255, display-encoded.
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
  double least_px = 0.1;  // px, the least uncertainty of any pose. Guessed.
};

struct PredictionErrorOptions {
  BlockAlignmentOptions blocks;
};

// The error in a part of the picture.
struct RegionError {
  int blocks = 0;                 // number of blocks, seen by views or not
  int seen = 0;                   // of these, seen by the predicting views
  int alignable = 0;              // every other of these, for which alignment is tried
  int measured = 0;               // of these, with enough texture to measure displacement
  double misregistration_px = 0;  // root mean square over the measured blocks
  // Peak signal to noise ratios of the seen blocks without noise: as predicted but for the pose's part, and
  // each block aligned. At most 50.
  double db = 0, db_aligned = 0;
  double contrast = 0;  // root mean square of the frame about each block's mean, grey values; 0: no texture

  double SeenShare() const { return blocks > 0 ? static_cast<double>(seen) / blocks : 0; }
  double MeasuredShare() const { return alignable > 0 ? static_cast<double>(measured) / alignable : 0; }
};

struct BlockError {
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  // Root mean square over the predicting views, by weight, without the pose's part and noise.
  double off_px = 0;
  bool measured = false, inside = false, on_mesh = false;  // inside the silhouette
  // As in BlockShift, without noise, and `mse` without the pose's part.
  double mse = 0, mse_aligned = 0, mse_leveled = 0;
  double mse_by_view = 0;        // mean over the views, each aligned by itself, without noise; if measured
  double variance_of_views = 0;  // between views, without their noise
};

struct PredictionError {
  RegionError inside, outside;  // of the subject's silhouette
  std::vector<BlockError> blocks;
  double noise_sigma = 0;         // of frame - prediction, grey values
  double pose_px = 0;             // displacement at the subject by the most probable motion of the camera
  double pose_off_sigmas = 0;     // that motion, in standard deviations of the pose
  double nearest_view_angle = 0;  // radians
  double gain_spread = 0;         // ratio of the largest to the smallest exposure factor of the views
  // Mean square gradient of the frame over that of the prediction, inside the silhouette, both without noise:
  // below 1 the frame has less detail.
  double detail_ratio = 1;
  double on_mesh_share = 0;  // share of the silhouette's blocks with geometry
};

// Estimates the noise of an unsmoothed frame (CV_32F) as a standard deviation, grey values, from the parts of
// the image with the least detail. It is too large if there is detail everywhere.
double NoiseSigma(const cv::Mat& grey);

// `frame` is the one that FramePredictor::Predict() was given.
PredictionError MeasureError(const StereoView& frame, const PredictedFrame& predicted, const Subject& subject,
                             const PoseUncertainty& pose, const PredictionErrorOptions& options = {});

}  // namespace ulf::render
