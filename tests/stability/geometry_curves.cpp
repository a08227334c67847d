// Two views that tell little of their motion, one view of points that tell little of its pose, and
// adjustments of views that hardly hold together. Scenes are drawn; matches are off by half a pixel.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/measure/curve.h"
#include "tests/support/aligned_centres.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/estimation/bundle_uncertainty.h"
#include "tracking/map/pose_error.h"

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNoise_px = 0.5;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Vector2d Noise(Draw& draw) { return {draw.Normal(kNoise_px), draw.Normal(kNoise_px)}; }

// --- two views

struct TwoViews {
  double relief = 1;      // of the scene, share of its depth
  double baseline = 0.2;  // share of the depth
  double outliers = 0.1;  // share of the matches
};

// A slanted plane from which points lie off, both ways, by up to half the relief.
RelativeScene Seen(const TwoViews& views, unsigned seed) {
  constexpr int kMatches = 300;
  constexpr double kDepth = 4;
  Draw draw(seed);
  const CameraModel camera = SceneCamera();
  RelativeScene scene;
  Vector3d direction = draw.Direction();
  direction.z() *= 0.5;
  scene.second_from_first = {Eigen::Quaterniond(Eigen::AngleAxisd(draw.Uniform(0.02, 0.2), draw.Direction())),
                             views.baseline * kDepth * direction.normalized()};
  const Vector3d normal = Vector3d(draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5), 1).normalized();
  while (static_cast<int>(scene.pairs.size()) < kMatches) {
    const Vector2d first(draw.Uniform(0, camera.width), draw.Uniform(0, camera.height));
    const Vector3d ray = *camera.RayFromImg(first);
    const double depth = kDepth * normal.z() / normal.dot(ray) * (1 + views.relief * draw.Uniform(-0.5, 0.5));
    const auto second = camera.ImgFromCam(scene.second_from_first * (depth * ray));
    if (!second || !camera.Contains(*second)) continue;
    Vector2d seen = *second + Noise(draw);
    if (draw.Uniform(0, 1) < views.outliers)
      seen = {draw.Uniform(0, camera.width), draw.Uniform(0, camera.height)};
    const auto first_ray = camera.RayFromImg(first + Noise(draw)), second_ray = camera.RayFromImg(seen);
    if (first_ray && second_ray) scene.pairs.push_back({*first_ray, *second_ray});
  }
  return scene;
}

Trial MotionOf(const TwoViews& views, unsigned seed) {
  constexpr double kTurn_deg = 1, kDirection_deg = 10;
  const RelativeScene scene = Seen(views, seed);
  const RelativePoseResult found =
      RelativePose(scene.pairs, {.focal_px = SceneCamera().MeanFocalPx(), .seed = seed});
  if (found.outcome != RelativePoseOutcome::kFound) return {Verdict::kSaidSo, kNone};
  const double turn = DegreesBetween(found.second_from_first.rotation, scene.second_from_first.rotation);
  const double direction =
      DegreesBetween(found.second_from_first.translation, scene.second_from_first.translation);
  return {turn < kTurn_deg && direction < kDirection_deg ? Verdict::kRight : Verdict::kWrong, direction};
}

// --- one view

// By the rule of Track::quality: doubtful where the centre's own sigma is a hundredth of the distance. Right
// within three of those.
Trial PoseOf(const std::vector<PointObservation>& seen, const Rigid3& truth, double distance, unsigned seed) {
  constexpr double kRight_pct = 3, kDoubtful = 0.5;
  const auto found = AbsolutePose(SceneCamera(), seen, {.seed = seed});
  const auto refined = found ? RefinePose(SceneCamera(), seen, found->cam_from_world) : std::nullopt;
  if (!refined) return {Verdict::kSaidSo, kNone};
  const double off_pct =
      100 * (refined->cam_from_world.OriginInSource() - truth.OriginInSource()).norm() / distance;
  if (QualityOf(refined->center_sigma, distance) < kDoubtful) return {Verdict::kSaidSo, off_pct};
  return {off_pct < kRight_pct ? Verdict::kRight : Verdict::kWrong, off_pct};
}

