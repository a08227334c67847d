// Tests: commands/tracking/refine_command, commands/tracking/refine_report,
// tracking/estimation/calibration_check, tracking/estimation/lens_evidence, tracking/refine/refine_input,
// tracking/refine/refine, tracking/refine/refine_result, tracking/refine/refine_truth,
// tracking/refine/track_building, tracking/refine/triangulate.
// Poses that are a little off come back, and what cannot be refined is named.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/tracker/tracker.h"

namespace ulf::refine_test {
namespace {

using test::After;
using test::Before;
using test::Disturbed;
using test::ErrorsOf;
using test::MakeViews;
using test::PoseErrors;
using test::RoomViews;
using test::TexturedRoom;
using test::Way;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Fewer corners than RefineRoom() takes: their matching is the time, and these tell what is asked.
constexpr int kFeatures = 500;

RefineResult RefineBriefly(const RoomViews& views, bool intrinsics = false) {
  RefineOptions options;
  options.features = kFeatures;
  options.intrinsics = intrinsics;
  return Refine(views.input, options);
}

TEST(Refine, PosesThatAreALittleOffComeBack) {
  for (const unsigned seed : {1u}) {
    const auto views = MakeViews(14, 0.01, 0.1, seed);
    const RefineResult result = RefineBriefly(*views);
    EXPECT_EQ(result.registered, 14);
    const PoseErrors before = Before(*views), after = After(*views, result);
    EXPECT_LT(after.center, 0.25 * before.center) << "seed " << seed;
    EXPECT_LT(after.center, 0.002) << "seed " << seed;
    EXPECT_LT(result.median_after_px, 0.25);
    EXPECT_LT(result.rms_after_px, 0.2 * result.rms_before_px);
    EXPECT_GT(result.points.size(), 500u);
    // Nothing that the pictures cannot tell has moved: scale, place and direction are the start's.
    EXPECT_LT(result.moved_median, 0.02);
    EXPECT_LT(result.moved_max, 0.05);
    // The median of what is predicted, the mean of what is true: about the same.
    ASSERT_TRUE(result.center_sigma_median && result.center_sigma_max);
    EXPECT_GT(*result.center_sigma_median, after.center / 4);
    EXPECT_LT(*result.center_sigma_median, after.center * 4);
    EXPECT_GE(*result.center_sigma_max, *result.center_sigma_median);
  }
}

// Reduced for refining, pictures keep their own pixels in what is told.
TEST(Refine, ErrorsAreInThePicturesOwnPixels) {
  const auto views = MakeViews(8, 0.01, 0.1, 1);
  const auto refine = [&](int max_side_px) {
    RefineOptions options;
    options.features = kFeatures;
    options.max_side_px = max_side_px;
    return Refine(views->input, options);
  };
  const RefineResult whole = refine(640), reduced = refine(320);
  EXPECT_NEAR(reduced.rms_before_px / whole.rms_before_px, 1, 0.25);
  EXPECT_NEAR(reduced.start_error_px / whole.start_error_px, 1, 0.35);
  EXPECT_GT(reduced.median_after_px, 0.9 * whole.median_after_px) << "no better than of the whole pictures";
}

TEST(Refine, PosesOffByAPercentAndADegreeComeBack) {
  const auto views = MakeViews(16, 0.03, 1, 3);
  const RefineResult result = RefineBriefly(*views);
  EXPECT_EQ(result.registered, 16);
  EXPECT_GT(result.start_error_px, 2.5);
  EXPECT_LT(After(*views, result).center, 0.002);
  EXPECT_LT(After(*views, result).rotation_deg, 0.05);
}

// Points that slide along an outline go, those that are merely measured badly in one view stay.
TEST(Refine, PointsThatSlideAreDropped) {
  RefineScene scene;
  scene.lenses = {TexturedRoom::Camera()};
  test::Draw draw(2);
  for (int v = 0; v < 8; ++v) {
    RefineView& view = scene.views.emplace_back();
    view.cam_from_world = LookAt({0.1 * v - 0.35, 0, 0}, {0, 0, 3}, -Eigen::Vector3d::UnitY());
  }
  for (int t = 0; t < 200; ++t) {
    SceneTrack& track = scene.tracks.emplace_back();
    track.position = {draw.Uniform(-0.8, 0.8), draw.Uniform(-0.6, 0.6), draw.Uniform(2.5, 3.5)};
    for (int v = 0; v < 8; ++v) {
      TrackObservation& o = track.observations.emplace_back();
      o.view = v;
      o.sigma_px = 0.4;
      o.img = *scene.lenses[0].ImgFromCam(scene.view(v).cam_from_world * track.position) +
              Eigen::Vector2d(draw.Normal(0.1), draw.Normal(0.1));
      if (t % 10 == 0) o.img.x() += 0.3 * (v - 3.5);
      if (t % 10 == 1 && v == 4) o.img.x() += 5;
    }
    track.rgb[0] = t % 10;
  }
  DropSlidingPoints(scene);
  EXPECT_EQ(scene.tracks.size(), 180u);
  for (const SceneTrack& track : scene.tracks) EXPECT_NE(track.rgb[0], 0);
}

TEST(Refine, TheNumberOfThreadsChangesNothing) {
  const auto views = MakeViews(10, 0.01, 0.1, 4);
  std::vector<RefineResult> results;
  const int threads_before = cv::getNumThreads();
  for (const int threads : {1, 3}) {
    cv::setNumThreads(threads);
    results.push_back(RefineBriefly(*views));
  }
  cv::setNumThreads(threads_before);
  ASSERT_EQ(results[0].points.size(), results[1].points.size());
  for (std::size_t v = 0; v < results[0].views.size(); ++v)
    EXPECT_EQ(results[0].views[v].cam_from_world.Matrix(), results[1].views[v].cam_from_world.Matrix());
}

TEST(Refine, NamesUnreadableAndForeignViews) {
  const auto views = MakeViews(12, 0.01, 0.1, 5);
  const TexturedRoom other({.seed = 77});
  views->images[7] = other.Take(views->truth[7], 7).image;
  const auto read = views->input.read;
  views->input.read = [&](int i) {
    if (i == 3) throw Error("images/3.png: is truncated");
    return read(i);
  };
  const RefineResult result = RefineBriefly(*views);
  EXPECT_EQ(result.registered, 10);
  EXPECT_FALSE(result.views[3].registered);
  EXPECT_THAT(result.views[3].why, HasSubstr("truncated"));
  EXPECT_FALSE(result.views[7].registered);
  EXPECT_THAT(result.views[7].why, HasSubstr("points"));
  for (const std::size_t v : {3u, 7u})
    EXPECT_EQ(result.views[v].cam_from_world.Matrix(), views->input.views[v].cam_from_world.Matrix());
}

// A view whose pose is of another place altogether is found again by what it shows.
TEST(Refine, AViewThatIsFarOffIsFoundAgain) {
  const auto views = MakeViews(12, 0.005, 0.05, 6);
  test::Draw draw(6);
  views->input.views[5].cam_from_world = Disturbed(views->truth[5], 0.15, 6, draw);
  const RefineResult result = RefineBriefly(*views);
  EXPECT_EQ(result.registered, 12);
  EXPECT_EQ(result.moved_most, 5);
  EXPECT_LT(After(*views, result).center, 0.004);
}

TEST(Refine, TwoViewsAreEnough) {
  const auto views = MakeViews(2, 0, 0.2, 7);
  const RefineResult result = RefineBriefly(*views);
  EXPECT_EQ(result.registered, 2);
  EXPECT_LT(result.median_after_px, 0.4);
}

void ExpectRefused(const test::RoomViews& views, const char* why) {
  EXPECT_THAT([&] { RefineBriefly(views); }, testing::ThrowsMessage<Error>(HasSubstr(why)))
      << "refined, though " << why;
}

TEST(Refine, ViewsFromOnePlaceAreRefused) {
  ExpectRefused(*MakeViews(10, 0.0005, 0.1, 8, Way::kTurning), "turning about one place");
}

TEST(Refine, OneReadableViewIsRefused) {
  const auto views = MakeViews(3, 0, 0, 9);
  const auto read = views->input.read;
  views->input.read = [&](int i) {
    if (i > 0) throw Error("view {}: is gone", i);
    return read(i);
  };
  ExpectRefused(*views, "is gone");
}

TEST(CalibrationCheck, ReportsAFivePercentFocalError) {
  for (const double factor : {0.95, 1.05}) {
    const auto views = MakeViews(12, 0, 0, 10);
    CameraModel& lens = views->input.lenses[0];
    const double truth_px = lens.fx;
    lens.fx *= factor;
    lens.fy *= factor;
    const RefineResult told = RefineBriefly(*views);
    ASSERT_EQ(told.checks.size(), 1u);
    EXPECT_TRUE(told.checks[0].Wrong()) << factor;
    EXPECT_NEAR(told.checks[0].fitted_focal_px, truth_px, 0.01 * truth_px);
    EXPECT_THAT(told.checks[0].Text(), HasSubstr(factor > 1 ? "or less" : "or more"));
    EXPECT_EQ(told.lenses, views->input.lenses) << "changed without being asked";
    ASSERT_EQ(told.lens_fits.size(), 1u);
    // The focal length is what was wrong, and what is freed; the principal point was right.
    ASSERT_EQ(told.lens_trials.size(), 1u);
    const std::vector<LensTrial>& trials = told.lens_trials[0];
    ASSERT_EQ(trials.size(), 4u);
    EXPECT_TRUE(trials[0].fit.free.focal && trials[0].kept && trials[0].moved);
    EXPECT_GT(trials[0].fit.gain, 0);
    EXPECT_TRUE(trials[2].fit.free.principal_point);
    EXPECT_FALSE(trials[2].kept) << trials[2].fit.gain << " after " << trials[2].gain_before;

    if (factor > 1) continue;
    const RefineResult taken = RefineBriefly(*views, true);
    EXPECT_NEAR(taken.lenses[0].fx, truth_px, 0.005 * truth_px);
    EXPECT_LT(After(*views, taken).center, 0.5 * After(*views, told).center + 1e-3);
  }
}

// Poses that were adjusted under the wrong lens, as a tracker's are: matches and poses speak for it until
// both are taken anew.
TEST(RefinedLens, IsReachedFromFarAndKnowsHowSureItIs) {
  const auto views = MakeViews(20, 0, 0, 10);
  CameraModel& lens = views->input.lenses[0];
  const double truth_px = lens.fx;
  const double by_right_lens = After(*views, test::RefineRoom(*views)).center;
  lens.fx *= 1.15;
  lens.fy *= 1.15;
  const RefineResult wrong = test::RefineRoom(*views);
  for (std::size_t v = 0; v < wrong.views.size(); ++v)
    views->input.views[v].cam_from_world = wrong.views[v].cam_from_world;
  const RefineResult taken = test::RefineRoom(*views, true);
  ASSERT_EQ(taken.lens_fits.size(), 1u);
  EXPECT_TRUE(taken.settled);
  EXPECT_NEAR(taken.lenses[0].fx, truth_px, 0.002 * truth_px);
  EXPECT_NEAR(taken.lenses[0].fx, truth_px, 4 * taken.lens_fits.at(0).focal_sigma_px);
  EXPECT_LT(After(*views, taken).center, 1.5 * by_right_lens + 1e-4);
}

// Runs as RefineBriefly(*, true) does; `at_pass` hears the number of each pass when its lens is weighed.
RefineResult RefineByPasses(const RoomViews& views, bool intrinsics,
                            const std::function<void(int)>& at_pass) {
  RefineOptions options;
  options.features = kFeatures;
  options.intrinsics = intrinsics;
  options.progress = [&, pass = 0](double, const std::string& stage) mutable {
    if (stage == "weighing the lens") at_pass(++pass);
  };
  return Refine(views.input, options);
}

TEST(RefinedLens, KeepsTheLastResultWhenAPassFails) {
  const auto views = MakeViews(12, 0, 0, 10);
  views->input.lenses[0].fx *= 1.05;
  views->input.lenses[0].fy *= 1.05;
  int passes = 0;
  const RefineResult kept = RefineByPasses(*views, true, [&](int pass) {
    passes = pass;
    if (pass == 2) throw Error("the second pass fails");
  });
  EXPECT_EQ(passes, 2);
  EXPECT_EQ(kept.registered, 12);
  EXPECT_FALSE(kept.settled) << "the lens was not seen to stay";
  EXPECT_NEAR(kept.lenses[0].fx, 520, 0.01 * 520);
  EXPECT_LT(After(*views, kept).center, 0.002);
}

TEST(RefinedLens, OnePassIsEnoughWhereTheLensStays) {
  for (const bool intrinsics : {false, true}) {
    const auto views = MakeViews(12, 0, 0, 10);
    if (!intrinsics) views->input.lenses[0].fx *= 1.05;
    int passes = 0;
    const RefineResult result = RefineByPasses(*views, intrinsics, [&](int pass) { passes = pass; });
    EXPECT_EQ(passes, 1) << intrinsics;
    EXPECT_TRUE(result.settled) << intrinsics;
  }
}

// Views that would tell, of a lens that is right: nothing is freed, nothing proposed, and asked to take over
// what the pictures say it stays as it is.
TEST(CalibrationCheck, RightIntrinsicsAreLeftAlone) {
  for (const unsigned seed : test::SeedsOf({10, 16, 17})) {
    const auto views = MakeViews(12, 0, 0, seed);
    const RefineResult result = RefineBriefly(*views, true);
    ASSERT_EQ(result.checks.size(), 1u);
    EXPECT_TRUE(result.checks[0].determined) << "seed " << seed;
    EXPECT_FALSE(result.checks[0].Wrong()) << result.checks[0].Text();
    EXPECT_TRUE(result.lens_fits.empty()) << "seed " << seed;
    EXPECT_EQ(result.lenses, views->input.lenses) << "seed " << seed;
    ASSERT_EQ(result.lens_trials.at(0).size(), 4u);
    for (const LensTrial& trial : result.lens_trials[0]) EXPECT_FALSE(trial.kept) << "seed " << seed;
  }
}

// A wall seen while moving past it fits many focal lengths.
TEST(CalibrationCheck, IsSilentOnUninformativeGeometry) {
  const auto views = MakeViews(14, 0, 0, 11, Way::kSideways, false);
  views->input.lenses[0].fx *= 1.05;
  views->input.lenses[0].fy *= 1.05;
  const RefineResult result = RefineBriefly(*views);
  ASSERT_EQ(result.checks.size(), 1u);
  EXPECT_FALSE(result.checks[0].determined);
  EXPECT_FALSE(result.checks[0].Wrong()) << result.checks[0].Text();
  EXPECT_TRUE(result.lens_fits.empty());
  for (const LensTrial& trial : result.lens_trials.at(0)) EXPECT_FALSE(trial.kept);
}

TEST(CalibrationCheck, TrackerNoticesAWrongFocalLength) {
  for (const double factor : {1.0, 1.05}) {
    const TexturedRoom room({.seed = 15});
    CameraModel given = TexturedRoom::Camera();
    given.fx *= factor;
    given.fy *= factor;
    Tracker tracker(given, {.deterministic = true, .features = 500});
    for (int i = 0; i < 60; ++i)
      tracker.Step(room.Take(TexturedRoom::HandAt(3 * i), static_cast<std::uint64_t>(i)));
    tracker.Finish();
    const auto check = tracker.Statistics().calibration;
    ASSERT_TRUE(check) << factor;
    EXPECT_EQ(check->Wrong(), factor > 1) << check->fitted_focal_px << " ± " << check->sigma_px;
    EXPECT_NEAR(check->fitted_focal_px, 520, 6);
  }
}

// As RefineBriefly() has them.
const std::string kFewFeatures = fmt::format(" --features {}", kFeatures);

// A light field on disk, as the command takes it.
struct OnDisk {
  test::ScratchFolder scratch;
  std::filesystem::path dir = scratch / "room";
  std::unique_ptr<RoomViews> views;

