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

void GlProxy::UploadSights(const std::vector<SceneView>& views) {
  if (sights_) glDeleteTextures(1, &sights_);
  sights_ = 0;
  if (std::none_of(views.begin(), views.end(), [](const SceneView& view) { return view.sight != nullptr; }))
    return;
  GLint most_layers = 256;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (views.size() > static_cast<std::size_t>(most_layers))
    throw Error(
        "OpenGL: this driver can say for {} views what the proxy hides from them, not for {}; render with "
        "--proxy plane or --renderer reference",
        most_layers, views.size());
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &sights_);
  glTextureStorage3D(sights_, 1, GL_DEPTH_COMPONENT32F, kSightPx, kSightPx,
                     static_cast<GLsizei>(views.size()));
  CheckGl("making room for what the proxy hides");
  glTextureParameteri(sights_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(sights_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(sights_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(sights_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTextureParameteri(sights_, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTextureParameteri(sights_, GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].sight) continue;
    glTextureSubImage3D(sights_, 0, 0, 0, static_cast<GLint>(i), kSightPx, kSightPx, 1, GL_DEPTH_COMPONENT,
                        GL_FLOAT, views[i].sight->least_inverse_depth.data);
  }
  CheckGl("copying what the proxy hides");
}

void GlProxy::BindSights(unsigned unit) const { glBindTextureUnit(unit, sights_); }

void GlProxy::Release() {
  program_.Release();
  vertices_.Release();
  corners_.Release();
  no_vertices_.Release();
  depth_.Release();
  nearness_.Release();
  if (sights_) glDeleteTextures(1, &sights_);
  sights_ = 0;
  uploaded_.reset();
}

}  // namespace ulf
