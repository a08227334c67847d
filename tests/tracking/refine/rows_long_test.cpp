// Tests: tracking/refine/refine_rows.
//
// Views of a simulated rolling shutter, tracked and refined with and without knowing the rows, and of a global one.
// Prints the rows of the table in docs/tracking_measured.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "core/base/quantile.h"
#include "tests/support/floors.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/refine.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {
namespace {

// Every fifth frame of a followed hand, as a capture would record it, and where the camera was.
struct RollingViews {
  RefineInput input;
  std::vector<Rigid3> truth;       // of the middle rows
  std::vector<Twist> true_twists;  // about them
  std::vector<Image> images;
};

std::unique_ptr<RollingViews> Record(const std::string& uri, double readout_s) {
  const auto device = OpenDevice(uri);
  device->Start();
  auto views = std::make_unique<RollingViews>();
  std::unique_ptr<Tracker> tracker;
  std::vector<Frame> frames;
  std::vector<Track> tracks;
  while (!IsOver(device->State()))
    if (auto frame = device->Next(std::chrono::milliseconds(500))) {
      if (!tracker) {
        const CameraModel camera =
            ResolveIntrinsics(*device, {}, frame->image.width(), frame->image.height());
        views->input.lenses = {camera};
        tracker = std::make_unique<Tracker>(
            camera, TrackerOptions{.deterministic = true, .readout = {.readout_s = readout_s}});
      }
      tracks.push_back(tracker->Step(*frame));
      frames.push_back(std::move(*frame));
    }
  tracker->Finish();
  for (std::size_t i = 1; i + 1 < frames.size(); i += 5) {
    if (!tracks[i].anchor) continue;
    views->input.views.push_back(
        {fmt::format("frame {}", i), 0, tracker->PoseOf(*tracks[i].anchor), 0, tracks[i].twist});
    views->truth.push_back(*frames[i].known_cam_from_world);
    const double step_s = frames[i + 1].device_time_s - frames[i - 1].device_time_s;
    views->true_twists.push_back(
        TwistBetween(*frames[i - 1].known_cam_from_world, *frames[i + 1].known_cam_from_world, step_s));
    views->images.push_back(frames[i].image);
  }
  views->input.read = [from = views.get()](int i) { return from->images[static_cast<std::size_t>(i)]; };
  return views;
}

// The poses that explain the pictures best, by what is true of the camera: of points about where a result has them.
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
      const Eigen::Vector3d in_cam = views.truth[v] * in_world;
      const double time_s = RowTime(readout_s, o.in_img.y(), lens.height);
      if (const auto img = lens.ImgFromCam(PointAfter(views.true_twists[v], in_cam, time_s)))
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
  double before_mm, without_mm, with_mm, middle_mm;
};

Errors RefineBothWays(const std::string& uri, double readout_s) {
  const auto views = Record(uri, readout_s);
  const RefineResult without = Refine(views->input);
  views->input.readout_s = readout_s;
  const RefineResult with = Refine(views->input);
  const std::vector<Rigid3> pictures = TruePictures(*views, with, readout_s);
  const auto mm = [](const PoseErrors& errors) { return 1000 * errors.center; };
  const auto given = [&](std::size_t v) { return views->input.views[v].cam_from_world; };
  const auto plain = [&](std::size_t v) { return without.views[v].cam_from_world; };
  const auto knowing = [&](std::size_t v) { return with.views[v].cam_from_world; };
  const auto middle = [&](std::size_t v) {
    return with.views[v].middle_row_from_picture.value_or(Rigid3{}) * with.views[v].cam_from_world;
  };
  const Errors errors{mm(ErrorsOf(pictures, given)), mm(ErrorsOf(pictures, plain)),
                      mm(ErrorsOf(pictures, knowing)), mm(ErrorsOf(views->truth, middle))};
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", uri, views->truth.size(), errors.before_mm,
             errors.without_mm, errors.with_mm, errors.middle_mm);
  return errors;
}

TEST(RefineRowsLong, KnowingThemMakesPosesBetter) {
  std::vector<double> without, with;
  for (const int seed : {1, 2, 3, 4, 5}) {
    const Errors errors =
        RefineBothWays(fmt::format("sim:studio?duration_s=8&look_away=0&seed={}&readout_ms=20", seed), 0.02);
    without.push_back(errors.without_mm);
    with.push_back(errors.with_mm);
  }
  EXPECT_LT(Median(with), Median(without));
}

}  // namespace
}  // namespace ulf::test
