// Where the renderer's geometry ends: viewpoints on exact circles, many viewpoints in one place, vertices of
// any valence, a virtual camera that goes through an uneven shell, a subject that was seen from one side.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <random>
#include <set>

#include "core/base/quantile.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/make_field.h"
#include "render/fields/mesh_field.h"
#include "render/renderer/reference_renderer.h"
#include "render/stereo/depth_fusion.h"
#include "render/stereo/depth_range.h"
#include "render/stereo/proxy_builder.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/view_selection.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/stability/curve.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastShown = 1e-16;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

class SceneDraw {
 public:
  explicit SceneDraw(unsigned seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double Normal() { return std::normal_distribution<double>()(random_); }
  int Whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vector3d Normals() { return {Normal(), Normal(), Normal()}; }
  Vector3d Direction() { return Normals().normalized(); }
  // Evenly within an angle of a direction.
  Vector3d Within(const Vector3d& axis, double angle) {
    const double z = Uniform(std::cos(angle), 1), turn = Uniform(0, 2 * M_PI);
    const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
    return z * axis + std::sqrt(1 - z * z) * (std::cos(turn) * x + std::sin(turn) * y);
  }
  Quaterniond Rotation() { return Quaterniond(Normal(), Normal(), Normal(), Normal()).normalized(); }

 private:
  std::mt19937 random_;
};

// ---- weights of views, and whether they jump

// Without photographs: for weights alone.
std::shared_ptr<const RenderScene> SceneOf(const std::vector<Vector3d>& viewpoints, const Subject& subject) {
  auto scene = std::make_shared<RenderScene>();
  scene->subject = subject;
  for (const Vector3d& center : viewpoints) {
    SceneView& view = scene->views.emplace_back();
    view.id = static_cast<int>(scene->views.size()) - 1;
    view.center_in_world = center;
  }
  scene->MakeMesh();
  return scene;
}

// All views' weights.
VectorXd WeightsOf(const PlacedField& here, const Vector3d& ray, std::size_t views) {
  FieldSample sample;
  here.Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
  VectorXd weights = VectorXd::Zero(static_cast<Eigen::Index>(views));
  for (const ViewWeight& entry : sample.weights) weights(entry.view) += entry.weight;
  return weights;
}

// How far weights are from being finite, none negative, one in all.
double OffWhole(const VectorXd& weights) {
  const double off = std::max(std::abs(weights.sum() - 1), -weights.minCoeff());
  return std::isfinite(off) ? off : 1;
}

// The most that weights change at once on a way from 0 to 1. What changes the most is cut in two until it no
// longer matters, or until it does not go away however short the step.
template <typename Weights>
double LargestJump(const Weights& weights_at, int steps) {
  constexpr double kUnseen = 0.005, kShortest = 1e-10;
  constexpr int kMostCuts = 4000;
  struct Step {
    double change, from, to;
    VectorXd before, behind;
    bool operator<(const Step& other) const { return change < other.change; }
  };
  std::priority_queue<Step> by_change;
  const auto add = [&](double from, const VectorXd& before, double to, const VectorXd& behind) {
    by_change.push({(behind - before).template lpNorm<Eigen::Infinity>(), from, to, before, behind});
  };
  VectorXd before = weights_at(0.0);
  for (int i = 1; i <= steps; ++i) {
    const VectorXd behind = weights_at(static_cast<double>(i) / steps);
    add(static_cast<double>(i - 1) / steps, before, static_cast<double>(i) / steps, behind);
    before = behind;
  }
  for (int cuts = 0; cuts < kMostCuts; ++cuts) {
    const Step step = by_change.top();
    if (step.change <= kUnseen || step.to - step.from < kShortest) break;
    by_change.pop();
    const double middle = 0.5 * (step.from + step.to);
    const VectorXd between = weights_at(middle);
    add(step.from, step.before, middle, between);
    add(middle, between, step.to, step.behind);
  }
  return by_change.top().change;
}

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

FieldOptions FieldOf(unsigned seed) {
  return seed % 2 == 0 ? FieldOptions{.kind = FieldKind::kLinear, .level = 0} : FieldOptions{};
}

// Jumps that nobody sees: less than a grey level where two photographs differ by fifty.
constexpr double kNoticed = 0.02;

Curve Cocircular() {
  Curve curve;
  curve.name = "viewpoints_on_circles";
  curve.stage = "Viewpoint mesh";
  curve.title = "Viewpoints that lie on circles ever more exactly";
  curve.about =
      "Rings about a pole, meridians, grids on a cube, moved by a share of their spacing; right is a "
      "mesh that is manifold, faces outward, has no needles and encloses every direction once, weights "
      "that sum to one within a millionth and do not jump by 0.02 along an arc. Lumigraph weights "
      "instead of a mesh say so.";
  curve.difficulty = "decimal digits to which they do";
  curve.values = {1, 2, 3, 4, 6, 8, 10, 12, 14, 16};
  curve.easy = 1;
  curve.hard = 16;
  curve.never_breaks = "at 16 digits they lie on the circles exactly";
  curve.error = "weights' sum off one, or their jump";
  curve.trial = [](double digits, unsigned seed) {
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
  };
  return curve;
}

// ---- many views in one place

Curve RepeatedViews() {
  Curve curve;
  curve.name = "views_repeated";
  curve.stage = "Viewpoint mesh";
  curve.title = "Several views from each place";
  curve.about =
      "40 places on a cap, each with so many views that a hand's tremor of a thousandth of the places' "
      "spacing sets apart (every third seed: nothing at all); right is when a place weighs what its one view "
      "would, within 0.05, and "
      "weights sum to one. A mesh that still folds or none at all, in `ulf render`'s words, says so.";
  curve.difficulty = "views at each place";
  curve.logarithmic = true;
  curve.values = {1, 2, 4, 6, 7, 8, 10, 15, 30, 60};
  curve.easy = 2;
  curve.hard = 30;
  curve.never_breaks = "views within a hand's tremor become one vertex, however many";
  curve.error = "change of a place's weight";
  curve.trial = [](double copies, unsigned seed) {
    constexpr int kPlaces = 40;
    constexpr double kHalfAngle = 0.7, kTremor = 1e-3, kMostChange = 0.05;
    const std::size_t each = static_cast<std::size_t>(copies);
    SceneDraw draw(seed);
    const double spacing = std::sqrt(2 * M_PI * (1 - std::cos(kHalfAngle)) / kPlaces);
    const std::vector<Vector3d> places = CapViewpoints(kPlaces, kHalfAngle, 1, 0.05, seed);
    std::vector<Vector3d> viewpoints;
    for (const Vector3d& place : places)
      for (std::size_t i = 0; i < each; ++i)
        viewpoints.push_back(place + (each > 1 && seed % 3 != 0 ? kTremor * spacing : 0) * draw.Normals());
    const Subject subject{Vector3d::Zero(), 0.1};
    const auto once = SceneOf(places, subject), repeated = SceneOf(viewpoints, subject);
    if (repeated->mesh.span != Span::kSurface || repeated->mesh.folds_remain)
      return Trial{Verdict::kSaidSo, 0};
    const auto field_once = MakeField(once, FieldOf(seed)), field = MakeField(repeated, FieldOf(seed));
    double off = 0, change = 1e-4;  // 1e-4 is shown for all that is less
    for (int i = 0; i < 60; ++i) {
      const Vector3d v = draw.Uniform(0.5, 1.8) * draw.Within(Vector3d::UnitZ(), 0.8 * kHalfAngle);
      const Vector3d ray = (subject.radius * draw.Direction() - v).normalized();
      const VectorXd weights = WeightsOf(*field->From(v), ray, viewpoints.size());
      off = std::max(off, OffWhole(weights));
      const VectorXd of_places = weights.reshaped(static_cast<Eigen::Index>(each), kPlaces).colwise().sum();
      change = std::max(
          change, (of_places - WeightsOf(*field_once->From(v), ray, kPlaces)).lpNorm<Eigen::Infinity>());
    }
    return Trial{off < 1e-6 && change < kMostChange ? Verdict::kRight : Verdict::kWrong,
                 std::max(off < 1e-6 ? 0 : off, change)};
  };
  return curve;
}

// ---- a twin beside every view

double RmsDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(3.0 * static_cast<double>(a.total()));
}

