// Tests: core/light_field/points/point_tracks, core/light_field/points/point_io,
// core/light_field/formats/colmap_text, core/geometry/digest, core/geometry/byte_stream.
//
// Points and what views show of them: put where the poses have them, kept beside the positions, never older
// than the poses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::point_tracks_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::ScratchFolder;
using test::TrackedLightField;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::size_t Observations(const LightField& light_field) {
  return StatisticsOf(light_field.points).observations;
}

TEST(PointFit, FindsThePlaceThroughEveryLens) {
  for (const CameraModel& camera : {test::Straight(), test::Lens(), test::SixthOrder(), test::Fisheye()})
    for (const double noise_px : {0.0, 0.3}) {
      cv::RNG random(5);
      const Vector3d truth(0.2, -0.1, 3.1);
      std::vector<Rigid3> poses;
      for (int i = 0; i < 7; ++i) poses.push_back(LookAt({0.2 * i - 0.6, 0.1, 0}, {0, 0, 3}, {0, -1, 0}));
      std::vector<PosedObservation> observations;
      for (const Rigid3& pose : poses)
        observations.push_back({&camera, &pose,
                                *camera.ImgFromCam(pose * truth) +
                                    Vector2d(random.gaussian(noise_px), random.gaussian(noise_px))});
      const auto found = FitPoint(observations);
      ASSERT_TRUE(found);
      EXPECT_LT((*found - truth).norm(), 1e-7 + 0.1 * noise_px) << noise_px;
      // One that is wrong draws less than those that agree.
      observations[3].in_img += Vector2d(15, 0);
      EXPECT_LT((*FitPoint(observations) - truth).norm(), 0.1 + 0.2 * noise_px) << noise_px;
    }
}

TEST(PointFit, RaysThatMeetNowhereAreNoPoint) {
  const CameraModel camera = test::Straight();
  const Rigid3 here, there{Eigen::Quaterniond::Identity(), {-0.5, 0, 0}};
  EXPECT_FALSE(FitPoint(std::vector<PosedObservation>{{&camera, &here, {48, 32}}}));
  EXPECT_FALSE(
      FitPoint(std::vector<PosedObservation>{{&camera, &here, {48, 32}}, {&camera, &here, {48, 32}}}));
  // Behind both.
  EXPECT_FALSE(
      FitPoint(std::vector<PosedObservation>{{&camera, &here, {48, 32}}, {&camera, &there, {60, 32}}}));
  EXPECT_TRUE(
      FitPoint(std::vector<PosedObservation>{{&camera, &here, {48, 32}}, {&camera, &there, {36, 32}}}));
}

TEST(Points, ComeBackWithTheirTracksAndErrors) {
  ScratchFolder scratch;
  const LightField written = TrackedLightField(scratch / "lf", {test::Straight(), test::Lens()});
  ASSERT_GT(Observations(written), 200u);
  const LightField read = ReadLightField(scratch / "lf");
  EXPECT_THAT(read.doubts, IsEmpty());
  ASSERT_EQ(read.points.size(), written.points.size());
  for (std::size_t i = 0; i < read.points.size(); ++i) {
    const ScenePoint &a = read.points[i], &b = written.points[i];
    EXPECT_EQ(a.position_in_world, b.position_in_world);
    EXPECT_EQ(a.rgb, b.rgb);
    ASSERT_EQ(a.track.size(), b.track.size());
    for (std::size_t k = 0; k < a.track.size(); ++k) {
      EXPECT_EQ(a.track[k].view_id, b.track[k].view_id);
      EXPECT_LT((a.track[k].in_img - b.track[k].in_img).norm(), 1e-4);
    }
    EXPECT_LT(a.error_px, 1e-4);
  }
}

TEST(Points, StandInColmapsTextWithNoEmptyLine) {
  ScratchFolder scratch;
  LightField written = TrackedLightField(scratch / "lf", {test::Straight()});
  // A view that shows nothing and a point that nothing shows.
  View blind = written.views.back();
  blind.id = 99;
  blind.image_path = "images/000099.png";
  fs::copy_file(scratch / "lf" / written.views.back().image_path, scratch / "lf" / blind.image_path);
  written.views.push_back(blind);
  written.points.push_back({{5, 5, 5}, {1, 2, 3}});
  WriteLightField(written);
  const test::ColmapRead model = test::ReadAsColmap(scratch / "lf/sparse/0");
  EXPECT_EQ(model.images.size(), written.views.size());
  EXPECT_EQ(model.points.size(), written.points.size() - 1);
  EXPECT_EQ(model.Observations(), Observations(written));
  EXPECT_THAT(model.images.at(99).point_ids, ElementsAre(-1));
  EXPECT_NO_THROW(test::ReadAsSceneManager(scratch / "lf"));
}

