#include "render/gl_proxy.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>

#include "acquisition/error.h"
#include "render/embedded_shaders.h"
#include "render/gl_triangles.h"

namespace ulf {

const unsigned GlProxy::kDepthFormat = GL_R32F;

void GlProxy::Build() {
  const std::string head = "#version 450 core\n";
  program_.Build("proxy", head + shaders::k_proxy_vert, head + shaders::k_proxy_frag);
}

void GlProxy::Draw(const std::shared_ptr<const TriangleMesh>& mesh, const CameraModel& camera,
                   const Rigid3& cam_from_world, double usual_depth) {
  if (mesh != uploaded_) {
    vertices_.Upload(mesh->vertices);
    corners_.Upload(mesh->triangles);
    uploaded_ = mesh;
  }
  nearness_.Resize(camera.width, camera.height);
  depth_.Resize(camera.width, camera.height, &nearness_);
  depth_.Clear(0);
  depth_.ClearDepth(0);
  const Eigen::Matrix3d r = cam_from_world.RotationMatrix();
  const Eigen::Vector3d& t = cam_from_world.translation;
  program_.Use();
  program_.Set("row0", MakeVec4(r(0, 0), r(0, 1), r(0, 2), t.x()));
  program_.Set("row1", MakeVec4(r(1, 0), r(1, 1), r(1, 2), t.y()));
  program_.Set("row2", MakeVec4(r(2, 0), r(2, 1), r(2, 2), t.z()));
  program_.Set("clip_x", MakeVec4(2 * camera.fx / camera.width, 2 * camera.cx / camera.width - 1, 0, 0));
  program_.Set("clip_y", MakeVec4(2 * camera.fy / camera.height, 2 * camera.cy / camera.height - 1, 0, 0));
  // The depth buffer holds near / depth: as exact far away as close by.
  program_.Set("near", static_cast<float>(1e-4 * usual_depth));
  vertices_.BindStorage(6);
  corners_.BindStorage(7);
  no_vertices_.Bind();
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);
  depth_.Bind();
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * mesh->triangles.size()));
  glDisable(GL_DEPTH_TEST);
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

cv::Mat GlProxy::ReadDepth() const {
  cv::Mat depth;
  cv::extractChannel(depth_.Read(), depth, 2);  // red
  return depth;
}

void GlProxy::Release() {
  program_.Release();
  vertices_.Release();
  corners_.Release();
  no_vertices_.Release();
  depth_.Release();
  nearness_.Release();
  uploaded_.reset();
}

}  // namespace ulf
