// Tests: core/light_field/exchange/export_light_field, core/light_field/exchange/import_light_field,
// core/light_field/formats/posed_set.
//
// What we write for others, imported again as a light field: poses, lenses, names, masks and points are the
// source's, for every form that import reads and every kind of lens that the form has.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/geometry/similarity3.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/exchange/writers/set_writers.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::round_trip_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using test::ScratchFolder;

struct Form {
  ExportForm form;
  const char* name;
  bool has_sixth_order, has_fisheyes, mixes_kinds;  // without undistortion
  bool keeps_points;
};
constexpr Form kForms[] = {
    {ExportForm::kColmapText, "colmap_text", true, true, true, true},
    {ExportForm::kColmapBinary, "colmap_binary", true, true, true, true},
    {ExportForm::kNerfstudio, "nerfstudio", true, true, false, true},
    {ExportForm::kInstantNgp, "instant_ngp", false, true, true, false},
    {ExportForm::kRealityScan, "realityscan", true, false, true, false},
    {ExportForm::kMetashape, "metashape", true, true, true, true},
};

// Held upright among landscape, with a principal point far off the middle.
CameraModel Upright() { return {64, 96, 90, 91, 27.4, 51.7}; }

std::vector<CameraModel> LensesOf(const Form& form, bool undistort) {
  std::vector<CameraModel> lenses{test::Straight(), test::Lens(), Upright()};
  if (undistort || form.has_sixth_order) lenses.push_back(test::SixthOrder());
  if (undistort || (form.has_fisheyes && form.mixes_kinds)) lenses.push_back(test::Fisheye());
  return lenses;
}

std::string StemOf(const View& view) { return fs::path(view.image_path).stem().string(); }

const View& ViewOfName(const LightField& light_field, const View& view) {
  const auto found =
      std::ranges::find_if(light_field.views, [&](const View& one) { return StemOf(one) == StemOf(view); });
  if (found == light_field.views.end()) throw std::runtime_error(view.image_path + " did not come back");
  return *found;
}

// All pixels are used where there is no mask.
cv::Mat UsedPixels(const LightField& light_field, const View& view) {
  const cv::Mat mask = ReadViewMask(light_field, view);
  const CameraModel& camera = light_field.CameraOf(view);
  return mask.empty() ? cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(255)) : cv::Mat(mask > 0);
}

void ExpectSameViews(const LightField& source, const LightField& back,
                     const std::vector<CameraModel>& lenses) {
  ASSERT_EQ(back.views.size(), source.views.size());
  for (const View& view : source.views) {
    const View& read = ViewOfName(back, view);
    EXPECT_LT((read.cam_from_world.Matrix() - view.cam_from_world.Matrix()).norm(), 1e-9) << read.image_path;
    const CameraModel &lens = lenses[static_cast<std::size_t>(view.camera)], &read_lens = back.CameraOf(read);
    EXPECT_EQ(read_lens.width, lens.width);
    EXPECT_EQ(read_lens.height, lens.height);
    for (const Vector3d& ray : {Vector3d(0.2, 0.1, 1), Vector3d(-0.3, 0.15, 1), Vector3d(0.1, -0.2, 1)})
      EXPECT_LT((*read_lens.ImgFromCam(ray) - *lens.ImgFromCam(ray)).norm(), 1e-6) << read.image_path;
  }
}

void ExpectSameMasks(const LightField& source, const LightField& back) {
  for (const View& view : source.views) {
    const cv::Mat wanted = UsedPixels(source, view), read = UsedPixels(back, ViewOfName(back, view));
    ASSERT_EQ(read.size(), wanted.size());
    EXPECT_EQ(cv::countNonZero(read != wanted), 0) << view.image_path;
  }
}

void ExpectSamePoints(const LightField& source, const LightField& back) {
  ASSERT_EQ(back.points.size(), source.points.size());
  for (std::size_t i = 0; i < source.points.size(); ++i)
    EXPECT_LT((back.points[i].position_in_world - source.points[i].position_in_world).norm(), 1e-6);
}

LightField BackOf(const LightField& source, const Form& form, bool undistort, const fs::path& scratch) {
  const fs::path out = scratch / fmt::format("{}_{}", form.name, undistort);
  ExportLightField(source, out, {.form = form.form, .undistort = undistort});
  const fs::path again = out.string() + "_again";
  Import(out, again, {.subject = source.subject});
  return ReadLightField(again);
}

TEST(RoundTrip, EveryFormGivesItsLightFieldBack) {
  const ScratchFolder scratch;
  for (const Form& form : kForms) {
    SCOPED_TRACE(form.name);
    const LightField source =
        test::TrackedLightField(scratch / fmt::format("of_{}", form.name), LensesOf(form, false), 10, true);
    const LightField back = BackOf(source, form, false, scratch.path());
    ExpectSameViews(source, back, source.cameras);
    ExpectSameMasks(source, back);
    if (form.keeps_points) ExpectSamePoints(source, back);
    if (!form.has_fisheyes || form.mixes_kinds) continue;
    const LightField fisheyes = test::TrackedLightField(scratch / fmt::format("fisheyes_of_{}", form.name),
                                                        {test::Fisheye()}, 4, true);
    Form alone = form;
    alone.name = "fisheyes_alone";
    const LightField fisheyes_back = BackOf(fisheyes, alone, false, scratch.path());
    ExpectSameViews(fisheyes, fisheyes_back, fisheyes.cameras);
    ExpectSameMasks(fisheyes, fisheyes_back);
  }
}

