// Fits the colours of Gaussians to photographs by least squares, while their places stay. The pictures that
// the Gaussians give are compared with the photographs, and each Gaussian takes up the differences of its
// pixels, as reconstruction from projections does it (SIRT, Gilbert 1972). A Gaussian's share of the normal
// equations is solved as a whole, four harmonics together; since the weights of a pixel sum to at most one,
// no step overshoots. Hence colours are sharpened against the blur of the Gaussians, what hides a Gaussian
// from a view is taken into account, and harmonics of degree 1 take up the change with direction, held back
// where the views tell little of it.
//
// Opacities and sizes follow in the same way, in a few steps between the first round and the last: a Gaussian
// that stands beside an edge or before what other views see there fades or shrinks.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/splats/gaussians.h"

namespace ulf::render {

struct ColorFitView {
  CameraModel camera;  // without distortion
  Rigid3 cam_from_world;
  cv::Mat photograph;  // CompareSplats()
};

struct ColorFitOptions {
  int rounds = 4;      // of all views
  int at_once = 16;    // views between two corrections, at most; fewer of few views
  bool shapes = true;  // fit opacities and sizes as well
  std::function<void(double share)> progress = {};
};

struct ColorFitSummary {
  std::vector<double> psnr_db;  // of each round, all views together, before its corrections
  std::vector<float> weights;   // of each Gaussian, px of all views in the last round: 0 for one never seen
};

// Views that follow each other should be spread over the scene.
ColorFitSummary FitColors(const std::vector<ColorFitView>& views, Gaussians& gaussians,
                          const ColorFitOptions& options);

}  // namespace ulf::render