constexpr int kPoints = 60;
constexpr double kWrongMatches = 0.1;

void See(const Vector3d& point, const Rigid3& cam_from_world, Draw& draw,
         std::vector<PointObservation>& seen) {
  const CameraModel camera = SceneCamera();
  const auto img = camera.ImgFromCam(cam_from_world * point);
  if (!img || !camera.Contains(*img)) return;
  const bool wrong = draw.Uniform(0, 1) < kWrongMatches;
  seen.push_back({point,
                  wrong ? Vector2d(draw.Uniform(0, camera.width), draw.Uniform(0, camera.height))
                        : Vector2d(*img + Noise(draw)),
                  kNoise_px});
}

// Points in three places on a circle of radius one, the camera beside the cylinder over it.
Trial SeesThreePlaces(double extent, double off_cylinder, unsigned seed) {
  Draw draw(seed);
  const double height = draw.Uniform(2, 4), at = draw.Uniform(0, 2 * M_PI);
  const Vector3d center((1 + off_cylinder) * std::cos(at), (1 + off_cylinder) * std::sin(at), -height);
  const Rigid3 cam_from_world = LookAt(center, Vector3d::Zero(), Vector3d::UnitX());
  std::array<double, 3> places;
  for (std::size_t i = 0; i < 3; ++i)
    places[i] = 2 * M_PI / 3 * (static_cast<double>(i) + draw.Uniform(-0.2, 0.2));
  std::vector<PointObservation> seen;
  while (static_cast<int>(seen.size()) < kPoints) {
    const double a = places[seen.size() % 3];
    const Vector3d within(draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5));
    See(Vector3d(std::cos(a), std::sin(a), 0) + extent * within, cam_from_world, draw, seen);
  }
  return PoseOf(seen, cam_from_world, center.norm(), seed);
}

Trial NearlyCollinear(double spread, unsigned seed) {
  constexpr double kLength = 2, kDistance = 3;
  Draw draw(seed);
  const Rigid3 cam_from_world = LookAt(kDistance * draw.Direction(), Vector3d::Zero(), draw.Direction());
  const Vector3d sight = cam_from_world.OriginInSource().normalized();
  Vector3d along = draw.Direction();
  while (std::abs(along.dot(sight)) > 0.8) along = draw.Direction();
  const Vector3d side = along.unitOrthogonal(), up = along.cross(side);
  std::vector<PointObservation> seen;
  while (static_cast<int>(seen.size()) < kPoints)
    See(kLength * (draw.Uniform(-0.5, 0.5) * along + spread * draw.Uniform(-0.5, 0.5) * side +
                   spread * draw.Uniform(-0.5, 0.5) * up),
        cam_from_world, draw, seen);
  return PoseOf(seen, cam_from_world, kDistance, seed);
}

// --- adjustment

constexpr double kDistance = 1.5;  // of an arc of views from the middle of what they see
constexpr int kViews = 12;
constexpr char kAdjustedRight[] = R"( Right: centres off by less than 0.3 % of the distance. Says so: what
  `ulf refine` tells (nothing usable, not settled, most points of a view disagree), or a large predicted
  error.)";
constexpr char kFalseMinimum[] =
    "a false minimum in which the adjustment settles and most of every view's observations agree.";

CameraModel ArcCamera() { return CameraModel::Pinhole(640, 480, 525); }

struct Arc {
  int views = kViews;
  int views_a_point = kViews;  // neighbours
  double outliers = 0.02;      // share of the observations
  double start = 0.01;         // how far poses and points begin off: share of the distance, and radians
  double away = 0;             // of the world's origin: distances
};

struct ArcProblem {
  BundleProblem truth, start;
};

