#include "render/gl/gl_proxy.h"

#include <epoxy/gl.h>

#include "render/gl/embedded_shaders.h"
#include "render/gl/gl_triangles.h"
#include "render/proxy/depth_raster.h"

namespace ulf::render {

constexpr unsigned kCoarserUnit = 14, kFilledUnit = 15;

const unsigned GlProxy::kDepthFormat = GL_R32F;

void GlProxy::Build() {
  const std::string head = "#version 450 core\n";
  program_.Build("proxy", head + shaders::k_proxy_vert, head + shaders::k_proxy_frag);
  pull_.Build("pull", head + shaders::k_fullscreen_vert, head + shaders::k_pull_frag);
  push_.Build("push", head + shaders::k_fullscreen_vert, head + shaders::k_push_frag);
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
  // The depth buffer holds near / depth, which is equally exact far away and close by.
  program_.Set("near", static_cast<float>(kNearShare * usual_depth));
  vertices_.BindStorage(6);
  corners_.BindStorage(7);
  no_vertices_.Bind();
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  SetDepthTest(GL_GREATER, true);
  depth_.Bind();
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * mesh->triangles.size()));
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  size_ = {camera.width, camera.height};
  FillHoles();
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void GlProxy::FillHoles() {
  std::vector<cv::Size> sizes;
  for (cv::Size size = size_; size.width > 1 || size.height > 1;)
    sizes.push_back(size = {(size.width + 1) / 2, (size.height + 1) / 2});
  while (coarser_.size() < sizes.size()) coarser_.emplace_back(kDepthFormat);
  const auto level = [&](std::size_t n) -> const GlTarget& { return n == 0 ? depth_ : coarser_[n - 1]; };
  pull_.Use();
  pull_.Set("depth", 0.0f);
  for (std::size_t n = 0; n < sizes.size(); ++n) {
    coarser_[n].Resize(sizes[n].width, sizes[n].height);
    pull_.Set("of_depths", n == 0 ? 1 : 0);
    level(n).BindTexture(kFilledUnit);
    coarser_[n].Bind();
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  push_.Use();
  push_.Set("depth", 0.0f);
  for (std::size_t n = sizes.size(); n-- > 0;) {
    push_.Set("of_depths", n == 0 ? 1 : 0);
    level(n + 1).BindTexture(kCoarserUnit);
    level(n).BindTexture(kFilledUnit);
    level(n).Bind();
    glTextureBarrier();  // each pixel reads itself before it writes itself
    // Draws only where nothing was drawn and the depth buffer has its cleared value.
    if (n == 0) SetDepthTest(GL_EQUAL, false);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
}

cv::Mat GlProxy::ReadDepth() const {
  cv::Mat depth;
  cv::extractChannel(depth_.Read(), depth, 2);  // red
  return depth;
}

void GlProxy::Release() {
  for (GlProgram* program : {&program_, &pull_, &push_}) program->Release();
  for (GlTarget& target : coarser_) target.Release();
  vertices_.Release();
  corners_.Release();
  no_vertices_.Release();
  depth_.Release();
  nearness_.Release();
  uploaded_.reset();
}

}  // namespace ulf::render
