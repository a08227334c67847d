// Tests: render/gl/gl_objects, render/gl/gl_photographs, render/gl/gl_renderer,
// render/stereo/gl_plane_sweep.
//
// A driver that has no more memory: what is refused, what is said, and what goes on. Rows of
// docs/measured/cameras.md.
#include <epoxy/gl.h>
#include <gmock/gmock.h>

#include <chrono>

#include "core/base/error.h"
#include "core/base/host_time.h"
#include "render/gl/gl_renderer.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/gl_plane_sweep.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"
#include "tests/support/test_run.h"

namespace ulf::test::gl_memory_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

// What asks the driver for memory.
enum class Asks { kLayers, kImage, kDepths, kBuffer };

// The driver's own, once it has been used.
struct Calls {
  PFNGLTEXTURESTORAGE3DPROC layers = epoxy_glTextureStorage3D;
  PFNGLTEXTURESTORAGE2DPROC image = epoxy_glTextureStorage2D;
  PFNGLNAMEDRENDERBUFFERSTORAGEPROC depths = epoxy_glNamedRenderbufferStorage;
  PFNGLNAMEDBUFFERDATAPROC buffer = epoxy_glNamedBufferData;
  PFNGLGETERRORPROC error = epoxy_glGetError;
};

// Refuses one kind as a driver does that has no room for it: the call has no effect, and glGetError() says so
// once. epoxy's entry points are variables.
class FullDriver {
 public:
  // `after`: so many of this kind are still made.
  FullDriver(Asks refused, int after) {
    true_ = Calls{};
    refused_ = refused, left_ = after, out_of_memory_ = false;
    epoxy_glTextureStorage3D = [](GLuint texture, GLsizei levels, GLenum format, GLsizei width,
                                  GLsizei height, GLsizei depth) {
      if (HasRoom(Asks::kLayers)) true_.layers(texture, levels, format, width, height, depth);
    };
    epoxy_glTextureStorage2D = [](GLuint texture, GLsizei levels, GLenum format, GLsizei width,
                                  GLsizei height) {
      if (HasRoom(Asks::kImage)) true_.image(texture, levels, format, width, height);
    };
    epoxy_glNamedRenderbufferStorage = [](GLuint buffer, GLenum format, GLsizei width, GLsizei height) {
      if (HasRoom(Asks::kDepths)) true_.depths(buffer, format, width, height);
    };
    epoxy_glNamedBufferData = [](GLuint buffer, GLsizeiptr size, const void* data, GLenum usage) {
      if (HasRoom(Asks::kBuffer)) true_.buffer(buffer, size, data, usage);
    };
    epoxy_glGetError = []() -> GLenum {
      if (std::exchange(out_of_memory_, false)) return GL_OUT_OF_MEMORY;
      return true_.error();
    };
  }
  ~FullDriver() {
    epoxy_glTextureStorage3D = true_.layers;
    epoxy_glTextureStorage2D = true_.image;
    epoxy_glNamedRenderbufferStorage = true_.depths;
    epoxy_glNamedBufferData = true_.buffer;
    epoxy_glGetError = true_.error;
  }
  FullDriver(const FullDriver&) = delete;
  FullDriver& operator=(const FullDriver&) = delete;
  bool refused() const { return left_ < 0; }

 private:
  static bool HasRoom(Asks kind) {
    if (kind != refused_ || --left_ >= 0) return true;
    out_of_memory_ = true;
    return false;
  }
  static inline Calls true_{};
  static inline Asks refused_ = Asks::kLayers;
  static inline int left_ = 0;
  static inline bool out_of_memory_ = false;
};

