// Tests: tracking/refine/refine_rows.
//
// Views of a simulated rolling shutter, tracked and refined with and without knowing the rows, and of a
// global one. Prints the rows of the table in docs/measured/tracking.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/quantile.h"
#include "tests/support/floors.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/refine.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::rows_long_test {
namespace {

constexpr int kFrames = 150, kStep = 4;

// Every fourth frame of a followed hand, as a capture would record it.
struct RollingViews {
  RefineInput input;
  std::shared_ptr<SimulatedCamera> camera;
  std::vector<double> times_s;  // of the middle rows, on the hand's clock
  std::vector<Rigid3> truth;    // and the camera's poses then
  std::vector<Image> images;
};

std::unique_ptr<RollingViews> Record(unsigned seed, double readout_s) {
  auto views = std::make_unique<RollingViews>();
  SimulationOptions options;
  options.seed = seed;
  options.readout_s = readout_s;
  options.looks_away = false;
  views->camera = std::make_shared<SimulatedCamera>(options);
  views->input.lenses = {views->camera->camera()};
  Tracker tracker(views->camera->camera(), {.deterministic = true, .readout = {.readout_s = readout_s}});
  std::vector<std::pair<int, Track>> recorded;
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame = views->camera->Capture(static_cast<std::uint64_t>(i));
    const Track track = tracker.Step(frame);
    if (!track.anchor || i % kStep != 0) continue;
    recorded.emplace_back(i, track);
    views->times_s.push_back(frame.device_time_s);
    views->truth.push_back(*frame.known_cam_from_world);
    views->images.push_back(frame.image);
  }
  tracker.Finish();
  for (const auto& [i, track] : recorded)
    views->input.views.push_back(
        {fmt::format("frame {}", i), 0, tracker.PoseOf(*track.anchor), 0, track.twist});
  views->input.read = [from = views.get()](int i) { return from->images[static_cast<std::size_t>(i)]; };
  return views;
}

// The poses that explain the pictures best, by what is true of the camera: of points about where a
// result has them.
std::vector<Rigid3> TruePictures(const RollingViews& views, const RefineResult& result, double readout_s) {
  std::vector<Eigen::Vector3d> estimated, truth;
  for (std::size_t v = 0; v < views.truth.size(); ++v) {
    estimated.push_back(result.views[v].cam_from_world.OriginInSource());
    truth.push_back(views.truth[v].OriginInSource());
  }
  const Similarity3 truth_from_estimated = *AlignPoints(estimated, truth);
  const CameraModel& lens = views.input.lenses[0];
  std::vector<std::vector<PointObservation>> seen(views.truth.size());
  for (const ScenePoint& point : result.points) {
    const Eigen::Vector3d in_world = truth_from_estimated * point.position_in_world;
    for (const ViewObservation& o : point.track) {
      const auto v = static_cast<std::size_t>(o.view_id);
      const double time_s = views.times_s[v] + RowTime(readout_s, o.in_img.y(), lens.height);
      if (const auto img = lens.ImgFromCam(views.camera->hand().CamFromWorld(time_s) * in_world))
        seen[v].push_back({in_world, *img, 1});
    }
  }
  std::vector<Rigid3> pictures;
  for (std::size_t v = 0; v < seen.size(); ++v)
    pictures.push_back(
        RefinePose(lens, seen[v], views.truth[v], {.huber_sigmas = 1e3, .gate_sigmas = 1e3, .rounds = 1})
            ->cam_from_world);
  return pictures;
}

struct Errors {
  double before_mm, without_mm, with_mm, middle_mm, unrecorded_mm;
};

Errors RefineInAllWays(unsigned seed, double readout_ms) {
  const auto views = Record(seed, 1e-3 * readout_ms);
  const RefineOptions options{.features = 1500};
  const RefineResult without = Refine(views->input, options);
  views->input.readout_s = 1e-3 * readout_ms;
  const RefineResult with = Refine(views->input, options);
  std::vector<Rigid3> given;
  for (RefineInput::View& view : views->input.views) {
    given.push_back(view.cam_from_world);
    view.twist.reset();
  }
  const RefineResult unrecorded = Refine(views->input, options);
  // Each against the points and corners that it chose itself.
  const auto true_pictures = [&](const RefineResult& result) {
    return TruePictures(*views, result, views->input.readout_s);
  };
  const std::vector<Rigid3> pictures = true_pictures(without);
  const auto mm = [](const std::vector<Rigid3>& truth, const auto& pose_of) {
    return 1000 * ErrorsOf(truth, pose_of).center;
  };
  const auto of = [](const RefineResult& result) {
    return [&result](std::size_t v) { return result.views[v].cam_from_world; };
  };
  const auto middle = [&](std::size_t v) {
    return with.views[v].middle_row_from_picture.value_or(Rigid3{}) * with.views[v].cam_from_world;
  };
  const Errors errors{mm(pictures, [&](std::size_t v) { return given[v]; }), mm(pictures, of(without)),
                      mm(true_pictures(with), of(with)), mm(views->truth, middle),
                      mm(true_pictures(unrecorded), of(unrecorded))};
  fmt::print("| {} | {} | {:.2f} mm | {:.2f} mm | {:.2f} mm | {:.2f} mm | {:.2f} mm |\n", seed,
             views->truth.size(), errors.before_mm, errors.without_mm, errors.with_mm, errors.unrecorded_mm,
             errors.middle_mm);
  std::fflush(stdout);
  return errors;
}

TEST(RefineRowsLong, ImprovePosesWhenKnown) {
  std::vector<double> without, with;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    const Errors errors = RefineInAllWays(seed, 20);
    without.push_back(errors.without_mm);
    with.push_back(errors.with_mm);
  }
  EXPECT_LT(Median(with), Median(without));
}

}  // namespace
}  // namespace ulf::test::rows_long_test