Curve TwinViews() {
  Curve curve;
  curve.name = "views_with_twins";
  curve.stage = "Blending";
  curve.title = "Pairs of views that come together";
  curve.about =
      "60 views of a painted plane, each with a twin beside it; a picture from between them, by the "
      "reference renderer. Right is an error against the true picture at most 1.2 times that without the "
      "twins, every pixel drawn. Lumigraph weights instead of a mesh say so.";
  curve.difficulty = "decades from the views' spacing down to the twins' distance";
  curve.values = {0.6, 0.9, 0.95, 1, 1.05, 1.2, 2, 4, 6, 9, 12};
  curve.easy = 2;
  curve.hard = 12;
  curve.never_breaks = "nearer together is the same place to double precision";
  curve.error = "picture's error over that without";
  curve.logarithmic_error = false;
  curve.seeds = 10;
  curve.trial = [](double decades, unsigned seed) {
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
    const Vector3d v = kDistance * draw.Uniform(0.6, 1.5) * draw.Within(Vector3d::UnitZ(), 0.7 * kHalfAngle);
    const Rigid3 pose = LookAt(v, Vector3d::Zero(), Vector3d::UnitY());
    const cv::Mat truth = LightOfPlane(camera, pose);
    const RenderOptions options{.field = FieldOf(seed)};
    const Rendering alone = ReferenceRenderer(without, options).Render(camera, pose);
    const Rendering picture = ReferenceRenderer(with, options).Render(camera, pose);
    const double worse = RmsDifference(picture.linear, truth) / RmsDifference(alone.linear, truth);
    const bool right = worse <= kMostWorse && picture.empty_px <= alone.empty_px;
    return Trial{right ? Verdict::kRight : Verdict::kWrong, worse};
  };
  return curve;
}