  explicit OnDisk(int count = 8, unsigned seed = 12) : views(MakeViews(count, 0.01, 0.1, seed)) {
    CaptureHeader header;
    header.camera = views->input.lenses[0];
    LightFieldWriter writer = LightFieldWriter::Create(dir, header);
    writer.SetSubject({{0, 0, 2.5}, 0.5});
    for (int i = 0; i < count; ++i) {
      Frame frame;
      frame.image = views->images[static_cast<std::size_t>(i)];
      frame.device_time_s = 0.1 * i;
      View view;
      view.cam_from_world = views->input.views[static_cast<std::size_t>(i)].cam_from_world;
      writer.AddView(frame, view);
    }
    writer.Close(3.5, {{"recorded", count}});
  }
  PoseErrors Errors(const std::filesystem::path& at) const {
    const LightField read = ReadLightField(at);
    return ErrorsOf(views->truth, [&](std::size_t i) { return read.views[i].cam_from_world; });
  }
};

TEST(RefineCommand, RefinesALightFieldInPlace) {
  const OnDisk room;
  const LightField before = ReadLightField(room.dir);
  render::WriteMeshPly(room.dir / render::kMeshProxyFile,
                       render::TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}},
                       render::OriginComments("ulf proxy", before));
  const auto run = test::RunUlf("refine " + room.dir.string() + kFewFeatures + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  EXPECT_EQ(report["outdated"], nlohmann::json({render::kMeshProxyFile})) << "it is of the poses before";
  EXPECT_EQ(report["registered"], 8);
  EXPECT_GT(report["peak_memory_mib"], 10.0);
  EXPECT_TRUE(report["settled"]);
  EXPECT_FALSE(report.contains("contradicted"));
  EXPECT_GT(report["predicted_error"]["median"], 0.0);
  EXPECT_FALSE(report.contains("explain")) << "not asked";
  EXPECT_LT(room.Errors(room.dir).center, 0.002);
  const LightField after = ReadLightField(room.dir);
  EXPECT_EQ(after.subject, before.subject);
  EXPECT_EQ(after.capture_s, 3.5);
  EXPECT_EQ(after.reasons, before.reasons);
  EXPECT_EQ(after.cameras, before.cameras);
  EXPECT_EQ(after.points.size(), report["points"].get<std::size_t>());
  // What others read says the same.
  std::filesystem::remove(room.dir / "journal.jsonl");
  EXPECT_LT(room.Errors(room.dir).center, 0.002);

  const auto again = test::RunUlf("refine " + room.dir.string());
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.errors, HasSubstr("ulf repair"));
  // A set by another program has none to be repaired, and is never written to.
  std::filesystem::create_directories(room.scratch / "set");
  std::ofstream(room.scratch / "set/transforms.json") << R"({"fl_x": 60, "frames": []})";
  const auto foreign = test::RunUlf("refine " + (room.scratch / "set").string());
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_THAT(foreign.errors, AllOf(HasSubstr("-o"), Not(HasSubstr("repair"))));
  const auto imported =
      test::RunUlf("refine " + room.dir.string() + kFewFeatures + " -o " + (room.scratch / "copy").string());
  ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  EXPECT_THAT(imported.output, HasSubstr("8 of 8 views registered"));
  EXPECT_THAT(imported.output, HasSubstr("they are known to"));
  EXPECT_THAT(imported.output, Not(HasSubstr("has not converged")));
  EXPECT_LT(room.Errors(room.scratch / "copy").center, 0.002);
}

