// Viewpoints on exact circles, many in one place, and pairs that come together.
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "render/fields/mesh_field.h"
#include "render/renderer/reference_renderer.h"
#include "tests/measure/curve.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/stability/render_draw.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Matrix3d;

// ---- viewpoints on circles

// Directions of viewpoints and where they must be enclosed.
struct Pattern {
  std::vector<Vector3d> directions;
  double spacing = 0;  // radians, about
  std::function<Vector3d(SceneDraw&)> inside;
};

Vector3d OnSphere(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

Pattern RingsAboutAPole(SceneDraw& draw) {
  Pattern pattern;
  const int rings = draw.Whole(3, 6), meridians = draw.Whole(10, 20);
  pattern.spacing = draw.Uniform(4, 9) * M_PI / 180;
  pattern.directions.push_back(Vector3d::UnitZ());
  for (int ring = 1; ring <= rings; ++ring)
    for (int i = 0; i < meridians; ++i)
      pattern.directions.push_back(OnSphere(2 * M_PI * i / meridians, M_PI / 2 - ring * pattern.spacing));
  const double reach = 0.85 * rings * pattern.spacing;
  pattern.inside = [reach](SceneDraw& d) { return d.Within(Vector3d::UnitZ(), reach); };
  return pattern;
}

Pattern PatchOfMeridians(SceneDraw& draw) {
  Pattern pattern;
  const int columns = draw.Whole(2, 5), rows = draw.Whole(2, 4);  // to each side
  pattern.spacing = draw.Uniform(4, 9) * M_PI / 180;
  for (int column = -columns; column <= columns; ++column)
    for (int row = -rows; row <= rows; ++row)
      pattern.directions.push_back(OnSphere(column * pattern.spacing, row * pattern.spacing));
  const double width = 0.9 * columns * pattern.spacing, height = 0.9 * rows * pattern.spacing;
  pattern.inside = [width, height](SceneDraw& d) {
    return OnSphere(d.Uniform(-width, width), d.Uniform(-height, height));
  };
  return pattern;
}

Pattern MeridiansAllAround(SceneDraw& draw) {
  Pattern pattern;
  const int meridians = draw.Whole(8, 20), rings = draw.Whole(5, 11);
  pattern.spacing = M_PI / (rings + 1);
  pattern.directions = {Vector3d::UnitZ(), -Vector3d::UnitZ()};
  for (int ring = 1; ring <= rings; ++ring)
    for (int i = 0; i < meridians; ++i)
      pattern.directions.push_back(OnSphere(2 * M_PI * i / meridians, M_PI / 2 - ring * pattern.spacing));
  pattern.inside = [](SceneDraw& d) { return d.Direction(); };
  return pattern;
}

Pattern GridsOnACube(SceneDraw& draw) {
  Pattern pattern;
  const int side = draw.Whole(3, 6);
  std::set<std::array<int, 3>> places;
  for (int x = -side; x <= side; x += 2)
    for (int y = -side; y <= side; y += 2)
      for (const int z : {-side, side})
        for (const auto& place : {std::array{x, y, z}, {y, z, x}, {z, x, y}}) places.insert(place);
  for (const auto& [x, y, z] : places) pattern.directions.push_back(Vector3d(x, y, z).normalized());
  pattern.spacing = M_PI / 2 / side;
  pattern.inside = [](SceneDraw& d) { return d.Direction(); };
  return pattern;
}

Pattern PatternOf(unsigned seed, SceneDraw& draw) {
  constexpr std::array kPatterns{RingsAboutAPole, PatchOfMeridians, MeridiansAllAround, GridsOnACube};
  Pattern pattern = kPatterns[seed % kPatterns.size()](draw);
  if (draw.Whole(0, 1) == 0) return pattern;  // exactly along the axes
  const Quaterniond turn = draw.Rotation();
  for (Vector3d& direction : pattern.directions) direction = turn * direction;
  pattern.inside = [turn, inside = pattern.inside](SceneDraw& d) -> Vector3d { return turn * inside(d); };
  return pattern;
}

// Every edge once in each direction, triangles that face outward and are no needles, no viewpoint lost.
bool IsSound(const ViewpointMesh& mesh, std::size_t views) {
  constexpr double kNeedle = 1e-3;  // height over length
  std::set<std::pair<int, int>> edges;
  std::set<int> used;
  for (const Triangle& t : mesh.triangles) {
    Matrix3d arms;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return false;
      arms.col(static_cast<Eigen::Index>(k)) =
          (mesh.vertices[At(t[k])].position_in_world - mesh.center_in_world).normalized();
      used.insert(mesh.vertices[At(t[k])].views.begin(), mesh.vertices[At(t[k])].views.end());
    }
    if (!(arms.determinant() > 0)) return false;
    const Vector3d a = arms.col(1) - arms.col(0), b = arms.col(2) - arms.col(0);
    const double length = std::max({a.norm(), b.norm(), (a - b).norm()});
    if (!(a.cross(b).norm() > kNeedle * length * length)) return false;
  }
  return used.size() == views;
}