TEST(GlMemory, RecoversFromAFullDriverWithTheSamePicture) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(12, 0.5, 2.0), .two_sizes = true});
  const CameraModel camera = CameraModel::Pinhole(120, 90, 100);
  const Rigid3 pose = LookAt({0.1, 0.05, 2}, {0, 0, 0}, {0, 1, 0});
  GlRenderer renderer(scene, {});
  const Rendering truth = renderer.Render(camera, pose);
  // Another size first, so that there is something to be resized.
  const CameraModel other = CameraModel::Pinhole(60, 46, 50);
  int tried = 0, lost = 0;
  double longest_s = 0;
  struct Case {
    Asks refused;
    int after;
    const char* says;
  };
  for (const Case& c : {Case{Asks::kLayers, 0, "photographs"}, Case{Asks::kLayers, 1, "photographs"},
                        Case{Asks::kDepths, 0, "making the depths to draw into"},
                        Case{Asks::kImage, 0, "making the image to draw into"},
                        Case{Asks::kImage, 1, "making the image to draw into"},
                        Case{Asks::kImage, 2, "making the image to draw into"}}) {
    const std::string which = fmt::format("{} after {}", c.says, c.after);
    GlRenderer starved(scene, {});
    if (c.refused != Asks::kLayers) starved.Render(other, pose);
    {
      const FullDriver driver(c.refused, c.after);
      for (int i = 0; i < 2; ++i)  // the second time it must not be taken for what is there
        EXPECT_THAT([&] { starved.Render(camera, pose); },
                    ThrowsMessage<Error>(AllOf(HasSubstr("out of memory while"), HasSubstr(c.says),
                                               HasSubstr("limit the photographs with gpu_memory"))))
            << which;
      EXPECT_TRUE(driver.refused()) << which;
      // What stood there already goes on beside it.
      EXPECT_EQ(cv::norm(renderer.Render(camera, pose).linear, truth.linear, cv::NORM_INF), 0) << which;
    }
    ++tried;
    const auto again = std::chrono::steady_clock::now();
    const Rendering picture = starved.Render(camera, pose);
    longest_s = std::max(longest_s, SecondsSince(again));
    const bool same = cv::norm(picture.linear, truth.linear, cv::NORM_INF) == 0;
    EXPECT_TRUE(same) << which << ": the same renderer, when there is room";
    lost += !same;
    if (c.refused == Asks::kLayers) {
      EXPECT_EQ(starved.photograph_counts().bytes, renderer.photograph_counts().bytes)
          << which << ": what was refused does not count";
    }
  }
  PrintFaultRow("graphics memory full while photographs are loaded or the picture is made, then room again",
                tried, fmt::format("the picture that was asked for; {} of those after it", lost), longest_s);
}

TEST(GlMemory, PlanesAreSweptWhenThereIsRoomAgain) {
  const std::vector<Patch> wall{{{-8, -6, 4}, {16, 0, 2}, {0, 12, 0}, Mottled(0.02, 1)}};
  const Drawn view = Draw(wall, {0, 0, 0}, {0, 0, 3}), beside = Draw(wall, {0.3, 0, 0}, {0, 0, 3});
  const std::vector<const render::StereoView*> neighbours{&beside.view};
  const render::InverseDepthRange range = render::FindRange(view.view, neighbours, 4);
  render::GlPlaneSweep sweep;
  const auto costs = [&] {
    const render::CostVolume volume = sweep.MatchingCosts(view.view, neighbours, range);
    std::vector<int> all;
    for (int y = 0; y < volume.height(); ++y)
      for (int x = 0; x < volume.width(); ++x)
        for (int label = 0; label < volume.labels(); ++label) all.push_back(volume.At(x, y)[label]);
    return all;
  };
  const std::vector<int> truth = costs();
  int tried = 0, lost = 0;
  for (const Asks refused : {Asks::kLayers, Asks::kBuffer})
    for (int after = 0; after < 2; ++after) {
      {
        const FullDriver driver(refused, after);
        EXPECT_THAT(
            costs, ThrowsMessage<Error>(AllOf(HasSubstr("out of memory while"), HasSubstr("size"),
                                              HasSubstr("renderer reference"), Not(HasSubstr("gpu_memory")))))
            << after;
        EXPECT_TRUE(driver.refused()) << after;
      }
      ++tried;
      lost += costs() != truth;
    }
  EXPECT_EQ(lost, 0);
  PrintFaultRow("graphics memory full while `ulf proxy --renderer gl` compares photographs, then room again",
                tried, fmt::format("the depth map that was asked for; {} of those after it", lost),
                std::nullopt);
}

}  // namespace
}  // namespace ulf::test::gl_memory_test