// ---- valences

struct Fan {
  std::vector<Vector3d> positions;  // the hub first, then its ring
  std::vector<Triangle> triangles;
};

// A vertex of this valence inside, or as a corner of the rim; around it neighbours of valence 5 to 7.
Fan FanOf(int valence, bool inside, SceneDraw& draw) {
  Fan fan;
  const double whole = inside ? 2 * M_PI : 1.5 * M_PI;
  const int sectors = inside ? valence : valence - 1;
  const auto place = [&](double radius, double sector) {
    const double turn = whole * sector / sectors;
    fan.positions.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 0);
    return static_cast<int>(fan.positions.size()) - 1;
  };
  place(0, 0);
  for (int k = 0; k < valence; ++k) place(1, k);
  std::vector<std::vector<int>> outer(At(valence));
  for (int k = 0; k < valence; ++k) {
    // The last of an open fan has no sector of its own.
    const int count = inside || k + 1 < valence ? draw.Whole(1, 3) : 1;
    for (int i = 0; i < count; ++i) outer[At(k)].push_back(place(2, k + (i + 0.5) / (count + 1)));
  }
  for (int k = 0; k < sectors; ++k) {
    const int next = (k + 1) % valence, own = 1 + k, behind = 1 + next;
    const std::vector<int>& beyond = outer[At(k)];
    for (std::size_t i = 0; i + 1 < beyond.size(); ++i)
      fan.triangles.push_back({own, beyond[i], beyond[i + 1]});
    fan.triangles.push_back({0, own, behind});
    fan.triangles.push_back({own, beyond.back(), outer[At(next)].front()});
    fan.triangles.push_back({own, outer[At(next)].front(), behind});
  }
  return fan;
}

VectorXd Dense(const SparseWeights& weights, std::size_t vertices) {
  VectorXd dense = VectorXd::Zero(static_cast<Eigen::Index>(vertices));
  for (const auto& [vertex, weight] : weights) dense(vertex) += weight;
  return dense;
}

// What a vertex's own weights and the sum of its neighbours' become by so many levels of Loop's rules with
// Warren's weights, which see nothing else: shares of both in the vertex. On the first level the corners
// beside an edge may have another share in its middle than an eighth.
std::pair<double, double> AfterLevels(int valence, int levels, double first_beside = 0.125) {
  const double n = valence, beta = valence == 3 ? 3.0 / 16 : 3 / (8 * n);
  Eigen::Matrix2d all = Eigen::Matrix2d::Identity();
  for (int i = 0; i < levels; ++i) {
    const double beside = i == 0 ? first_beside : 0.125;
    Eigen::Matrix2d level;
    level << 1 - n * beta, beta, n * (0.5 - beside), 0.5 + beside;
    all = level * all;
  }
  return {all(0, 0), all(0, 1)};
}

