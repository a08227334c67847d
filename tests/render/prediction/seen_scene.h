// A simulated scene with views on a grid of directions, and its true geometry: a light field in which nothing
// is wrong, so that a test can make one thing wrong.
#pragma once

#include <memory>
#include <string>

#include "acquisition/simulator/simulated_camera.h"
#include "render/prediction/frame_predictor.h"
#include "render/stereo/stereo_view.h"
#include "tests/support/floors.h"

namespace ulf::test {

class SeenScene {
 public:
  // Views every `spacing` radians, up to 15 degrees to the sides and 10 up and down. Pictures are drawn
  // `drawn_px` wide and reduced to 320: those of a transparent scene need the finer drawing.
  SeenScene(const std::string& name, double spacing, int drawn_px = 320);

  const Subject& subject() const { return camera_.scene().subject(); }
  Rigid3 PoseFrom(double azimuth, double elevation) const;
  // With noise of 1.5 grey values. `sway`: share of the amplitude of what moves.
  StereoView Look(const Rigid3& cam_from_world, unsigned seed, double sway = 0) const;
  FramePredictor Predictor() const;
  std::shared_ptr<const TriangleMesh> mesh() const { return mesh_; }

 private:
  SimulatedCamera camera_;
  std::vector<StereoView> views_;
  std::shared_ptr<const TriangleMesh> mesh_;
};

}  // namespace ulf::test
