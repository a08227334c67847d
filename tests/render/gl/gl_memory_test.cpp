// Tests: render/gl/gl_objects, render/gl/gl_photographs, render/gl/gl_renderer, render/gl/make_renderer.
//
// A driver that has no more memory: what is refused, what is said, and what goes on. A row of docs/reliability.md.
#include <epoxy/gl.h>
#include <gmock/gmock.h>

#include <chrono>
#include <numeric>

#include "core/base/error.h"
#include "core/base/host_time.h"
#include "render/gl/gl_renderer.h"
#include "render/gl/make_renderer.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/fault_row.h"
#include "tests/support/floors.h"

namespace ulf::test::gl_memory {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

// Refuses layers of pictures as a driver does that has no room for them: the call has no effect, and glGetError() says so
// once. epoxy's entry points are variables.
class FullDriver {
 public:
  // `after`: so many arrays are still made.
  explicit FullDriver(int after) : storage_(epoxy_glTextureStorage3D), error_(epoxy_glGetError) {
    left_ = after, out_of_memory_ = false, made_ = storage_, asked_ = error_;
    epoxy_glTextureStorage3D = Storage;
    epoxy_glGetError = Asked;
  }
  ~FullDriver() {
    epoxy_glTextureStorage3D = storage_;
    epoxy_glGetError = error_;
  }
  FullDriver(const FullDriver&) = delete;
  FullDriver& operator=(const FullDriver&) = delete;
  bool refused() const { return left_ < 0; }

 private:
  static void Storage(GLuint texture, GLsizei levels, GLenum format, GLsizei width, GLsizei height,
                      GLsizei depth) {
    if (--left_ >= 0) return made_(texture, levels, format, width, height, depth);
    out_of_memory_ = true;
  }
  static GLenum Asked() {
    if (!std::exchange(out_of_memory_, false)) return asked_();
    return GL_OUT_OF_MEMORY;
  }
  static inline int left_ = 0;
  static inline bool out_of_memory_ = false;
  static inline PFNGLTEXTURESTORAGE3DPROC made_ = nullptr;
  static inline PFNGLGETERRORPROC asked_ = nullptr;
  PFNGLTEXTURESTORAGE3DPROC storage_;
  PFNGLGETERRORPROC error_;
};

TEST(GlMemory, ADriverWithoutRoomIsAnErrorAndThePictureIsTheSameWhenThereIsRoom) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(12, 0.5, 2.0), .two_sizes = true});
  const CameraModel camera = CameraModel::Pinhole(120, 90, 100);
  const Rigid3 pose = LookAt({0.1, 0.05, 2}, {0, 0, 0}, {0, 1, 0});
  GlRenderer renderer(scene, {});
  const Rendering truth = renderer.Render(camera, pose);
  int tried = 0, lost = 0;
  double longest_s = 0;
  for (int after = 0; after < 2; ++after) {
    GlRenderer starved(scene, {});
    {
      const FullDriver driver(after);
      EXPECT_THAT([&] { starved.Render(camera, pose); },
                  ThrowsMessage<Error>(AllOf(HasSubstr("out of memory"), HasSubstr("--gpu-memory"))))
          << after;
      EXPECT_TRUE(driver.refused()) << after;
      // What stood there already goes on beside it.
      EXPECT_EQ(cv::norm(renderer.Render(camera, pose).linear, truth.linear, cv::NORM_INF), 0) << after;
    }
    ++tried;
    const auto again = std::chrono::steady_clock::now();
    const Rendering picture = starved.Render(camera, pose);
    longest_s = std::max(longest_s, SecondsSince(again));
    const bool same = cv::norm(picture.linear, truth.linear, cv::NORM_INF) == 0;
    EXPECT_TRUE(same) << after << ": the same renderer, when there is room";
    lost += !same;
  }
  PrintFaultRow("graphics memory full while photographs are loaded, then room again", tried,
                fmt::format("the picture that was asked for; {} of those after it", lost), longest_s);
}

}  // namespace
}  // namespace ulf::test::gl_memory
