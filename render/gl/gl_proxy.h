// The proxy's triangles on the graphics side: a pass that draws how deep every pixel is, before anything is
// blended. As GlContext's objects, all need their context to be current.
#pragma once

#include <memory>
#include <vector>

#include "render/gl/gl_objects.h"
#include "render/scene/scene.h"

namespace ulf::render {

class GlProxy {
 public:
  // Compiles its shader; Error where the driver does not.
  void Build();

  // Draws `mesh` into a picture of depths along the optical axis, its holes as deep as what is around them
  // (FillHoles()), 0 where there is none of it at all; of what is much nearer than `usual_depth` nothing.
  void Draw(const std::shared_ptr<const TriangleMesh>& mesh, const CameraModel& camera,
            const Rigid3& cam_from_world, double usual_depth);
  void BindDepth(unsigned unit) const { depth_.BindTexture(unit); }
  cv::Mat ReadDepth() const;  // CV_32F

  void Release();

 private:
  void FillHoles();

  GlProgram program_, pull_, push_;
  GlBuffer vertices_, corners_;
  GlEmptyVertexArray no_vertices_;
  std::shared_ptr<const TriangleMesh> uploaded_;
  GlDepth nearness_;
  GlTarget depth_{kDepthFormat};
  std::vector<GlTarget> coarser_;  // inverse depths, each half the size of the one before
  cv::Size size_;

  static const unsigned kDepthFormat;
};

}  // namespace ulf::render