TEST(RefineCommand, SaysHowFarThePosesAreFromTrueOnes) {
  const OnDisk room;
  std::vector<TimedPose> truth;
  for (std::size_t i = 0; i < room.views->truth.size(); ++i)
    truth.push_back({0.1 * static_cast<double>(i), room.views->truth[i]});
  WriteTum(room.scratch / "truth.txt", truth);
  std::map<int, Rigid3> moved;
  {
    // As an adjustment at the end of a capture would.
    LightFieldWriter writer = LightFieldWriter::Resume(room.dir);
    for (const View& view : writer.Contents().views) {
      moved[view.id] = view.cam_from_world;
      moved[view.id].translation.x() += 0.004 * (view.id % 2);
    }
    writer.UpdatePoses(moved);
    writer.Close(3.5);
  }
  const auto run = test::RunUlf("refine " + room.dir.string() + kFewFeatures + " --json --truth " +
                                (room.scratch / "truth.txt").string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output)["truth"];
  EXPECT_EQ(report["compared"], 8);
  EXPECT_NE(report["recorded"]["centre_rms"], report["before"]["centre_rms"]);
  EXPECT_LT(report["after"]["centre_rms"], 0.5 * report["before"]["centre_rms"].get<double>());
  EXPECT_LT(report["after"]["centre_rms"], 0.5 * report["recorded"]["centre_rms"].get<double>());
  EXPECT_NEAR(report["after"]["centre_rms_percent"],
              100 * report["after"]["centre_rms"].get<double>() / report["distance"].get<double>(), 1e-9);

  // Of another session: said, and the poses are refined all the same.
  for (TimedPose& pose : truth) pose.time_s += 100;
  WriteTum(room.scratch / "other.txt", truth);
  const auto other = test::RunUlf("refine " + room.dir.string() + kFewFeatures + " --truth " +
                                  (room.scratch / "other.txt").string());
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.errors, HasSubstr("fewer than three views"));
  EXPECT_THAT(other.output, HasSubstr("registered by")) << "the report of what was done to the light field";
}