ArcProblem MakeArc(const Arc& arc, unsigned seed) {
  constexpr int kSeenByView = 150;
  constexpr double kStep_rad = 0.08;
  Draw draw(seed);
  const CameraModel camera = ArcCamera();
  ArcProblem made;
  BundleProblem& truth = made.truth;
  const Vector3d middle = arc.away * kDistance * Vector3d(0.6, 0, 0.8);
  for (int c = 0; c < arc.views; ++c) {
    const double azimuth = kStep_rad * (c - 0.5 * (arc.views - 1)), elevation = draw.Uniform(-0.1, 0.1);
    const Vector3d center(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          -std::cos(azimuth) * std::cos(elevation));
    truth.cam_from_world.push_back(LookAt(middle + kDistance * center, middle, Vector3d::UnitY()));
  }
  for (int p = 0; p < arc.views * kSeenByView / arc.views_a_point; ++p) {
    truth.points.push_back(middle + 0.5 * draw.Uniform(0.1, 1) * draw.Direction());
    const int first = static_cast<int>(draw.Uniform(0, arc.views - arc.views_a_point + 0.999));
    for (int c = first; c < first + arc.views_a_point; ++c) {
      auto img = camera.ImgFromCam(truth.cam_from_world[static_cast<std::size_t>(c)] * truth.points.back());
      if (!img || !camera.Contains(*img)) continue;
      *img += Noise(draw);
      if (draw.Uniform(0, 1) < arc.outliers)
        *img = {draw.Uniform(0, camera.width), draw.Uniform(0, camera.height)};
      truth.observations.push_back({c, p, *img, kNoise_px, false});
    }
  }
  made.start = truth;
  for (std::size_t c = 0; c < truth.cam_from_world.size(); ++c) {
    Rigid3& pose = made.start.cam_from_world[c];
    Vector3d center = pose.OriginInSource() + arc.start * kDistance * draw.Direction();
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(arc.start, draw.Direction())) * pose.rotation;
    pose.translation = -(pose.rotation * center);
  }
  for (Vector3d& point : made.start.points) point += arc.start * kDistance * draw.Direction();
  return made;
}

double CentresOff_pct(const BundleProblem& found, const BundleProblem& truth) {
  return 100 * AlignedCentreError(found.cam_from_world, truth.cam_from_world) / kDistance;
}

constexpr double kAdjusted_pct = 0.3;

// An answer that is off is doubted where the program itself says so: it did not settle, most of a view's own
// observations contradict it, or three of the standard deviations that it predicts reach what is asked for.
Trial JudgeAdjusted(const BundleSummary& summary, const BundleProblem& found, const BundleProblem& truth) {
  constexpr double kSigmas = 3;
  if (!summary.usable) return {Verdict::kSaidSo, kNone};
  const double off_pct = CentresOff_pct(found, truth);
  if (off_pct < kAdjusted_pct) return {Verdict::kRight, off_pct};
  double variance = 0;
  const std::vector<double> sigmas = CenterSigmas({ArcCamera()}, found);
  for (const double sigma : sigmas) variance += sigma * sigma / static_cast<double>(sigmas.size());
  const double predicted_pct = 100 * std::sqrt(variance) / kDistance;
  const bool doubted =
      !summary.settled || summary.least_kept < 0.5 || !(kSigmas * predicted_pct < kAdjusted_pct);
  return {doubted ? Verdict::kSaidSo : Verdict::kWrong, off_pct};
}

BundleSummary AdjustArc(BundleProblem& problem) {
  return AdjustBundle(ArcCamera(), problem, {.robust_iterations = 20, .iterations = 20});
}

Trial Adjusted(const Arc& arc, unsigned seed) {
  ArcProblem problem = MakeArc(arc, seed);
  const BundleSummary summary = AdjustArc(problem.start);
  return JudgeAdjusted(summary, problem.start, problem.truth);
}