int TrianglesAt(const ViewpointMesh& mesh, const Vector3d& direction) {
  return static_cast<int>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    Matrix3d arms;
    for (std::size_t k = 0; k < 3; ++k)
      arms.col(static_cast<Eigen::Index>(k)) =
          mesh.vertices[At(t[k])].position_in_world - mesh.center_in_world;
    return (arms.inverse() * direction).minCoeff() > 0;
  }));
}

CURVE(viewpoints_on_circles,
      {.about = R"(Rings about a pole, meridians, grids on a cube, moved by a share of their spacing. Right:
  a mesh that is manifold, faces outward, has no needles and encloses every direction once; weights that sum
  to one within a millionth and do not jump by 0.02 along an arc. Lumigraph weights instead of a mesh say
  so.)",
       .driven = {{"decimal digits to which they do"}, {1, 2, 3, 4, 6, 8, 10, 12, 14, 16}, 1, 16},
       .trial =
           [](double digits, unsigned seed) {
             constexpr double kDistance = 2;
             SceneDraw draw(seed);
             Pattern pattern = PatternOf(seed, draw);
             // Beyond double precision: not at all.
             const double jitter = digits >= 16 ? 0 : std::pow(10, -digits) * pattern.spacing;
             std::vector<Vector3d> viewpoints;
             for (const Vector3d& direction : pattern.directions)
               viewpoints.push_back(kDistance * (direction + jitter * draw.Normals()).normalized());
             const auto scene = SceneOf(viewpoints, {Vector3d::Zero(), 0.1});
             if (scene->mesh.span != Span::kSurface) return Trial{Verdict::kSaidSo, 0};
             if (!IsSound(scene->mesh, viewpoints.size())) return Trial{Verdict::kWrong, 1};
             for (int i = 0; i < 100; ++i)
               if (TrianglesAt(scene->mesh, pattern.inside(draw)) != 1) return Trial{Verdict::kWrong, 1};

             const auto field = MakeField(scene, FieldOf(seed));
             double off = kLeastShown;
             for (int i = 0; i < 30; ++i) {
               const Vector3d v = kDistance * draw.Uniform(0.4, 2) * pattern.inside(draw);
               const Vector3d ray = (0.1 * draw.Direction() - v).normalized();
               off = std::max(off, OffWhole(WeightsOf(*field->From(v), ray, viewpoints.size())));
             }
             const Vector3d begin = pattern.inside(draw), end = pattern.inside(draw);
             const double jump = LargestJump(
                 [&](double share) {
                   const Vector3d direction = ((1 - share) * begin + share * end).normalized();
                   return WeightsOf(*field->From(1.3 * kDistance * direction), -direction, viewpoints.size());
                 },
                 100);
             if (jump > kNoticed) off = std::max(off, jump);
             return Trial{off < 1e-6 ? Verdict::kRight : Verdict::kWrong, off};
           },
       .never_breaks = "at 16 digits they lie on the circles exactly"});

// ---- many views in one place

