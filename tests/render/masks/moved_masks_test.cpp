// Tests: render/masks/moved_masks, commands/rendering/mask_command, commands/reports/work_reports.
#include "render/masks/moved_masks.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/drawn_hand.h"
#include "tests/support/test_paths.h"

namespace ulf::moved_masks_test {
namespace {

namespace fs = std::filesystem;
using test::HandLook;
using testing::HasSubstr;
using testing::IsEmpty;

struct Hand {
  double share = 0;
  HandLook look = HandLook::kSkin;
  unsigned seed = 1;
};

// Twelve views of a plane with a square before it, with hands (by index), the mesh, and exposures that
// differ. Returns the hands' true places by View::id.
std::map<int, cv::Mat> WriteViews(const fs::path& dir, const std::map<int, Hand>& hands, int shadowed = -1) {
  const CameraModel camera = CameraModel::Pinhole(320, 240, 270);
  CaptureHeader header;
  header.camera = camera;
  std::map<int, cv::Mat> truth;
  auto writer = LightFieldWriter::Create(dir, header);
  const auto viewpoints = test::CapViewpoints(12, 0.3, 1.5, 0.05, 3);
  for (int i = 0; i < static_cast<int>(viewpoints.size()); ++i) {
    View view;
    view.cam_from_world =
        LookAt(viewpoints[static_cast<std::size_t>(i)], Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY());
    cv::Mat pixels = test::PhotographOfPlane(camera, view.cam_from_world, true);
    pixels.convertTo(pixels, -1, 0.7 + 0.05 * (i % 5));
    if (i == shadowed) {
      cv::Mat half = pixels(cv::Rect(0, 0, 150, 240));
      half.convertTo(half, -1, 0.5);
    }
    cv::Mat hidden;
    if (const auto hand = hands.find(i); hand != hands.end())
      hidden = test::DrawHand(pixels, hand->second.share, hand->second.look, hand->second.seed);
    Frame frame;
    frame.image = {.pixels = pixels, .transfer = Transfer::kSrgb};
    frame.id = static_cast<std::uint64_t>(i);
    view = writer.AddView(frame, view);
    if (!hidden.empty()) truth[view.id] = hidden;
  }
  writer.SetSubject({Eigen::Vector3d::Zero(), 0.3});
  writer.Close(1);
  render::WriteMeshPly(dir / render::kMeshProxyFile, *test::PlaneAndSquare());
  return truth;
}

double Overlap(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero(a & b)) / std::max(1, cv::countNonZero(a | b));
}

TEST(MovedMasks, FitTheHandsThatWereDrawn) {
  const test::ScratchFolder scratch;
  const fs::path dir = scratch / "field";
  const auto truth = WriteViews(dir, {{2, {0.25, HandLook::kSkin, 2}},
                                      {5, {0.5, HandLook::kTextured, 4}},
                                      {8, {0.75, HandLook::kPlain, 6}}});
  const MovedMasks found = MakeMovedMasks(ReadLightField(dir), *test::PlaneAndSquare());
  EXPECT_EQ(found.masks.size(), truth.size());
  for (const auto& [id, hidden] : truth) {
    ASSERT_TRUE(found.masks.contains(id)) << "view " << id;
    const double overlap = Overlap(found.masks.at(id) == 0, hidden);
    fmt::print("view {}: intersection over union {:.3f}\n", id, overlap);
    EXPECT_GT(overlap, 0.85) << "view " << id;
  }
}

TEST(MovedMasks, LeaveASetAloneInWhichNothingMoved) {
  const test::ScratchFolder scratch;
  WriteViews(scratch / "field", {}, 4);
  const MovedMasks found = MakeMovedMasks(ReadLightField(scratch / "field"), *test::PlaneAndSquare());
  EXPECT_THAT(found.masks, IsEmpty()) << "a shadow and other exposures are no hand";
  EXPECT_GT(found.judged_share, 0.7);
}

TEST(MovedMasks, AreWrittenAndLeaveWithExports) {
  const test::ScratchFolder scratch;
  const fs::path dir = scratch / "field";
  const cv::Mat hidden = WriteViews(dir, {{3, {0.4, HandLook::kTextured, 8}}}).at(4);
  const test::CommandResult told = test::RunUlf("mask " + dir.string() + " --moved");
  ASSERT_EQ(told.exit_code, 0) << told.errors;
  EXPECT_THAT(told.output, HasSubstr("1 of 12 views masked"));
  EXPECT_THAT(told.output, HasSubstr("images/000004.png: "));
  const fs::path out = scratch / "colmap";
  const test::CommandResult exported =
      test::RunUlf("export colmap " + dir.string() + " -o " + out.string() + " --known-points");
  ASSERT_EQ(exported.exit_code, 0) << exported.errors;
  const cv::Mat mask = cv::imread((out / "masks/000004.png.png").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(mask.empty());
  EXPECT_GT(Overlap(mask == 0, hidden), 0.85);
}

TEST(MovedMasks, NeedAMesh) {
  const test::ScratchFolder scratch;
  const fs::path dir = scratch / "field";
  WriteViews(dir, {});
  fs::remove(dir / render::kMeshProxyFile);
  const test::CommandResult told = test::RunUlf("mask " + dir.string() + " --moved");
  EXPECT_EQ(told.exit_code, 1);
  EXPECT_THAT(told.errors, HasSubstr("ulf proxy"));
}

}  // namespace
}  // namespace ulf::moved_masks_test
