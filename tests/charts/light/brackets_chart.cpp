// How wrong the merged light of exposure brackets is, by how bright a pixel is, against the number of
// exposures, aligned and not.
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "render/stereo/bracket_merge.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/render/scenes/bracketed_view.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

constexpr int kTracked = 3000;  // points

// 0, then two stops shorter and longer in turn.
std::vector<double> StopsOf(int exposures) {
  std::vector<double> stops;
  for (int i = 1; i < exposures; ++i) stops.push_back((i % 2 == 1 ? -2.0 : 2.0) * ((i + 1) / 2));
  return stops;
}

// The scene at a time, things that move where they are then: as SimulatedCamera::CleanLinear().
cv::Mat CleanAt(const SimulatedCamera& camera, const Rigid3& cam_from_world, double time_s) {
  cv::Mat radiance = cv::Mat::zeros(camera.camera().height, camera.camera().width, CV_32FC4);
  camera.caster().AccumulateRows(cam_from_world, 1, 0, radiance.rows, radiance, camera.SwayAngle(time_s));
  cv::Mat light;
  cv::cvtColor(radiance, light, cv::COLOR_BGRA2BGR);
  return light * camera.LightScale();
}

struct Found {
  double precision = 0, recall = 0;  // percent
};

// Of the pixels that show something else in some exposure: by a fifth of the light and a hundredth
// of full scale.
Found GhostsFound(unsigned seed, int exposures) {
  const BracketedView how{.seed = seed,
                          .width = 480,
                          .height = 360,
                          .exposure_s = 0.01,
                          .between_s = 0.2,
                          .at_s = 8 + 0.37 * (seed - kFirstSeed + 1),
                          .scene = "branch",
                          .speed_deg_s = 0};
  const SimulatedCamera camera = LightboxCamera(how);
  const ScratchFolder scratch;
  std::vector<double> stops = StopsOf(exposures);
  for (double& each : stops) each /= 2;
  const LightField light_field = TakeBracket(camera, how, scratch / "lf", stops);
  const View& view = light_field.views.at(0);
  const auto geometry = PointsSeen(camera, view.cam_from_world, kTracked);
  const cv::Mat ghosts = MergeExposuresOf(light_field, view, *geometry).merged.ghosts;
  const cv::Mat truth = CleanAt(camera, view.cam_from_world, view.device_time_s);
  cv::Mat moved = cv::Mat::zeros(truth.size(), CV_8UC1);
  for (const ViewExposure& each : view.exposures) {
    const cv::Mat other = CleanAt(camera, view.cam_from_world, each.device_time_s);
    for (int y = 0; y < truth.rows; ++y)
      for (int x = 0; x < truth.cols; ++x)
        for (int c = 0; c < 3; ++c) {
          const float here = truth.at<cv::Vec3f>(y, x)[c], there = other.at<cv::Vec3f>(y, x)[c];
          if (std::abs(there - here) > 0.2f * here + 0.01f) moved.at<std::uint8_t>(y, x) = 255;
        }
  }
  cv::Mat around;
  cv::dilate(moved, around, cv::Mat::ones(5, 5, CV_8UC1));
  const auto percent = [](const cv::Mat& those, const cv::Mat& of) {
    return 100.0 * cv::countNonZero(those & of) / std::max(1, cv::countNonZero(of));
  };
  return {percent(around, ghosts), percent(ghosts, moved)};
}

constexpr char kAligned[] = "aligned by poses and geometry", kLying[] = "as they lie", kGhosts[] = "ghosts",
               kMoving[] = "things that move: precision and recall of ghosts";
constexpr std::size_t kFew = 200;  // pixels

// Returns the median error of each stop of light that enough pixels have.
std::map<int, double> MediansOf(const ErrorsByStop& errors) {
  std::map<int, double> medians;
  for (const auto& [stop, all] : errors)
    if (all.size() >= kFew) medians[stop] = Spread::Of(all).median;
  return medians;
}