TEST(RefineCommand, OnAFullDiskTheOldPosesAreStillThere) {
  const OnDisk room;
  const test::ScratchFolder small;
  if (const auto problem = test::MountSmallDisk(small.path(), 64 << 20)) GTEST_SKIP() << *problem;
  const std::filesystem::path dir = small / "room";
  std::filesystem::copy(room.dir, dir, std::filesystem::copy_options::recursive);
  {
    // The last block of the journal has no room for new poses either.
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    const View& view = writer.Contents().views[0];
    const std::map<int, Rigid3> as_it_is{{view.id, view.cam_from_world}};
    while (4096 - std::filesystem::file_size(dir / "journal.jsonl") % 4096 > 700)
      writer.UpdatePoses(as_it_is);
    writer.Close(3.5);
  }
  test::FillDisk(small / "ballast");
  const auto run = test::RunUlf("refine " + dir.string() + kFewFeatures);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("No space left"));
  const LightField before = ReadLightField(room.dir), after = ReadLightField(dir);
  ASSERT_EQ(after.views.size(), before.views.size());
  for (std::size_t v = 0; v < after.views.size(); ++v)
    EXPECT_EQ(after.views[v].cam_from_world.Matrix(), before.views[v].cam_from_world.Matrix());
  std::filesystem::remove(small / "ballast");
  const auto again = test::RunUlf("refine " + dir.string() + kFewFeatures);
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_LT(room.Errors(dir).center, 0.002);
}