// Nothing or one view is held: but for a similarity the same must come of it.
Trial AdjustedFreely(double away, unsigned seed) {
  constexpr double kSame_pct = 0.03;
  ArcProblem problem = MakeArc({.away = away}, seed);
  BundleProblem one = problem.start;
  BundleProblem& none = problem.start;
  one.fixed.assign(one.cam_from_world.size(), false);
  one.fixed[kViews / 2] = true;
  const BundleSummary summary = AdjustArc(none);
  const Trial trial = JudgeAdjusted(summary, none, problem.truth);
  if (trial.verdict != Verdict::kRight) return trial;
  if (!AdjustArc(one).usable) return {Verdict::kSaidSo, kNone};
  const double apart_pct = CentresOff_pct(one, none);
  return {apart_pct < kSame_pct ? Verdict::kRight : Verdict::kWrong, apart_pct};
}

CURVE(two_views_near_planar,
      {.stage = "Two views",
       .title = "A scene that becomes a plane",
       .about =
           R"(300 matches between two views a fifth of the depth apart, half a pixel of noise, a tenth of
  them wrong; a slanted plane with relief. Right: turned within 1 degree, moved within 10; any outcome but
  "found" says so.)",
       .driven =
           {Log("relief of the scene [% of its depth]"), {100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1}, 50, 0.1},
       .error = Log("direction of the motion is off by [degrees]"),
       .trial = [](double percent, unsigned seed) { return MotionOf({.relief = percent / 100}, seed); }});

CURVE(two_views_near_rotation,
      {.stage = "Two views",
       .title = "A camera that hardly moves, only turns",
       .about = "The same matches in a deep scene. Right and said are as above.",
       .driven = {Log("distance between the views [% of the depth]"),
                  {30, 20, 10, 5, 3, 2, 1, 0.5, 0.1, 0.01},
                  20,
                  0.01},
       .error = Log("direction of the motion is off by [degrees]"),
       .trial = [](double percent, unsigned seed) { return MotionOf({.baseline = percent / 100}, seed); }});

CURVE(two_views_wrong_matches,
      {.stage = "Two views",
       .title = "Matches that are mostly wrong",
       .about = "The same, a fifth of the depth apart.",
       .driven = {{"wrong matches [%]"}, {0, 10, 20, 30, 40, 50, 60, 70, 80, 90}, 10, 90},
       .error = Log("direction of the motion is off by [degrees]"),
       .trial = [](double percent, unsigned seed) { return MotionOf({.outliers = percent / 100}, seed); },
       .rarely_wrong = 0.05,
       .why_wrong =
           "wrong matches that agree with another motion may be as many as the right ones that do not."});

CURVE(one_view_danger_cylinder,
      {.stage = "One view",
       .title = "A camera on the danger cylinder",
       .about = R"(60 points in three small places on a circle, half a pixel of noise, a tenth of the
  matches wrong; the camera stands beside the cylinder over that circle, where the pose of three points is
  loose. Right: the centre is off by less than 3 % of the distance. No pose, or a predicted error above 1 %
  (a quality below one half), says so.)",
       .driven = {Log("distance from the cylinder [% of its radius]"),
                  {200, 100, 50, 20, 10, 5, 2, 1, 0.1},
                  100,
                  0.1},
       .error = Log("the centre is off by [% of the distance]"),
       .trial = [](double percent, unsigned seed) { return SeesThreePlaces(0.05, percent / 100, seed); }});

CURVE(one_view_three_places,
      {.stage = "One view",
       .title = "Places that become three points",
       .about =
           "The same points off the cylinder, while the places shrink: three points have up to four poses.",
       .driven = {Log("size of the places [% of the circle's radius]"),
                  {50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1},
                  10,
                  0.1},
       .error = Log("the centre is off by [% of the distance]"),
       .trial = [](double percent, unsigned seed) { return SeesThreePlaces(percent / 100, 1, seed); }});