// The merged light of a moving hand's views, and their single exposures.
void AddHeld(int exposures, unsigned seed, int views, bool with_alone, Table& table) {
  std::map<bool, ErrorsByStop> errors;
  std::map<bool, std::vector<double>> ghosts;
  std::vector<ErrorsByStop> alone(static_cast<std::size_t>(exposures));
  for (int i = 0; i < views; ++i) {
    const BracketedView how{.seed = seed,
                            .width = 480,
                            .height = 360,
                            .exposure_s = 0.001,
                            .between_s = 0.05,
                            .at_s = 1.0 + 2.5 * i};
    const SimulatedCamera camera = LightboxCamera(how);
    const ScratchFolder scratch;
    const LightField light_field = TakeBracket(camera, how, scratch / "lf", StopsOf(exposures));
    const View& view = light_field.views.at(0);
    const auto geometry = PointsSeen(camera, view.cam_from_world, kTracked);
    const cv::Mat truth = camera.CleanLinear(view.cam_from_world);
    for (std::size_t number = 0; number < alone.size(); ++number)
      AddErrorsAlone(camera, light_field, view, number, alone[number]);
    for (const bool align : {true, false}) {
      if (exposures == 1 && !align) continue;
      const MergedLight merged = MergeExposuresOf(light_field, view, *geometry, {.align = align}).merged;
      AddErrors(merged.light, truth, errors[align]);
      ghosts[align].push_back(100 * merged.ghost_share);
    }
  }
  const std::string series = exposures == 1 ? "1 exposure" : fmt::format("{} exposures", exposures);
  for (const auto& [align, by_stop] : errors)
    for (const auto& [stop, median] : MediansOf(by_stop))
      table.Add(align ? kAligned : kLying, series, "", stop + 0.5, median);
  std::map<int, double> least;
  for (const ErrorsByStop& each : alone)
    for (const auto& [stop, median] : MediansOf(each))
      least[stop] = std::min(median, least.contains(stop) ? least[stop] : median);
  for (const auto& [stop, median] : least)
    if (with_alone) table.Add(kAligned, fmt::format("best of {} alone", exposures), "", stop + 0.5, median);
  for (const auto& [align, shares] : ghosts)
    if (exposures > 1)
      table.Add(kGhosts, align ? "aligned" : "as they lie", std::to_string(exposures), exposures,
                Spread::Of(shares).median, align);
}

void AddFromAStand(int exposures, unsigned seed, Table& table) {
  const BracketedView how{
      .seed = seed, .width = 480, .height = 360, .exposure_s = 0.001, .between_s = 0.05, .speed_deg_s = 0};
  const SimulatedCamera camera = LightboxCamera(how);
  const ScratchFolder scratch;
  const LightField light_field = TakeBracket(camera, how, scratch / "lf", StopsOf(exposures));
  const View& view = light_field.views.at(0);
  const auto geometry = PointsSeen(camera, view.cam_from_world, kTracked);
  const std::string name = std::to_string(exposures);
  table.Add(kGhosts, "aligned, on a stand", name, exposures,
            100 * MergeExposuresOf(light_field, view, *geometry).merged.ghost_share);
  const Found found = GhostsFound(seed, exposures);
  table.Add(kMoving, "precision", name, exposures, found.precision);
  table.Add(kMoving, "recall", name, exposures, found.recall);
}

Chart MeasureBrackets(const Effort& effort) {
  Table table;
  for (const char* title : {kAligned, kLying})
    table.Panel(title, {"light, stops over full scale of the view's own exposure"},
                Log("error, share of the light (median)"), {.compared = false});
  table.Panel(kGhosts, {"exposures"}, FromZero({"ghosts [% of the pixels]"}), {.compared = false});
  table.Panel(kMoving, {"exposures"}, FromZero(MoreIsBetter({"share found [%]"})), {.compared = false});
  const std::vector<int> counts = effort.Of(std::vector{1, 3}, {1, 3, 5, 7});
  for (const int exposures : counts)
    for (const unsigned seed : effort.Seeds(3)) {
      AddHeld(exposures, seed, effort.Of(1, 4), exposures == counts.back(), table);
      if (exposures > 1) AddFromAStand(exposures, seed, table);
    }
  return {.panels = table.panels()};
}

CHART(brackets, MeasureBrackets, "Exposure brackets: the merged light against the light that is there",
      R"(Simulated scene lightbox (sixteen stops), 480 x 360, 12-bit mosaic with noise; a hand that moves at
  5 degrees a second, 50 ms from one exposure to the next, two stops apart; poses exact, 3,000 points as
  geometry. Four views of each of three seeds, by the whole stop of the true light (0: full scale of the
  view's own exposure, of 1 ms); alone: each exposure by itself, where it was taken, and at each stop the
  one with the least error. Things that move: scene branch from a stand, 0.2 s and one stop apart; precision
  within two pixels. Bars: lowest to highest seed. Ringed: what is done.)");

}  // namespace
}  // namespace ulf::test