// Of the corners beside an edge from the hub of a closed fan: an eighth where the angles that face the edge
// sum to 120 degrees or less, a quarter at 180.
double FirstBeside(int valence) {
  const double facing = M_PI - 2 * M_PI / valence;
  return 0.125 + 0.125 * std::clamp((facing - 2 * M_PI / 3) / (M_PI / 3), 0.0, 1.0);
}

// What any level must keep: whole weights, only of the two rings around, straight rims.
double OffWhatALevelKeeps(const Fan& fan, const SubdividedMesh& fine) {
  const std::size_t vertices = fan.positions.size();
  const TriangleTopology coarse = MakeTopology(static_cast<int>(vertices), fan.triangles);
  const TriangleTopology topology = MakeTopology(static_cast<int>(fine.positions.size()), fine.triangles);
  double most = 0;
  for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
    std::set<int> reach;
    for (const int corner : fan.triangles[At(fine.parent[t])]) {
      reach.insert(corner);
      reach.insert(coarse.neighbours[At(corner)].begin(), coarse.neighbours[At(corner)].end());
    }
    for (const int vertex : fine.triangles[t])
      for (const auto& [of, weight] : fine.weights[At(vertex)])
        if (reach.count(of) == 0) most = std::max(most, std::abs(weight));
  }
  for (std::size_t v = 0; v < fine.positions.size(); ++v) {
    most = std::max(most, OffWhole(Dense(fine.weights[v], vertices)));
    if (!topology.OnBoundary(static_cast<int>(v))) continue;
    Vector3d place = Vector3d::Zero();
    for (const auto& [of, weight] : fine.weights[v]) place += weight * fan.positions[At(of)];
    most = std::max(most, (place - fine.positions[v]).norm());
  }
  return most;
}

Curve Valences() {
  Curve curve;
  curve.name = "subdivision_valence";
  curve.stage = "Blending";
  curve.title = "Loop weights at vertices of any valence";
  curve.about =
      "A vertex of this valence, inside (odd seeds) or a corner of the rim, among irregular neighbours; "
      "right is that all levels' weights are not negative, sum to one, reach two rings, keep the rim "
      "straight and equal the rules applied by hand, all within 1e-12. Nothing would say so.";
  curve.difficulty = "valence";
  curve.values = {3, 4, 5, 6, 7, 8, 12, 20, 40};
  curve.easy = 6;
  curve.hard = 20;
  curve.never_breaks = "the rules hold for any valence";
  curve.error = "weights off the rules";
  curve.seeds = 6;
  curve.trial = [](double valence_as_drawn, unsigned seed) {
    const int valence = static_cast<int>(valence_as_drawn);
    const bool inside = seed % 2 == 1;
    SceneDraw draw(seed);
    const Fan fan = FanOf(valence, inside, draw);
    const std::size_t vertices = fan.positions.size();
    const std::vector<Vector3d> outward(vertices, Vector3d::Zero());
    double most = kLeastShown;
    std::vector<SubdividedMesh> levels;
    const auto off_hub = [&](const SparseWeights& of_hub, int level_count) {
      const auto [own, each] =
          inside ? AfterLevels(valence, level_count, FirstBeside(valence)) : std::pair(1.0, 0.0);
      VectorXd expected = VectorXd::Zero(static_cast<Eigen::Index>(vertices));
      expected(0) = own;
      expected.segment(1, valence).setConstant(each);
      return (Dense(of_hub, vertices) - expected).lpNorm<Eigen::Infinity>();
    };
    for (const int level : {1, 2, 3}) {
      levels.push_back(SubdivideWeights(fan.positions, outward, fan.triangles, level));
      most = std::max(most, OffWhatALevelKeeps(fan, levels.back()));
      most = std::max(most, off_hub(levels.back().weights[0], level));
    }
    return Trial{most < 1e-12 ? Verdict::kRight : Verdict::kWrong, most};
  };
  return curve;
}

// ---- through the shell of viewpoints

constexpr const char* kWhateverTheDistances =
    "a viewpoint that the camera passes goes on weighing the same, whatever the distances";

