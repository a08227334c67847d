// Computes the soft field's pixel: the candidate surfaces along its ray, the belief in each, and their
// colours (after Penner and Zhang 2017, "Soft 3D reconstruction for view synthesis"; here each pixel reads
// the views' depth maps, without volumes of votes). The OpenGL renderer computes the same
// (render/gl/shaders/soft.frag).
//
//   1. The views are the nearest kSoftViews that have the proxy's point in their images, with the penalty of
//      angle and resolution that lumigraph weights use. The weight of a view is a Gaussian of its penalty, as
//      wide as FieldOptions::soft_width says; a view in the virtual camera's own place takes all. Views
//      without weight take no part in what follows.
//   2. Candidates are the proxy's depth, and the depths at which the maps of the kSoftProposers views of
//      least penalty meet the ray, each found by a few steps from the proxy's depth.
//   3. The views vote for each candidate by how near their maps are to it, in steps of the maps. A view whose
//      map is far before the candidate sees something else there, and has no vote. Colours of the views that
//      differ lower the belief in a candidate: on a wrong surface they do.
//   4. A candidate's colour is the mean of the views that see it, in linear light; what a view sees fades
//      over a few steps of its map. Their weights are balanced: views on the side where there are fewer count
//      more, so that the mean of their directions comes near the virtual camera's, as in local linear
//      regression (Cleveland 1979; no weight becomes negative). This comes nearer to shading that changes
//      with direction, and evens out what a wrong depth displaces. Views whose colour is far from the mean
//      count less: they are off by an edge, a highlight or a passer-by.
//   5. Candidates are laid over each other from near to far, each as opaque as it is believed.
//
// Over a proxy without depth maps there is one candidate, the proxy's, and its shadow maps tell visibility.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "render/scene/scene.h"
#include "render/scene/view_tiles.h"

namespace ulf::render {

inline constexpr int kSoftViews = 16, kSoftProposers = 8;

// Settled on fern of LLFF and fox_half (docs/rendering.md, Soft geometry); the same in the shader.
struct SoftConstants {
  // A step is one of a map (ViewDepthMap::step); the root of light is its square root.
  double least_weight = 0.05;  // of the Gaussian: all views lose it, so that lesser ones have no weight
  double most_taken = 0.9;     // but at most this share of the Gaussian of the view of least penalty
  double own_share = 0.1;      // share of the fourth penalty below which a view begins to take all
  int search_steps = 3;        // number of iterations that look for a map along the ray
  double search_end = 2;       // a search whose last change exceeds this many steps has failed
  double merged = 1;           // candidates within this many steps of the finest map are one
  double vote = 2;             // standard deviation of a vote, in steps
  double occluded = 4;         // a map that is this many steps before a point hides it
  double least_seen = 0.003;   // visibility in a hidden view, which counts if no view sees the point
  double balanced = 1;         // ridge of the balance, in the squared width of the weights
  double agreeing = 0.2;       // standard deviation of colours on a right surface, in the root of light
  double robust = 0.2;         // difference from the mean, in the root of light, that halves a weight
  int robust_steps = 2;        // number of iterations that reweight
};

// One view's light in a pixel.
struct Contribution {
  int view = 0;  // index into RenderScene::views
  double weight = 0;
  cv::Vec3f light;
};

class SoftPixel {
 public:
  // `light_of(view, img)` is light on the common scale, and the share of it that the photograph has there.
  using LightOf = std::function<cv::Vec4f(int view, const Eigen::Vector2d& img)>;
  // `width` is FieldOptions::soft_width.
  SoftPixel(const RenderScene& scene, const Rigid3& cam_from_world, double width, LightOf light_of);

  // Sets the contributions of a pixel, and returns their sum of weights: the share of light in the
  // photographs, times the best view's visibility; 0 without contributions. `ray_in_cam` has depth 1; `depth`
  // is the proxy's, in world units; `views` are the nearest first (SoftViewsOfTiles).
  double Blend(const Eigen::Vector3d& ray_in_cam, double depth, std::span<const int> views,
               std::vector<Contribution>& contributions) const;

 private:
  struct Chosen {
    int view;
    double penalty, weight;
    Eigen::Vector2d aside;  // direction relative to the virtual camera's, seen from the point
  };
  struct Choice {
    std::vector<Chosen> views;
    double width = 0;  // of the weights, as a penalty
  };
  struct Sample {
    int view;
    double weight, seen, feather;
    Eigen::Vector2d aside;
    cv::Vec3d light, root;
  };
  Choice Choose(const Eigen::Vector3d& point_in_world, std::span<const int> views) const;
  std::vector<double> Candidates(const Eigen::Vector3d& ray_in_cam, double inverse_depth,
                                 const std::vector<Chosen>& chosen) const;
  double Blend(const Eigen::Vector3d& ray_in_cam, double inverse_depth, const Choice& chosen,
               std::vector<Sample>& samples, double& belief) const;
  void Balance(std::vector<Sample>& samples, double width) const;

  const RenderScene& scene_;
  Rigid3 world_from_cam_;
  std::vector<Rigid3> view_from_cam_;
  Eigen::Vector3d virtual_center_;
  double width_;
  LightOf light_of_;
  SoftConstants constants_;
};

// Returns for each tile of the picture the views that its pixels examine, nearest first.
ViewTiles SoftViewsOfTiles(ViewTiler& tiler, const RenderScene& scene, const CameraModel& camera,
                           const Rigid3& cam_from_world);

}  // namespace ulf::render