CURVE(one_view_collinear,
      {.stage = "One view",
       .title = "Points that come to lie on a line",
       .about = R"(60 points along a line and across it, from one and a half times its length; noise, wrong
  matches, what is right and what is said are those of the danger cylinder.)",
       .driven =
           {Log("spread across the line [% of its length]"), {50, 20, 10, 5, 2, 1, 0.5, 0.1, 0.01}, 50, 0.01},
       .error = Log("the centre is off by [% of the distance]"),
       .trial = [](double percent, unsigned seed) { return NearlyCollinear(percent / 100, seed); }});

CURVE(
    adjustment_wrong_observations,
    {.stage = "Adjustment",
     .title = "Observations that are mostly wrong",
     .about = std::string("Twelve views on an arc that all see 150 points, half a pixel of noise, wrong ones "
                          "anywhere; poses and points begin off by 1 % of the distance and 0.6 degrees.") +
              kAdjustedRight,
     .driven = {{"wrong observations [%]"}, {0, 10, 20, 30, 40, 50, 60, 70, 80, 90}, 10, 90},
     .error = Log("centres are off by [% of the distance]"),
     .trial = [](double percent, unsigned seed) { return Adjusted({.outliers = percent / 100}, seed); }});

CURVE(adjustment_little_overlap,
      {.stage = "Adjustment",
       .title = "Views that hardly overlap",
       .about = R"(Twelve views on an arc that see 150 points each, which fewer and fewer neighbours see as
  well (by twos, views hang together like hinges); a fiftieth of the observations wrong. Right and said: as
  with wrong observations.)",
       .driven = {{"neighbouring views that see a point"}, {12, 10, 8, 7, 6, 5, 4, 3, 2}, 12, 2},
       .error = Log("centres are off by [% of the distance]"),
       .trial = [](double views, unsigned seed) {
         return Adjusted({.views_a_point = static_cast<int>(views)}, seed);
       }});

CURVE(
    adjustment_far_start,
    {.stage = "Adjustment",
     .title = "A start that is far off",
     .about =
         R"(Twelve views that all see 150 points. Poses and points begin off, each its own way, and turned
  by as many hundredths of a radian. Right and said: as with wrong observations.)",
     .driven = {Log("the start is off by [% of the distance]"), {0.3, 1, 3, 10, 20, 30, 50, 70, 100}, 1, 100},
     .error = Log("centres are off by [% of the distance]"),
     .trial = [](double percent, unsigned seed) { return Adjusted({.start = percent / 100}, seed); },
     .rarely_wrong = 0.05,
     .why_wrong = kFalseMinimum});

CURVE(adjustment_few_views,
      {.about = "Views 4.6 degrees apart that all see 150 points. Of two views a similarity leaves nothing "
                "over, hence three at least.",
       .driven = {Log("views"), {24, 12, 8, 6, 5, 4, 3}, 12, 3},
       .trial =
           [](double views, unsigned seed) {
             return Adjusted({.views = static_cast<int>(views), .views_a_point = static_cast<int>(views)},
                             seed);
           },
       .never_breaks = "three views that all see 150 points hold together",
       .rarely_wrong = 0.05,
       .why_wrong = kFalseMinimum});

CURVE(
    adjustment_free_gauge,
    {.stage = "Adjustment",
     .title = "Nothing held, ever farther from the origin",
     .about =
         R"(Twelve views that all see 150 points; place, turn and scale of the whole are free. Right is also
  that with one view held the same comes of it, to 0.03 % of the distance. Otherwise as with wrong
  observations.)",
     .driven = {Log("the scene is away from the origin by [its distance from the views]"),
                {1, 1e2, 1e4, 1e6, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13},
                1,
                1e11},
     .error = Log("centres are off by [% of the distance]"),
     .trial = AdjustedFreely,
     .wrong_from = 1e12,
     .why_wrong = "so far away a double no longer tells places apart to 0.03 % of the distance, and nothing "
                  "asks how far the origin is."});

}  // namespace
}  // namespace ulf::test