TEST(RefineCommand, IntrinsicsChangeOnlyWhenAskedFor) {
  OnDisk room(14, 13);
  {
    LightFieldWriter writer = LightFieldWriter::Resume(room.dir);
    CameraModel wrong = writer.Contents().cameras[0];
    wrong.fx *= 1.05;
    wrong.fy *= 1.05;
    writer.UpdatePoses({}, {{0, {wrong, ""}}});
    writer.Close(1);
  }
  const CameraModel wrong = ReadLightField(room.dir).cameras[0];
  EXPECT_NEAR(wrong.fx, 546, 1e-6);
  const auto told = test::RunUlf("refine " + room.dir.string() + " --explain");
  ASSERT_EQ(told.exit_code, 0) << told.errors;
  EXPECT_THAT(told.output, HasSubstr("\n  as given"));
  EXPECT_THAT(told.output, HasSubstr("\n* focal length free"));
  EXPECT_THAT(told.output, HasSubstr("--intrinsics adjusts the lens together with the poses"));
  EXPECT_EQ(ReadLightField(room.dir).cameras[0], wrong);
  const auto taken = test::RunUlf("refine " + room.dir.string() + " --intrinsics --explain --json");
  ASSERT_EQ(taken.exit_code, 0) << taken.errors;
  const auto candidates = JsonFromText(taken.output)["explain"][0]["candidates"];
  ASSERT_EQ(candidates.size(), 5u);
  EXPECT_EQ(candidates[0]["model"], "as given");
  EXPECT_FALSE(candidates[0]["chosen"]);
  EXPECT_EQ(std::count_if(candidates.begin(), candidates.end(), [](const auto& c) { return c["chosen"]; }),
            1);
  const LightField refined = ReadLightField(room.dir);
  EXPECT_NEAR(refined.cameras[0].fx, 520, 4);
  EXPECT_THAT(refined.CalibrationSource(0), HasSubstr("refined together"));
}

