// Two views that tell little of their motion, one view of points that tell little of its pose, and
// adjustments of views that hardly hold together. Scenes are drawn; matches are off by half a pixel.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/similarity3.h"
#include "tests/stability/curve.h"
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
const std::string kAdjustedRight =
    " Right: the centres are off by less than 0.3 % of the distance (root mean square after one similarity). "
    "What is off by more says so by what `ulf refine` tells: that nothing usable came of it, that it did not "
    "settle, that most points of a view disagree, or a standard deviation of the centres of a third of that "
    "and more.";
constexpr const char* kFalseMinimum =
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

// RMS distance of the centres from the truth after one similarity, % of the distance.
double CentresOff_pct(const BundleProblem& found, const BundleProblem& truth) {
  std::vector<Vector3d> a, b;
  for (std::size_t c = 0; c < truth.cam_from_world.size(); ++c) {
    a.push_back(found.cam_from_world[c].OriginInSource());
    b.push_back(truth.cam_from_world[c].OriginInSource());
  }
  const auto aligned = AlignPoints(a, b);
  if (!aligned) return kNone;
  double squared = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squared += (*aligned * a[i] - b[i]).squaredNorm();
  return 100 * std::sqrt(squared / static_cast<double>(a.size())) / kDistance;
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

}  // namespace

