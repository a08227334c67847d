// Tests: render/output/picture_files, render/output/tiled_rendering.
//
// The largest that `ulf render` takes, done to the end: a picture of 16384x16384 pixels, and a mesh of a
// million triangles. Time and memory are printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/available_memory.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/output/picture_files.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::large_long_test {
namespace {

class Large : public testing::Test {
 protected:
  void SetUp() override {
    test::WriteLightField(dir_, {.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0)}, true);
  }
  std::string Out(const std::string& name) const { return (scratch_ / name).string(); }

  // One picture from the first place of an orbit.
  cv::Mat Render(const std::string& options, const std::string& name) const {
    const auto start = std::chrono::steady_clock::now();
    const auto result = test::RunUlf("render " + dir_.string() + " --field subdivision --zoom 2 " + options +
                                     " -o " + Out(name));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    fmt::print("{}: {:.1f} s, at most {:.2f} GB so far\n", name, seconds, 1e-9 * PeakBytesOfChildren());
    return cv::imread(Out(name));
  }
  static double PeakBytesOfChildren() {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    return 1024.0 * static_cast<double>(usage.ru_maxrss);
  }

  test::ScratchFolder scratch_;
  std::filesystem::path dir_ = scratch_ / "lf";
};

TEST_F(Large, MeshOfAMillionTrianglesIsExported) {
  TriangleMesh mesh;  // the plane that was photographed, as far as anybody sees
  constexpr std::uint32_t kSide = 708;
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      mesh.vertices.emplace_back(8.0f * static_cast<float>(x) / (kSide - 1) - 4,
                                 8.0f * static_cast<float>(y) / (kSide - 1) - 4, 0.0f);
      if (x + 1 == kSide || y + 1 == kSide) continue;
      const std::uint32_t at = y * kSide + x;
      mesh.triangles.push_back({at, at + 1, at + kSide});
      mesh.triangles.push_back({at + 1, at + kSide + 1, at + kSide});
    }
  WriteMeshPly(scratch_ / "fine.ply", mesh);
  const cv::Mat fine = Render("--width 640 --proxy " + Out("fine.ply"), "fine.png");
  EXPECT_LT(PeakBytesOfChildren(), 1.5e9);
  const cv::Mat plane = Render("--width 640 --proxy plane:0,0,1,0", "plane.png");
  ASSERT_EQ(fine.size(), plane.size());
  EXPECT_GT(cv::PSNR(fine, plane), 40) << "the same surface";
}

TEST_F(Large, PictureOf16384SquaredIsRendered) {
  constexpr int kSide = 16384, kShown = 512;
  const std::uint64_t expected = MemoryForPicture(kSide, kSide, {});
  if (AvailableMemory() < expected)
    GTEST_SKIP() << "it takes " << 1e-9 * static_cast<double>(expected) << " GB";
  const auto sized = [](int side) {
    return "--proxy plane:0,0,1,0 --width " + std::to_string(side) + " --height " + std::to_string(side);
  };
  const cv::Mat small = Render(sized(kShown), "small.png");
  const cv::Mat large = Render(sized(kSide), "large.png");
  EXPECT_LT(PeakBytesOfChildren(), 1.1 * static_cast<double>(expected)) << "what is asked for beforehand";
  ASSERT_EQ(large.size(), cv::Size(kSide, kSide));
  cv::Mat shrunk;
  cv::resize(large, shrunk, small.size(), 0, 0, cv::INTER_AREA);
  EXPECT_GT(cv::PSNR(shrunk, small), 30);
  for (int seam = 4096; seam < kSide; seam += 4096) {
    EXPECT_LE(cv::norm(large.col(seam - 1), large.col(seam), cv::NORM_L1) / (3.0 * kSide), 2) << seam;
    EXPECT_LE(cv::norm(large.row(seam - 1), large.row(seam), cv::NORM_L1) / (3.0 * kSide), 2) << seam;
  }
}

}  // namespace
}  // namespace ulf::large_long_test
