// The views from which Gaussians are made: each one's photograph without distortion, the surface that its
// depth map shows, how coarse Gaussians may be where the photograph is smooth, and which of its pixels have a
// Gaussian already.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"
#include "render/splats/surface_map.h"

namespace ulf::render {

// A Gaussian stands for a cell of 1, 2, 4 or 8 pixels of a view.
inline constexpr int kCellSizes = 4;

struct SplatView {
  CameraModel camera;  // without distortion
  Rigid3 cam_from_world;
  cv::Mat photograph;  // EvenPicture()
  float reduced = 1;   // how many times a larger picture of the view has its width (Reduced())
  SurfaceMap surface;
  SurfaceMap mesh_surface;                    // where the maps of the views disagree
  std::array<cv::Mat, kCellSizes> means;      // CV_8UC3: the mean colour of each cell, by size
  std::array<cv::Mat, kCellSizes> roughness;  // CV_8U: how far the cell is from what its and its neighbours'
                                              // means say, the largest of its pixels; empty for single pixels
  cv::Mat done;                               // CV_8U, not 0: a Gaussian shows the pixel

  // Returns whether the photograph has no light at a pixel.
  bool IsGap(int x, int y) const {
    return photograph.channels() == 4 && photograph.at<cv::Vec4b>(y, x)[3] == 0;
  }
};

// Returns up to `most` views, each far from those before it. Their pictures are as large as their
// photographs, or all smaller, so that they have no more than `most_px` together. The scene's proxy must
// have a mesh. Throws Error if a photograph cannot be read.
std::vector<SplatView> MakeSplatViews(const RenderScene& scene, int most, double most_px,
                                      const std::function<void(double share)>& progress);
// Returns the longer side of the largest picture.
int LongestSide(const std::vector<SplatView>& views);
// Returns the same views with pictures whose longer side has at most `size_px`; no pixel is `done`.
std::vector<SplatView> Reduced(const std::vector<SplatView>& views, int size_px);

}  // namespace ulf::render
