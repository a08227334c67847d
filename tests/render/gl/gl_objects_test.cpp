// Tests: render/gl/gl_context, render/gl/gl_objects, render/gl/gl_proxy, render/gl/gl_shadow_maps.
#include "render/gl/gl_objects.h"

#include <epoxy/gl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_proxy.h"
#include "render/gl/gl_shadow_maps.h"
#include "render/proxy/depth_raster.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::gl_objects_test {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GlContext, TheFormerContextIsCurrentAgain) {
  const GlContext first, second;
  EXPECT_FALSE(first.device().empty());
  const GlContext::Current current(first);
  GlTarget target(GL_RGBA32F);
  target.Resize(2, 2);
  {
    const GlContext::Current other(second);
    GlTarget its_own(GL_RGBA32F);
    its_own.Resize(3, 3);
    its_own.Clear(7);
    EXPECT_EQ(its_own.Read().at<cv::Vec4f>(2, 2)[0], 7);
    its_own.Release();
  }
  target.Clear(5);
  EXPECT_EQ(target.Read().at<cv::Vec4f>(1, 1)[0], 5);
  target.Release();
}

class GlObjects : public testing::Test {
 protected:
  const GlContext context_;
  const GlContext::Current current_{context_};
};

TEST_F(GlObjects, ATargetHoldsWhatItIsClearedWith) {
  GlTarget target(GL_RGBA32F), copy(GL_RGBA32F);
  target.Resize(8, 4);
  copy.Resize(8, 4);
  target.Clear({1, 2, 3, 4});
  target.CopyTo(copy);
  const cv::Mat pixels = copy.Read();
  EXPECT_EQ(pixels.size(), cv::Size(8, 4));
  EXPECT_EQ(pixels.at<cv::Vec4f>(3, 7), cv::Vec4f(3, 2, 1, 4)) << "B G R A";
  target.Release();
  copy.Release();
}

TEST_F(GlObjects, ABufferReturnsItsNumbers) {
  GlBuffer buffer;
  buffer.Upload(std::vector<std::int32_t>{3, -1, 4});
  EXPECT_THAT(buffer.Read(3), ElementsAre(3, -1, 4));
  buffer.Release();
}

TEST_F(GlObjects, AShaderThatDoesNotCompileIsNamed) {
  GlProgram program;
  EXPECT_THAT(
      [&] { program.Build("strange", "#version 450 core\nnonsense", "#version 450 core\nvoid main() {}"); },
      testing::ThrowsMessage<Error>(HasSubstr("shader strange (vertices)")));
}

TEST_F(GlObjects, TheCounterCountsPixels) {
  GlProgram program;
  program.Build("whole", R"(#version 450 core
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); })",
                "#version 450 core\nout vec4 color;\nvoid main() { color = vec4(1.0); }");
  GlTarget target(GL_RGBA32F);
  target.Resize(16, 9);
  target.Bind();
  GlEmptyVertexArray no_vertices;
  no_vertices.Bind();
  program.Use();
  GlPixelCounter counter;
  counter.Begin();
  glDrawArrays(GL_TRIANGLES, 0, 3);
  counter.End();
  EXPECT_EQ(counter.Count(), 16u * 9);
  counter.Release();
  program.Release();
  no_vertices.Release();
  target.Release();
}

TEST_F(GlObjects, TheProxysDepthIsThatOfTheProcessor) {
  const auto mesh = test::PlaneAndSquare();
  const CameraModel camera = CameraModel::Pinhole(80, 60, 70);
  const Rigid3 pose = LookAt({0.2, 0.1, 2}, Vector3d::Zero(), Vector3d::UnitY());
  GlProxy proxy;
  proxy.Build();
  proxy.Draw(mesh, camera, pose, 2);
  const cv::Mat depth = proxy.ReadDepth();
  cv::Mat expected = DrawInverseDepth(*mesh, camera, pose);
  FillHoles(expected);
  int same = 0;
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x)
      same += std::abs(depth.at<float>(y, x) * expected.at<float>(y, x) - 1) < 1e-3;
  EXPECT_GT(same, 0.98 * 80 * 60) << "all but the square's edge";
  proxy.Release();
}

TEST_F(GlObjects, ShadowMapsAreMadeForTheViewsThatNeedThem) {
  const auto plain = test::MakeScene({.viewpoints = test::GridViewpoints(3, 2, 0.3, 2.0)});
  GlShadowMaps maps;
  maps.Reset(plain->views);
  EXPECT_FALSE(maps.Provide(std::vector{0, 1})) << "a plane hides nothing";
  const auto scene = WithProxy(*plain, std::make_shared<MeshProxy>(plain->subject, test::PlaneAndSquare()));
  maps.Reset(scene->views);
  EXPECT_EQ(maps.LayerOf(4), -1);
  EXPECT_TRUE(maps.Provide(std::vector{4, 1}));
  EXPECT_EQ(maps.LayerOf(4), 0);
  EXPECT_EQ(maps.LayerOf(1), 1);
  EXPECT_FALSE(maps.Provide(std::vector{1, 4}));
  EXPECT_TRUE(maps.HasAll(std::vector{1, 4}));
  EXPECT_FALSE(maps.HasAll(std::vector{0}));
  maps.Release();
}

}  // namespace
}  // namespace ulf::gl_objects_test