std::vector<Curve> GeometryCurves() {
  std::vector<Curve> curves;
  {
    Curve c;
    c.name = "two_views_near_planar";
    c.stage = "Two views";
    c.title = "A scene that becomes a plane";
    c.about =
        "300 matches between two views a fifth of the depth apart, 0.5 px of noise, a tenth of them wrong; "
        "the scene is a slanted plane with relief. Right: turned within 1 degree, moved within 10 degrees; "
        "any outcome but \"found\" says that there is no answer.";
    c.difficulty = "relief of the scene [% of its depth]";
    c.logarithmic = true;
    c.values = {100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1};
    c.easy = 50;
    c.hard = 0.1;
    c.error = "direction of the motion is off by [degrees]";
    c.trial = [](double percent, unsigned seed) { return MotionOf({.relief = percent / 100}, seed); };
    curves.push_back(c);

    c.name = "two_views_near_rotation";
    c.title = "A camera that hardly moves, only turns";
    c.about =
        "300 matches between two views of a deep scene, 0.5 px of noise, a tenth of them wrong; 0.01 % "
        "stands for a camera that turns and does not move. Right: turned within 1 degree, moved within 10 "
        "degrees; any outcome but \"found\" says that there is no answer.";
    c.difficulty = "distance between the views [% of the depth]";
    c.values = {30, 20, 10, 5, 3, 2, 1, 0.5, 0.1, 0.01};
    c.easy = 20;
    c.hard = 0.01;
    c.trial = [](double percent, unsigned seed) { return MotionOf({.baseline = percent / 100}, seed); };
    curves.push_back(c);

    c.name = "two_views_wrong_matches";
    c.title = "Matches that are mostly wrong";
    c.about =
        "300 matches between two views of a deep scene a fifth of the depth apart, 0.5 px of noise. Right: "
        "turned within 1 degree, moved within 10 degrees; any outcome but \"found\" says that there is no "
        "answer.";
    c.difficulty = "wrong matches [%]";
    c.logarithmic = false;
    c.values = {0, 10, 20, 30, 40, 50, 60, 70, 80, 90};
    c.easy = 10;
    c.hard = 90;
    c.rarely_wrong = 0.05;
    c.why_wrong =
        "where a fifth of the matches are right, wrong ones that happen to agree with another motion may be "
        "as "
        "many as the right ones that do not.";
    c.trial = [](double percent, unsigned seed) { return MotionOf({.outliers = percent / 100}, seed); };
    curves.push_back(c);
  }
  {
    Curve c;
    c.name = "one_view_danger_cylinder";
    c.stage = "One view";
    c.title = "A camera on the danger cylinder";
    c.about =
        "60 points in three places, each a twentieth as large as the circle through them, seen from two to "
        "four radii away and beside the cylinder over that circle, where the pose of three points is loose; "
        "0.5 px of noise, a tenth of the matches wrong. Right: the centre is off by less than 3 % of the "
        "distance; no pose, or a predicted error of more than 1 % (where a live pose's quality falls below "
        "one half) says so.";
    c.difficulty = "distance from the cylinder [% of its radius]";
    c.logarithmic = true;
    c.values = {200, 100, 50, 20, 10, 5, 2, 1, 0.1};
    c.easy = 100;
    c.hard = 0.1;
    c.error = "the centre is off by [% of the distance]";
    c.trial = [](double percent, unsigned seed) { return SeesThreePlaces(0.05, percent / 100, seed); };
    curves.push_back(c);

    c.name = "one_view_three_places";
    c.title = "Points in three places that become three points";
    c.about =
        "60 points in three places on a circle, seen from two to four radii away, while the places shrink: "
        "three points have up to four poses; 0.5 px of noise, a tenth of the matches wrong. Right: the "
        "centre is off by less than 3 % of the distance; no pose, or a predicted error of more than 1 % "
        "(where a live pose's quality falls below one half) says so.";
    c.difficulty = "size of the places [% of the circle's radius]";
    c.values = {50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1};
    c.easy = 10;
    c.hard = 0.1;
    c.trial = [](double percent, unsigned seed) { return SeesThreePlaces(percent / 100, 1, seed); };
    curves.push_back(c);

    c.name = "one_view_collinear";
    c.title = "Points that come to lie on a line";
    c.about =
        "60 points spread along a line and across it, seen from one and a half times its length, 0.5 px of "
        "noise, a tenth of the matches wrong. Right: the centre is off by less than 3 % of the distance; a "
        "predicted error of more than 1 %, where a live pose's quality falls below one half, says that the "
        "pose is doubtful.";
    c.difficulty = "spread across the line [% of its length]";
    c.values = {50, 20, 10, 5, 2, 1, 0.5, 0.1, 0.01};
    c.easy = 50;
    c.hard = 0.01;
    c.trial = [](double percent, unsigned seed) { return NearlyCollinear(percent / 100, seed); };
    curves.push_back(c);
  }
  {
    Curve c;
    c.name = "adjustment_wrong_observations";
    c.stage = "Adjustment";
    c.title = "Observations that are mostly wrong";
    c.about =
        "Twelve views on an arc and 150 points that all of them see, 0.5 px of noise, wrong ones anywhere in "
        "the picture; poses and points begin 1 % of the distance and 0.6 degrees off, nothing is held." +
        kAdjustedRight;
    c.difficulty = "wrong observations [%]";
    c.values = {0, 10, 20, 30, 40, 50, 60, 70, 80, 90};
    c.easy = 10;
    c.hard = 90;
    c.error = "centres are off by [% of the distance]";
    c.trial = [](double percent, unsigned seed) { return Adjusted({.outliers = percent / 100}, seed); };
    curves.push_back(c);

    c.name = "adjustment_little_overlap";
    c.title = "Views that hardly overlap";
    c.about =
        "Twelve views on an arc, each of which sees 150 points, that fewer and fewer neighbours see as well "
        "(by twos, views hang together like hinges); 0.5 px of noise, a fiftieth of the observations wrong." +
        kAdjustedRight;
    c.difficulty = "neighbouring views that see a point";
    c.values = {12, 10, 8, 7, 6, 5, 4, 3, 2};
    c.easy = 12;
    c.hard = 2;
    c.trial = [](double views, unsigned seed) {
      return Adjusted({.views_a_point = static_cast<int>(views)}, seed);
    };
    curves.push_back(c);

    c.name = "adjustment_far_start";
    c.title = "A start that is far off";
    c.about =
        "Twelve views on an arc that all see 150 points; 0.5 px of noise, a fiftieth of the observations "
        "wrong, nothing held. Poses and points begin off, each in a direction of its own, and turned by as "
        "many hundredths of a radian." +
        kAdjustedRight;
    c.difficulty = "the start is off by [% of the distance]";
    c.logarithmic = true;
    c.values = {0.3, 1, 3, 10, 20, 30, 50, 70, 100};
    c.easy = 1;
    c.hard = 100;
    c.rarely_wrong = 0.05;
    c.why_wrong = kFalseMinimum;
    c.trial = [](double percent, unsigned seed) { return Adjusted({.start = percent / 100}, seed); };
    curves.push_back(c);

    c.name = "adjustment_few_views";
    c.title = "Fewer and fewer views";
    c.about =
        "Views 4.6 degrees apart on an arc that all see 150 points; 0.5 px of noise, a fiftieth of the "
        "observations wrong, nothing held. Of two views a similarity leaves nothing over, hence three at "
        "least." +
        kAdjustedRight;
    c.difficulty = "views";
    c.values = {24, 12, 8, 6, 5, 4, 3};
    c.easy = 12;
    c.hard = 3;
    c.never_breaks = "three views that all see 150 points hold together";
    c.trial = [](double views, unsigned seed) {
      return Adjusted({.views = static_cast<int>(views), .views_a_point = static_cast<int>(views)}, seed);
    };
    curves.push_back(c);

    c.name = "adjustment_free_gauge";
    c.title = "Nothing held, ever farther from the origin";
    c.about =
        "Twelve views on an arc that all see 150 points; 0.5 px of noise, a fiftieth of the observations "
        "wrong; place, turn and scale of the whole are free. Right is also that with one view held the same "
        "comes of it, to 0.03 % of the distance after one similarity." +
        kAdjustedRight;
    c.difficulty = "the scene is away from the origin by [its distance from the views]";
    c.values = {1, 1e2, 1e4, 1e6, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13};
    c.easy = 1;
    c.hard = 1e11;
    c.never_breaks.clear();
    c.rarely_wrong = 0;
    c.wrong_from = 1e12;
    c.why_wrong =
        "so far away a double no longer tells places apart to 0.03 % of the distance, and nothing asks how "
        "far "
        "the origin is.";
    c.error = "centres are off by [% of the distance]";
    c.trial = [](double away, unsigned seed) { return AdjustedFreely(away, seed); };
    curves.push_back(c);
  }
  return curves;
}

}  // namespace ulf::test