Curve ThroughTheShell() {
  Curve curve;
  curve.name = "through_the_shell";
  curve.stage = "Blending";
  curve.title = "Moving in through an uneven shell of viewpoints";
  curve.about =
      "120 viewpoints 7 degrees apart, their distances at random between one and this ratio; the virtual "
      "camera moves in along a ray, every third exactly through a viewpoint, from 1.5 times the farthest "
      "to 0.3 of the nearest. Right is that no view's weight at any of nine points of the subject jumps "
      "by 0.02, however short the step, and that weights sum to one. A mesh that still folds says so.";
  curve.difficulty = "farthest over nearest viewpoint";
  curve.logarithmic = true;
  curve.values = {1, 1.02, 1.05, 1.1, 1.2, 1.4, 2, 3, 4, 6, 8, 12};
  curve.easy = 1.02;
  curve.hard = 12;
  curve.never_breaks = kWhateverTheDistances;
  curve.error = "largest jump of a weight (0.005: or less)";
  curve.logarithmic_error = false;
  curve.trial = [](double ratio, unsigned seed) {
    constexpr int kViews = 120;
    constexpr double kHalfAngle = 0.8;
    SceneDraw draw(seed);
    const Subject subject{Vector3d::Zero(), 0.2};
    std::vector<Vector3d> viewpoints = CapViewpoints(kViews, kHalfAngle, 1);
    for (Vector3d& viewpoint : viewpoints) viewpoint *= draw.Uniform(1, ratio);
    const auto scene = SceneOf(viewpoints, subject);
    if (scene->mesh.span != Span::kSurface || scene->mesh.folds_remain) return Trial{Verdict::kSaidSo, 0};
    const auto field = MakeField(scene, FieldOf(seed));
    Vector3d way = draw.Within(Vector3d::UnitZ(), 0.7 * kHalfAngle);
    // Every third goes exactly through the nearest viewpoint.
    if (seed % 3 == 0)
      way = std::max_element(viewpoints.begin(), viewpoints.end(), [&](const Vector3d& a, const Vector3d& b) {
              return a.normalized().dot(way) < b.normalized().dot(way);
            })->normalized();
    std::vector<Vector3d> targets{Vector3d::Zero()};
    for (int i = 0; i < 8; ++i) targets.push_back(0.9 * subject.radius * draw.Direction());
    double off = 0;
    const auto weights_at = [&](double share) {
      const Vector3d v = (1.5 * ratio + share * (0.3 - 1.5 * ratio)) * way;
      const auto here = field->From(v);
      VectorXd all(kViews * static_cast<Eigen::Index>(targets.size()));
      for (std::size_t i = 0; i < targets.size(); ++i) {
        const VectorXd weights = WeightsOf(*here, (targets[i] - v).normalized(), kViews);
        off = std::max(off, OffWhole(weights));
        all.segment(static_cast<Eigen::Index>(i) * kViews, kViews) = weights;
      }
      return all;
    };
    const double jump = std::max(LargestJump(weights_at, 100), off < 1e-6 ? 0 : off);
    return Trial{jump < kNoticed ? Verdict::kRight : Verdict::kWrong, jump};
  };
  return curve;
}

// The picture itself, by the reference renderer. Every photograph is of one brightness, so that nothing
// changes but what the views weigh.
Curve PictureThroughTheShell() {
  Curve curve;
  curve.name = "picture_through_the_shell";
  curve.stage = "Blending";
  curve.title = "A picture while moving in through an uneven shell of viewpoints";
  curve.about =
      "60 viewpoints 10 degrees apart, their distances at random between one and this ratio, each photograph "
      "of "
      "one brightness; the reference renderer's picture of 8 x 6 px of the subject while the camera moves in "
      "along a ray, from 1.5 times the farthest to 0.3 of the nearest. Right is that no pixel jumps by 0.02 "
      "of "
      "full light, however short the step. A mesh that still folds says so.";
  curve.difficulty = "farthest over nearest viewpoint";
  curve.logarithmic = true;
  curve.values = {1, 1.02, 1.05, 1.1, 1.2, 1.4, 2, 3, 4, 6, 8, 12};
  curve.easy = 1.1;
  curve.hard = 12;
  curve.never_breaks = kWhateverTheDistances;
  curve.error = "largest jump of a pixel (0.005: or less)";
  curve.logarithmic_error = false;
  curve.trial = [](double ratio, unsigned seed) {
    constexpr int kViews = 60;
    constexpr double kHalfAngle = 0.8;
    SceneDraw draw(seed);
    SceneSpec spec{.viewpoints = CapViewpoints(kViews, kHalfAngle, 1),
                   .width = 32,
                   .height = 32,
                   .focal_px = 32,
                   .subject = {Vector3d::Zero(), 0.2}};
    for (Vector3d& viewpoint : spec.viewpoints) viewpoint *= draw.Uniform(1, ratio);
    const auto scene = MakeScene(spec);
    if (scene->mesh.span != Span::kSurface || scene->mesh.folds_remain) return Trial{Verdict::kSaidSo, 0};
    for (SceneView& view : scene->views)
      view.photograph = test::HoldPhotograph(
          MakePyramid(cv::Mat(spec.height, spec.width, CV_8UC3, cv::Scalar::all(draw.Whole(0, 255)))));
    ReferenceRenderer renderer(scene, {.field = FieldOf(seed)});
    const Vector3d way = draw.Within(Vector3d::UnitZ(), 0.7 * kHalfAngle);
    const auto picture_at = [&](double share) -> VectorXd {
      const double distance = 1.5 * ratio + share * (0.3 - 1.5 * ratio);
      const CameraModel camera = CameraModel::Pinhole(8, 6, 20 * distance);
      const cv::Mat light =
          renderer.Render(camera, LookAt(distance * way, Vector3d::Zero(), Vector3d::UnitY())).linear;
      VectorXd gray(light.total());
      for (int i = 0; i < static_cast<int>(light.total()); ++i)
        gray(i) = light.at<cv::Vec3f>(i / 8, i % 8)[1];
      return gray;
    };
    const double jump = LargestJump(picture_at, 60);
    return Trial{jump < kNoticed ? Verdict::kRight : Verdict::kWrong, jump};
  };
  return curve;
}

