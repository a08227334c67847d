#include "core/light_field/folder/quick_checks.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/light_field/folder/kept_findings.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The limits are far from the values of right sets (docs/light_field.md, "Checks").
constexpr double kMostMisplacedShare = 0.5, kLeastShownShare = 0.05, kLeastViewsShare = 0.25;
constexpr double kLeastSpreadShare = 0.01, kLeastBaselineShare = 0.0015;

// A hundred thousand projections take some ten milliseconds.
constexpr std::size_t kMostPoints = 500, kSampledViews = 200;

template <typename Value>
std::vector<const Value*> Sample(const std::vector<Value>& values, std::size_t most) {
  const std::size_t count = std::min(values.size(), most);
  std::vector<const Value*> sample;
  for (std::size_t i = 0; i < count; ++i) sample.push_back(&values[i * values.size() / count]);
  return sample;
}

void CountMisplaced(const LightField& light_field, const std::vector<const ScenePoint*>& points,
                    PointsFit& fit) {
  for (const ScenePoint* point : points)
    for (const ViewObservation& seen : point->track) {
      const PosedObservation observation = PosedObservationOf(seen, light_field);
      if (!observation.camera) continue;
      ++fit.observations;
      fit.misplaced += !(ReprojectionErrorPx(observation, point->position_in_world) <= kMostTrackErrorPx);
    }
}

double Interquartile(const std::vector<double>& values) {
  return Quantile(values, 0.75) - Quantile(values, 0.25);
}

// Returns the spread of the cameras around their middle, coordinate by coordinate.
double Baseline(const std::vector<const View*>& views) {
  std::vector<double> of[3];
  for (const View* view : views)
    for (int i = 0; i < 3; ++i) of[i].push_back(view->CenterInWorld()(i));
  return std::hypot(Interquartile(of[0]), Interquartile(of[1]), Interquartile(of[2]));
}

bool IsInAnyPhotograph(const Subject& subject, const LightField& light_field) {
  return std::ranges::any_of(light_field.views, [&](const View& view) {
    const Vector3d in_cam = view.cam_from_world * subject.center_in_world;
    const auto img = light_field.CameraOf(view).ImgFromCam(in_cam);
    return in_cam.z() > 0 && img && light_field.CameraOf(view).Contains(*img);
  });
}

}  // namespace

PointsFit FitOfPoints(const LightField& light_field) {
  PointsFit fit;
  const auto points = Sample(light_field.points, kMostPoints);
  const auto views = Sample(light_field.views, kSampledViews);
  if (points.empty() || views.size() < 2) return fit;
  CountMisplaced(light_field, points, fit);
  // Observations left out on reading are counted among all points, not in the sample.
  fit.observations += light_field.misplaced_observations * points.size() / light_field.points.size();
  fit.misplaced += light_field.misplaced_observations * points.size() / light_field.points.size();

  std::vector<bool> is_shown(points.size(), false);
  std::vector<double> spreads, distances;
  std::size_t views_with_points = 0;
  for (const View* view : views) {
    const CameraModel& camera = light_field.CameraOf(*view);
    std::vector<double> x, y;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d in_cam = view->cam_from_world * points[i]->position_in_world;
      if (!(in_cam.z() > 0)) continue;
      const auto img = camera.ImgFromCam(in_cam);
      if (!img || !camera.Contains(*img)) continue;
      is_shown[i] = true;
      x.push_back(img->x());
      y.push_back(img->y());
      distances.push_back(in_cam.norm());
    }
    views_with_points += !x.empty();
    constexpr std::size_t kFewest = 8;
    if (x.size() >= kFewest)
      spreads.push_back(std::hypot(Interquartile(x), Interquartile(y)) /
                        std::hypot(camera.width, camera.height));
  }
  fit.shown_share =
      static_cast<double>(std::ranges::count(is_shown, true)) / static_cast<double>(points.size());
  fit.views_share = static_cast<double>(views_with_points) / static_cast<double>(views.size());
  if (!spreads.empty()) fit.spread_share = Median(std::move(spreads));
  if (!distances.empty()) fit.baseline_share = Baseline(views) / Median(std::move(distances));
  return fit;
}