// The journal's poses win: points follow them, however they came to change.
TEST(Points, FollowPosesThatChangeAfterThem) {
  ScratchFolder scratch;
  const LightField written = TrackedLightField(scratch / "lf", {test::Straight(), test::Lens()});
  const Rigid3 moved_from_world{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())),
                                {4, -2, 1}};
  std::map<int, Rigid3> moved;
  for (const View& view : written.views) moved[view.id] = view.cam_from_world * moved_from_world.Inverse();
  const auto expect_moved = [&](const LightField& light_field, const char* when) {
    ASSERT_EQ(light_field.points.size(), written.points.size()) << when;
    for (std::size_t i = 0; i < written.points.size(); ++i) {
      EXPECT_LT(
          (light_field.points[i].position_in_world - moved_from_world * written.points[i].position_in_world)
              .norm(),
          1e-4)
          << when;
      EXPECT_LT(light_field.points[i].error_px, 1e-3) << when;
    }
  };
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    writer.UpdatePoses(moved);
  }  // killed: points.ulf is of the poses before
  expect_moved(ReadLightField(scratch / "lf"), "after a kill");
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    expect_moved(writer.Contents(), "resumed");
    std::map<int, Rigid3> back;
    for (const View& view : written.views) back[view.id] = view.cam_from_world;
    writer.UpdatePoses(back);
    writer.UpdatePoses(moved);
    writer.Close(1);
  }
  expect_moved(ReadLightField(scratch / "lf"), "closed");
  const test::ColmapRead model = test::ReadAsColmap(scratch / "lf/sparse/0");
  EXPECT_LT((model.points.at(1).position - moved_from_world * written.points[0].position_in_world).norm(),
            1e-4);
}

TEST(Points, KnowThatAViewWasTakenBack) {
  ScratchFolder scratch;
  const LightField written = TrackedLightField(scratch / "lf", {test::Straight()});
  const int gone = written.views[2].id;
  {
    LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
    writer.RemoveViews({gone});
  }
  for (const bool closed : {false, true}) {
    const LightField read = ReadLightField(scratch / "lf");
    EXPECT_GT(Observations(read), 0u);
    EXPECT_LT(Observations(read), Observations(written));
    for (const ScenePoint& point : read.points)
      for (const ViewObservation& seen : point.track) EXPECT_NE(seen.view_id, gone);
    if (!closed) LightFieldWriter::Resume(scratch / "lf").Close(1);
  }
  EXPECT_FALSE(test::ReadAsColmap(scratch / "lf/sparse/0").images.contains(gone));
}

TEST(Points, WithoutTheirFileAreStillPoints) {
  ScratchFolder scratch;
  const LightField written = TrackedLightField(scratch / "lf", {test::Straight()});
  const fs::path file = scratch / "lf/points.ulf";
  const std::string whole = ReadWholeFile(file);
  const auto read_with = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
    return ReadLightField(scratch / "lf");
  };
  for (const std::string& bytes : {std::string(), std::string("{}"), whole.substr(0, whole.size() / 2), [&] {
                                     std::string other = whole;
                                     other[whole.size() / 3] ^= 4;
                                     return other;
                                   }()}) {
    const LightField read = read_with(bytes);
    EXPECT_EQ(read.points.size(), written.points.size());
    EXPECT_EQ(Observations(read), 0u);
    ASSERT_EQ(read.doubts.size(), 1u);
    EXPECT_THAT(read.doubts[0], HasSubstr("points.ulf"));
  }
  fs::remove(file);
  const LightField without = ReadLightField(scratch / "lf");
  EXPECT_EQ(without.points.size(), written.points.size());
  EXPECT_THAT(without.doubts, IsEmpty()) << "as older programs left it";
  // Two that disagree.
  std::ofstream(file, std::ios::binary) << whole;
  std::ofstream(scratch / "lf/points.ply", std::ios::app) << "more";
  const LightField both = ReadLightField(scratch / "lf");
  EXPECT_EQ(Observations(both), Observations(written));
  ASSERT_EQ(both.doubts.size(), 1u);
  EXPECT_THAT(both.doubts[0], HasSubstr("points.ply"));
  fs::remove(file);
  fs::resize_file(scratch / "lf/points.ply", fs::file_size(scratch / "lf/points.ply") / 2);
  const LightField neither = ReadLightField(scratch / "lf");
  EXPECT_TRUE(neither.points.empty());
  ASSERT_EQ(neither.doubts.size(), 1u);
  EXPECT_THAT(neither.doubts[0], HasSubstr("without points"));
}

TEST(Points, DamageWithAValidChecksumDoesNoHarm) {
  ScratchFolder scratch;
  const LightField written = TrackedLightField(scratch / "lf", {test::Straight()}, 4);
  const std::string whole = PointFileBytes(written);
  cv::RNG random(8);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = whole.substr(0, whole.size() - 8);
    for (int k = 0; k < 3; ++k)
      damaged[static_cast<std::size_t>(random.uniform(8, static_cast<int>(damaged.size())))] =
          static_cast<char>(random.uniform(0, 256));
    const std::uint64_t sum = ChecksumOf(damaged);
    damaged.append(reinterpret_cast<const char*>(&sum), sizeof sum);
    refused += !PointsFromBytes(damaged, written).problem.empty();
  }
  EXPECT_GT(refused, 0);
  EXPECT_EQ(PointsFromBytes(whole, written).problem, "");
}

}  // namespace
}  // namespace ulf::point_tracks_test
