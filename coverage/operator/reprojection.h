// Renders posed pictures from another camera as if all they show lay on one plane that faces that camera, as
// a weighted mean in light that is approximated by the square of pixel values. With equal weights this is a
// synthetic aperture, sharp on the plane (thesis, section 3.2: augmented aperture); with the pictures nearest
// in direction it is a quick preview of the light field. Both cameras keep their distortion: a grid over the
// output is projected into each picture on the processor, and OpenGL interpolates. All calls need the thread
// and the current OpenGL context of the display.
#pragma once

#include <cstdint>
#include <list>
#include <opencv2/core.hpp>
#include <vector>

#include "coverage/operator/posed_pictures.h"
#include "render/gl/gl_objects.h"

namespace ulf::coverage {

class Reprojection {
 public:
  Reprojection();
  ~Reprojection();
  Reprojection(const Reprojection&) = delete;
  Reprojection& operator=(const Reprojection&) = delete;

  // Draws what a camera at `cam_from_world` sees, at its own size, top row first, transparent where no
  // picture shows anything. `on_plane`: a point of the plane in world coordinates; if it is behind the camera
  // nothing is drawn. Returns the texture's OpenGL name, valid until the next call.
  unsigned Draw(const CameraModel& camera, const Rigid3& cam_from_world, const Eigen::Vector3d& on_plane,
                const std::vector<WeightedPicture>& pictures);
  cv::Mat Read() const;  // what was drawn, 8-bit B, G, R, black where nothing is

 private:
  unsigned TextureOf(const PosedPicture& picture);

  render::GlProgram add_, normalise_;
  render::GlBuffer vertices_;
  render::GlEmptyVertexArray no_attributes_;
  render::GlTarget sum_, result_;
  // The last few dozen pictures that were drawn, newest first.
  struct Uploaded {
    std::uint64_t key;
    unsigned texture;
  };
  std::list<Uploaded> uploaded_;
};

}  // namespace ulf::coverage