std::string DescribeMisfit(const PointsFit& fit) {
  if (static_cast<double>(fit.misplaced) > kMostMisplacedShare * static_cast<double>(fit.observations))
    return fmt::format(
        "{:.0f} % of the places where views show them are more than {:g} px from where the poses put them",
        100.0 * static_cast<double>(fit.misplaced) / static_cast<double>(fit.observations),
        kMostTrackErrorPx);
  if (fit.shown_share < kLeastShownShare)
    return fmt::format("by the poses, no photograph shows {:.0f} % of them", 100 * (1 - fit.shown_share));
  if (fit.views_share < kLeastViewsShare)
    return fmt::format("by the poses, {:.0f} % of the photographs show none of them",
                       100 * (1 - fit.views_share));
  if (fit.spread_share < kLeastSpreadShare) return "by the poses, all of them are a speck in the photographs";
  if (fit.baseline_share < kLeastBaselineShare)
    return "they are so far away that by the poses all cameras stand at one place";
  return {};
}

// Says why the subject does not belong to the poses, as a clause; empty if it may.
std::string SubjectMisfit(const Subject& subject, const LightField& light_field) {
  if (!IsInAnyPhotograph(subject, light_field)) return "no photograph shows the middle of the subject";
  const auto views = Sample(light_field.views, kSampledViews);
  std::vector<double> distances;
  for (const View* view : views)
    distances.push_back((view->CenterInWorld() - subject.center_in_world).norm());
  const double baseline = views.size() < 2 ? 0 : Baseline(views), distance = Median(std::move(distances));
  constexpr double kRounding = 1e-9;
  if (views.size() > 1 && baseline <= kRounding * distance)
    return "most cameras stand at one place, from which no depth follows";
  if (baseline > 0 && baseline < kLeastBaselineShare * distance)
    return fmt::format("the subject is {:.0f} times as far away as most cameras stand from their middle",
                       distance / baseline);
  return {};
}

std::vector<Finding> QuickFindings(const LightField& light_field) {
  std::vector<Finding> findings;
  const PointsFit fit = FitOfPoints(light_field);
  if (!light_field.points.empty())
    spdlog::debug("{}: points: {} of {} observations misplaced; shown {:.3f}, spread {:.4f}, baseline {:.5f}",
                  light_field.root.string(), fit.misplaced, fit.observations, fit.shown_share,
                  fit.spread_share, fit.baseline_share);
  if (const std::string misfit = DescribeMisfit(fit); !misfit.empty())
    findings.push_back(
        {Name(Check::kPoints),
         fmt::format("the points do not belong to the poses: {}; are they of another scale, or of "
                     "another reconstruction? ulf refine measures new ones",
                     misfit),
         {}});
  if (light_field.subject && !light_field.views.empty())
    if (const std::string misfit = SubjectMisfit(*light_field.subject, light_field); !misfit.empty())
      findings.push_back(
          {Name(Check::kSubject),
           fmt::format("{}; is it in another unit than the poses, or are the poses wrong? ulf import makes a "
                       "copy with the subject that {} x,y,z,radius names",
                       misfit, Parameter("subject")),
           {}});
  return findings;
}

std::vector<Finding> KnownFindings(const std::vector<KeptFinding>& kept, const LightField& light_field) {
  std::vector<Finding> findings = StillValid(kept, light_field);
  for (Finding& each : QuickFindings(light_field)) findings.push_back(std::move(each));
  return findings;
}

void AddKnownFindings(const std::vector<KeptFinding>& kept, LightField& light_field) {
  light_field.findings = KnownFindings(kept, light_field);
  WarnOnce(light_field.root, light_field.findings);
}

}  // namespace ulf
