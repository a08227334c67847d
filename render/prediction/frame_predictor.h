// Predicts a new frame from the recorded views, before that frame is recorded itself: their small pictures
// are projected over the mesh into the frame and blended. Compared with the frame (prediction_error.h) the
// prediction gives the light field's error at a viewpoint that it does not have.
//
// The blended views are the nearest in direction from the subject, weighted as in unstructured lumigraph
// rendering (Buehler et al. 2001): a view's weight falls to 0 at the direction of the first view that is left
// out. Each view is brought to the frame's exposure first, by one factor for its display-encoded values.
//
// The predictor uses no threads, and one thread uses it. Pictures are grey and reduced: a prediction takes a
// few milliseconds.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "render/proxy/shadow_map.h"
#include "render/proxy/triangle_mesh.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

// One view's part of a prediction.
struct PredictedByView {
  int id = 0;         // View::id
  cv::Mat grey;       // in the form of PredictedFrame::grey, multiplied by `gain`
  cv::Mat seen;       // CV_32F, 1 where the view sees the point, else 0
  double weight = 0;  // in the blend; the weights of all views sum to 1
  double gain = 1;    // from its own values to the frame's exposure
};

struct PredictedFrame {
  cv::Mat grey;           // CV_32F, as StereoView::grey, smoothed as Smoothed() does; 0 where no view sees
  cv::Mat valid;          // CV_8U, 255 where at least one view sees the point
  cv::Mat inverse_depth;  // CV_32F, 1 / (depth along the optical axis), of the mesh with its holes filled
  cv::Mat on_mesh;        // CV_8U, 255 on the mesh itself
  // CV_32F: variance of the views' values about their mean, grey values squared.
  cv::Mat variance_of_views;
  double noise_share = 1;              // share of a view's noise variance that the blend keeps
  std::vector<PredictedByView> views;  // nearest first
  double nearest_view_angle = 0;       // radians at the subject
  // As seen from the subject: 0 if views stand all round the frame, or one in its place; 1: all on one side.
  double one_sided = 0;
};

struct FramePredictorOptions {
  int views = 4;  // number of blended views. Guessed: as many as fill a pixel of the renderer.
};

// Smooths a picture before comparison (3x3, binomial), so that the blur of interpolation is no error.
cv::Mat Smoothed(const cv::Mat& grey);
inline constexpr double kSmoothedNoiseShare = 0.140625;  // remaining share of the noise variance

class FramePredictor {
 public:
  explicit FramePredictor(const FramePredictorOptions& options = {}) : options_(options) {}

  // Must come before the first prediction; again with each new mesh.
  void SetGeometry(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh);
  bool has_geometry() const { return mesh_ != nullptr; }
  const Subject& subject() const { return subject_; }
  // `id` is View::id. `read` is called when a frame near the view is predicted, and returns its small
  // picture; a view for which it throws is removed.
  void AddView(int id, const Rigid3& cam_from_world, std::function<StereoView()> read);
  void AddView(int id, const StereoView& view);
  void RemoveView(int id) { views_.erase(id); }
  void MoveViews(const std::map<int, Rigid3>& cam_from_world);
  int views() const { return static_cast<int>(views_.size()); }

  // Returns the angle at the subject between `center_in_world` and the nearest view, radians; infinite
  // without views.
  double NearestViewAngle(const Eigen::Vector3d& center_in_world) const;
  // Returns none without geometry or views, if the frame shows no mesh, or if no view sees any of it.
  std::optional<PredictedFrame> Predict(const StereoView& frame);

 private:
  struct Entry {
    Rigid3 cam_from_world;
    Eigen::Vector3d center_in_world;
    std::function<StereoView()> read;
    std::optional<StereoView> view;   // smoothed, grey as CV_8U; none: not read yet
    std::optional<ShadowMap> hidden;  // none: not made since the mesh or the view changed
  };
  struct Near {
    double angle = 0;
    int id = 0;
    Entry* entry = nullptr;
  };
  static StereoView ForStorage(StereoView view);
  static const StereoView& PictureOf(Entry& entry);
  static bool CanBeRead(Entry& entry);
  double OneSided(const Eigen::Vector3d& center_in_world, const std::vector<Near>& near) const;
  std::vector<Near> NearestTo(const Eigen::Vector3d& center_in_world, std::size_t count);
  std::vector<Near> NearestReadable(const Eigen::Vector3d& center_in_world, std::size_t count);

  FramePredictorOptions options_;
  Subject subject_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::map<int, Entry> views_;
};

}  // namespace ulf::render