// ---- a subject seen from one side

// A ball or a box about the origin.
class Solid {
 public:
  Solid(unsigned seed, SceneDraw& draw)
      : is_ball_(seed % 2 == 1),
        half_(draw.Uniform(0.45, 0.65), draw.Uniform(0.45, 0.65), draw.Uniform(0.45, 0.65)),
        box_from_world_(draw.Rotation()) {}

  double DistanceTo(const Vector3d& point) const {
    if (is_ball_) return std::abs(point.norm() - 1);
    const Vector3d beyond = (box_from_world_ * point).cwiseAbs() - half_;
    return std::abs(beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff()));
  }

  // Along a ray, in its length; none past the solid.
  std::optional<double> Hit(const Vector3d& origin, const Vector3d& ray) const {
    if (is_ball_) {
      const double half_b = origin.dot(ray) / ray.squaredNorm();
      const double inside = half_b * half_b - (origin.squaredNorm() - 1) / ray.squaredNorm();
      if (inside < 0) return std::nullopt;
      return -half_b - std::sqrt(inside);
    }
    const Vector3d from = box_from_world_ * origin, along = box_from_world_ * ray;
    const Vector3d first = (-half_ - from).cwiseQuotient(along), second = (half_ - from).cwiseQuotient(along);
    const double enters = first.cwiseMin(second).maxCoeff(), leaves = first.cwiseMax(second).minCoeff();
    if (enters > leaves) return std::nullopt;
    return enters;
  }

 private:
  bool is_ball_;
  Vector3d half_;
  Quaterniond box_from_world_;
};

constexpr double kSolidDistance = 4, kNearest = 2.5, kFarthest = 5.5;

StereoView ViewOfSolid(const Vector3d& direction) {
  StereoView view;
  view.camera = CameraModel::Pinhole(120, 120, 170);
  view.center_in_world = kSolidDistance * direction;
  view.cam_from_world = LookAt(view.center_in_world, Vector3d::Zero(), direction.unitOrthogonal());
  return view;
}

// The depth map that a sweep against the neighbours would find: off by a quarter of a pixel of the neighbour
// that moves the most.
ViewDepth DepthOf(const Solid& solid, const StereoView& view,
                  const std::vector<const StereoView*>& neighbours, SceneDraw& draw) {
  constexpr double kNoisePx = 0.25;
  const InverseDepthRange range = PixelSpacedRange(view, neighbours, kNearest, kFarthest);
  double widest = 0;
  for (const StereoView* neighbour : neighbours)
    widest = std::max(widest, (neighbour->center_in_world - view.center_in_world).norm());
  ViewDepth map{view, cv::Mat::zeros(view.camera.height, view.camera.width, CV_32F),
                (range.most - range.least) / (range.planes - 1)};
  for (int y = 0; y < map.depth.rows; ++y)
    for (int x = 0; x < map.depth.cols; ++x)
      if (const auto depth = solid.Hit(view.center_in_world, view.RayInWorld(x, y))) {
        const double inverse = 1 / *depth + kNoisePx * draw.Normal() / (view.camera.fx * widest);
        map.depth.at<float>(y, x) = static_cast<float>(1 / std::clamp(inverse, range.least, range.most));
      }
  return map;
}