TEST(RoundTrip, UndistortedFormsComeBackAsPinholes) {
  const ScratchFolder scratch;
  const LightField source = test::TrackedLightField(scratch / "lf", LensesOf(kForms[0], true), 10, true);
  std::vector<CameraModel> lenses;
  for (const CameraModel& camera : source.cameras) lenses.push_back(UndistortionOf(camera, "a camera").to);
  const auto masked = [](const LightField& light_field) {
    return std::ranges::count_if(light_field.views, [](const View& view) { return !view.mask_path.empty(); });
  };
  for (const Form& form : kForms) {
    SCOPED_TRACE(form.name);
    const LightField back = BackOf(source, form, true, scratch.path());
    ExpectSameViews(source, back, lenses);
    EXPECT_EQ(masked(back), masked(source));
    if (form.keeps_points) ExpectSamePoints(source, back);
  }
}

// Reads nerf-synthetic back, whose world is moved, turned and scaled, with the subject in it.
LightField BackOfNerfSynthetic(const LightField& source, const fs::path& out) {
  ExportLightField(source, out, {.form = ExportForm::kNerfSynthetic});
  const Similarity3 nerf_from_world = NerfFromWorld(source, *source.subject);
  const Subject subject{nerf_from_world * source.subject->center_in_world,
                        nerf_from_world.scale * source.subject->radius};
  const fs::path again = out.string() + "_again";
  Import(out, again, {.subject = subject});
  return ReadLightField(again);
}

// Expects the centres and the directions of the source's cameras, moved alike.
void ExpectMovedPoses(const LightField& source, const LightField& back) {
  ASSERT_EQ(back.views.size(), source.views.size());
  std::vector<Vector3d> centers, moved_centers;
  for (const View& view : source.views) {
    centers.push_back(view.CenterInWorld());
    moved_centers.push_back(ViewOfName(back, view).CenterInWorld());
  }
  const auto moved = AlignPoints(centers, moved_centers);
  ASSERT_TRUE(moved);
  for (const View& view : source.views) {
    const View& read = ViewOfName(back, view);
    EXPECT_LT((*moved * view.CenterInWorld() - read.CenterInWorld()).norm(), 1e-9) << read.image_path;
    EXPECT_LT((read.cam_from_world.RotationMatrix() * moved->rotation - view.cam_from_world.RotationMatrix())
                  .norm(),
              1e-9)
        << read.image_path;
  }
}

TEST(RoundTrip, NerfSyntheticReturnsPosesInItsWorld) {
  const ScratchFolder scratch;
  const LightField source = test::TrackedLightField(scratch / "lf", {test::Straight()}, 10, true);
  const LightField back = BackOfNerfSynthetic(source, scratch / "nerf");
  ExpectMovedPoses(source, back);
  ASSERT_EQ(back.cameras.size(), 1u);
  const CameraModel &wanted = source.cameras[0], &lens = back.cameras[0];
  EXPECT_EQ(lens.width, wanted.width);
  EXPECT_EQ(lens.height, wanted.height);
  for (const Vector3d& ray : {Vector3d(0.2, 0.1, 1), Vector3d(-0.3, 0.15, 1), Vector3d(0.1, -0.2, 1)})
    EXPECT_LT((*lens.ImgFromCam(ray) - *wanted.ImgFromCam(ray)).norm(), 1e-6);
  // What is masked is transparent, and laid over white as in the papers.
  for (const View& view : source.views) {
    cv::Mat wanted_pixels = ReadViewImage(source, view).pixels;
    wanted_pixels.setTo(cv::Scalar::all(255), UsedPixels(source, view) == 0);
    const cv::Mat read = ReadViewImage(back, ViewOfName(back, view)).pixels;
    EXPECT_EQ(cv::norm(wanted_pixels, read, cv::NORM_INF), 0) << view.image_path;
  }
}

TEST(RoundTrip, NerfSyntheticMakesOnePinholeOfAllLenses) {
  const ScratchFolder scratch;
  const LightField source = test::TrackedLightField(scratch / "lf", LensesOf(kForms[0], true), 10, true);
  const LightField back = BackOfNerfSynthetic(source, scratch / "nerf");
  ExpectMovedPoses(source, back);
  ASSERT_EQ(back.cameras.size(), 1u);
  EXPECT_EQ(back.cameras[0].distortion, Distortion::kNone);
  const CameraModel lens = UndistortionsToOne(source.cameras, std::vector<std::string>(5, "a camera"))[0].to;
  EXPECT_NEAR(back.cameras[0].fx, lens.fx, 1e-9);
  EXPECT_EQ(back.cameras[0].width, lens.width);
}

}  // namespace
}  // namespace ulf::round_trip_test