CURVE(views_repeated,
      {.about = R"(40 places on a cap, each with so many views that a hand's tremor of a thousandth of the
  spacing sets apart (every third seed: nothing at all). Right: a place weighs what its one view would,
  within 0.05, and weights sum to one. A mesh that still folds or none at all says so.)",
       .driven = {Log("views at each place"), {1, 2, 4, 6, 7, 8, 10, 15, 30, 60}, 2, 30},
       .trial =
           [](double copies, unsigned seed) {
             constexpr int kPlaces = 40;
             constexpr double kHalfAngle = 0.7, kTremor = 1e-3, kMostChange = 0.05;
             const std::size_t each = static_cast<std::size_t>(copies);
             SceneDraw draw(seed);
             const double spacing = std::sqrt(2 * M_PI * (1 - std::cos(kHalfAngle)) / kPlaces);
             const std::vector<Vector3d> places = CapViewpoints(kPlaces, kHalfAngle, 1, 0.05, seed);
             std::vector<Vector3d> viewpoints;
             for (const Vector3d& place : places)
               for (std::size_t i = 0; i < each; ++i)
                 viewpoints.push_back(place +
                                      (each > 1 && seed % 3 != 0 ? kTremor * spacing : 0) * draw.Normals());
             const Subject subject{Vector3d::Zero(), 0.1};
             const auto once = SceneOf(places, subject), repeated = SceneOf(viewpoints, subject);
             if (repeated->mesh.span != Span::kSurface || repeated->mesh.folds_remain)
               return Trial{Verdict::kSaidSo, 0};
             const auto field_once = MakeField(once, FieldOf(seed)),
                        field = MakeField(repeated, FieldOf(seed));
             double off = 0, change = 1e-4;  // 1e-4 is shown for all that is less
             for (int i = 0; i < 60; ++i) {
               const Vector3d v = draw.Uniform(0.5, 1.8) * draw.Within(Vector3d::UnitZ(), 0.8 * kHalfAngle);
               const Vector3d ray = (subject.radius * draw.Direction() - v).normalized();
               const VectorXd weights = WeightsOf(*field->From(v), ray, viewpoints.size());
               off = std::max(off, OffWhole(weights));
               const VectorXd of_places =
                   weights.reshaped(static_cast<Eigen::Index>(each), kPlaces).colwise().sum();
               change = std::max(
                   change,
                   (of_places - WeightsOf(*field_once->From(v), ray, kPlaces)).lpNorm<Eigen::Infinity>());
             }
             return Trial{off < 1e-6 && change < kMostChange ? Verdict::kRight : Verdict::kWrong,
                          std::max(off < 1e-6 ? 0 : off, change)};
           },
       .never_breaks = "views within a hand's tremor become one vertex, however many"});

// ---- a twin beside every view

double RmsDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(3.0 * static_cast<double>(a.total()));
}

CURVE(views_with_twins,
      {.about = R"(60 views of a painted plane, each with a twin beside it; a picture from between them, by
  the reference renderer. Right: its error is at most 1.2 times that without the twins, and every pixel is
  drawn. Lumigraph weights instead of a mesh say so.)",
       .driven = {{"decades from the views' spacing down to the twins' distance"},
                  {0.6, 0.9, 0.95, 1, 1.05, 1.2, 2, 4, 6, 9, 12},
                  2,
                  12},
       .trial =
           [](double decades, unsigned seed) {
             constexpr int kViews = 60;
             constexpr double kHalfAngle = 0.6, kDistance = 2, kMostWorse = 1.2;
             SceneDraw draw(seed);
             const double spacing = std::sqrt(2 * M_PI * (1 - std::cos(kHalfAngle)) / kViews);
             SceneSpec spec{.viewpoints = CapViewpoints(kViews, kHalfAngle, kDistance, 0.03, seed),
                            .width = 80,
                            .height = 60,
                            .focal_px = 66};
             const auto without = MakeScene(spec);
             for (int i = 0; i < kViews; ++i) {
               const Vector3d center = spec.viewpoints[At(i)];
               const Vector3d aside = center.cross(draw.Direction()).normalized();
               spec.viewpoints.push_back(center + std::pow(10, -decades) * spacing * center.norm() * aside);
             }
             const auto with = MakeScene(spec);
             if (with->mesh.span != Span::kSurface) return Trial{Verdict::kSaidSo, 0};
             const CameraModel camera = CameraModel::Pinhole(48, 36, 60);
             const Vector3d v =
                 kDistance * draw.Uniform(0.6, 1.5) * draw.Within(Vector3d::UnitZ(), 0.7 * kHalfAngle);
             const Rigid3 pose = LookAt(v, Vector3d::Zero(), Vector3d::UnitY());
             const cv::Mat truth = LightOfPlane(camera, pose);
             const RenderOptions options{.field = FieldOf(seed)};
             const Rendering alone = ReferenceRenderer(without, options).Render(camera, pose);
             const Rendering picture = ReferenceRenderer(with, options).Render(camera, pose);
             const double worse = RmsDifference(picture.linear, truth) / RmsDifference(alone.linear, truth);
             const bool right = worse <= kMostWorse && picture.empty_px <= alone.empty_px;
             return Trial{right ? Verdict::kRight : Verdict::kWrong, worse};
           },
       .seeds = 10,
       .never_breaks = "nearer together is the same place to double precision"});

}  // namespace
}  // namespace ulf::test