// The distance from the solid that nineteen twentieths of the mesh's area keep.
double MostlyWithin(const TriangleMesh& mesh, const Solid& solid) {
  std::vector<std::pair<double, double>> area_at;
  double area = 0;
  for (const auto& of : mesh.triangles) {
    const Vector3d a = mesh.vertices[of[0]].cast<double>(), b = mesh.vertices[of[1]].cast<double>(),
                   c = mesh.vertices[of[2]].cast<double>();
    area_at.emplace_back(solid.DistanceTo((a + b + c) / 3), 0.5 * (b - a).cross(c - a).norm());
    area += area_at.back().second;
  }
  std::sort(area_at.begin(), area_at.end());
  double sum = 0;
  for (const auto& [distance, size] : area_at)
    if ((sum += size) >= 0.95 * area) return distance;
  return area_at.back().first;
}

Curve MissingSides() {
  Curve curve;
  curve.name = "proxy_missing_sides";
  curve.stage = "Proxy";
  curve.title = "A mesh of what was seen from ever fewer sides";
  curve.about =
      "40 views of a ball (odd seeds) or a box, all within a cone around one side of it; depth maps a "
      "quarter of a pixel off go into `ulf proxy`'s fusion and surface. Right is that 95 % of the mesh's "
      "area lie within 5 % of the subject's radius of its surface: nothing is made up where nobody "
      "looked. No mesh, and why, or that a pixel is worth too much depth, says so.";
  curve.difficulty = "360 deg over the opening of the cone that holds the views";
  curve.logarithmic = true;
  curve.values = {1, 1.33, 2, 3, 6, 12, 24, 45, 90, 180, 360};
  curve.easy = 2;
  curve.hard = 360;
  curve.error = "distance of 95 % of the area [radii]";
  curve.seeds = 4;
  curve.trial = [](double fewer, unsigned seed) {
    constexpr double kRight = 0.05;
    SceneDraw draw(seed);
    const Solid solid(seed, draw);
    const Subject subject{Vector3d::Zero(), 1};
    const Quaterniond turn = draw.Rotation();
    std::vector<StereoView> views;
    for (const Vector3d& direction : CapViewpoints(40, M_PI / fewer, 1))
      views.push_back(ViewOfSolid(turn * direction));
    std::vector<ViewDepth> maps;
    std::vector<Vector3d> centers;
    std::vector<double> pixel_depths;
    for (std::size_t i = 0; i < views.size(); ++i) {
      std::vector<const StereoView*> neighbours;
      for (const int other : NeighboursOf(static_cast<int>(i), views, subject, {.count = 8}))
        neighbours.push_back(&views[At(other)]);
      if (neighbours.empty()) continue;
      maps.push_back(DepthOf(solid, views[i], neighbours, draw));
      centers.push_back(views[i].center_in_world);
      pixel_depths.push_back(DepthStepOfPixel(views[i], neighbours, kSolidDistance));
    }
    if (maps.empty() || Median(pixel_depths) > kRoughPixelRadii * subject.radius)
      return Trial{Verdict::kSaidSo, 0};
    std::vector<StereoView> mapped;
    for (const ViewDepth& map : maps) mapped.push_back(map.view);
    std::vector<std::vector<int>> others;
    for (std::size_t i = 0; i < mapped.size(); ++i)
      others.push_back(NeighboursOf(static_cast<int>(i), mapped, subject, {.count = 10}));
    KeepConsistentDepths(maps, others, {});
    const TriangleMesh mesh = CutSurface(FusePoints(maps, others, {}), centers);
    if (mesh.triangles.empty()) return Trial{Verdict::kSaidSo, 0};
    const double distance = MostlyWithin(mesh, solid);
    return Trial{distance < kRight ? Verdict::kRight : Verdict::kWrong, distance};
  };
  return curve;
}

}  // namespace

std::vector<Curve> RenderCurves() {
  return {Cocircular(),      RepeatedViews(),          TwinViews(),   Valences(),
          ThroughTheShell(), PictureThroughTheShell(), MissingSides()};
}

}  // namespace ulf::test