TEST(RefineCommand, AKillAtAnyMomentLeavesOldOrNewPoses) {
  const OnDisk room;
  const LightField before = ReadLightField(room.dir);
  const double error_before = room.Errors(room.dir).center;
  int killed = 0;
  for (int round = 0; round < 8; ++round) {
    test::ChildProcess child({std::getenv("ULF_BINARY"), "refine", room.dir.string(), "--features",
                              std::to_string(kFeatures), "--json"});
    usleep(static_cast<useconds_t>(250000 * round + 1000));
    child.Signal(SIGKILL);
    killed += child.Wait(10) == 128 + SIGKILL;
    const LightField after = ReadLightField(room.dir);
    ASSERT_EQ(after.views.size(), before.views.size());
    bool all_old = true;
    for (std::size_t v = 0; v < after.views.size(); ++v)
      all_old &= after.views[v].cam_from_world.Matrix() == before.views[v].cam_from_world.Matrix();
    if (!all_old) {
      EXPECT_LT(room.Errors(room.dir).center, 0.5 * error_before);
      break;
    }
  }
  EXPECT_GT(killed, 0);
}

TEST(RefineCommand, UnwritableFolderFailsBeforeTheWork) {
  const OnDisk room(3, 14);
  if (geteuid() == 0) {
    // Root may write anywhere: somebody else holds the journal instead.
    const LightFieldWriter holder = LightFieldWriter::Resume(room.dir);
    const auto run = test::RunUlf("refine " + room.dir.string());
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.errors, HasSubstr("another process is recording"));
    return;
  }
  std::filesystem::permissions(room.dir / "journal.jsonl", std::filesystem::perms::owner_read);
  const auto run = test::RunUlf("refine " + room.dir.string());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("check permissions"));
}

}  // namespace
}  // namespace ulf::refine_test
