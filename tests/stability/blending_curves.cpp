// Blending weights at vertices of any valence, and for a virtual camera that goes through an uneven shell of
// viewpoints.
#include <algorithm>
#include <cmath>
#include <set>

#include "render/fields/mesh_field.h"
#include "render/renderer/reference_renderer.h"
#include "tests/measure/curve.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/stability/render_draw.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

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

CURVE(subdivision_valence,
      {.about = R"(A vertex of this valence, inside (odd seeds) or a corner of the rim, among irregular
  neighbours. Right, within 1e-12: weights of all levels are not negative, sum to one, reach two rings, keep
  the rim straight and equal the rules applied by hand.)",
       .driven = {{"valence"}, {3, 4, 5, 6, 7, 8, 12, 20, 40}, 6, 20},
       .trial =
           [](double valence_as_drawn, unsigned seed) {
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
           },
       .seeds = 6,
       .never_breaks = "the rules hold for any valence"});

// ---- through the shell of viewpoints

CURVE(
    through_the_shell,
    {.about = R"(120 viewpoints 7 degrees apart, their distances at random between one and this ratio; the
  virtual camera moves in along a ray, every third exactly through a viewpoint, from 1.5 times the farthest
  to 0.3 of the nearest. Right: no view's weight at any of nine points of the subject jumps by 0.02, however
  short the step, and weights sum to one. A mesh that still folds says so.)",
     .driven = {Log("farthest over nearest viewpoint"),
                {1, 1.02, 1.05, 1.1, 1.2, 1.4, 2, 3, 4, 6, 8, 12},
                1.02,
                12},
     .trial =
         [](double ratio, unsigned seed) {
           constexpr int kViews = 120;
           constexpr double kHalfAngle = 0.8;
           SceneDraw draw(seed);
           const Subject subject{Vector3d::Zero(), 0.2};
           std::vector<Vector3d> viewpoints = CapViewpoints(kViews, kHalfAngle, 1);
           for (Vector3d& viewpoint : viewpoints) viewpoint *= draw.Uniform(1, ratio);
           const auto scene = SceneOf(viewpoints, subject);
           if (scene->mesh.span != Span::kSurface || scene->mesh.folds_remain)
             return Trial{Verdict::kSaidSo, 0};
           const auto field = MakeField(scene, FieldOf(seed));
           Vector3d way = draw.Within(Vector3d::UnitZ(), 0.7 * kHalfAngle);
           // Every third goes exactly through the nearest viewpoint.
           if (seed % 3 == 0)
             way = std::max_element(viewpoints.begin(), viewpoints.end(),
                                    [&](const Vector3d& a, const Vector3d& b) {
                                      return a.normalized().dot(way) < b.normalized().dot(way);
                                    })
                       ->normalized();
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
         },
     .never_breaks = "a viewpoint that the camera passes goes on weighing the same, whatever the distances"});

// The picture itself, by the reference renderer. Every photograph is of one brightness, so that nothing
// changes but what the views weigh.
CURVE(
    picture_through_the_shell,
    {.about = R"(60 viewpoints 10 degrees apart, their distances at random between one and this ratio, each
  photograph of one brightness; the reference renderer's picture of 8 x 6 px of the subject while the camera
  moves in as above. Right: no pixel jumps by 0.02 of full light, however short the step. A mesh that still
  folds says so.)",
     .driven =
         {Log("farthest over nearest viewpoint"), {1, 1.02, 1.05, 1.1, 1.2, 1.4, 2, 3, 4, 6, 8, 12}, 1.1, 12},
     .trial =
         [](double ratio, unsigned seed) {
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
           if (scene->mesh.span != Span::kSurface || scene->mesh.folds_remain)
             return Trial{Verdict::kSaidSo, 0};
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
         },
     .never_breaks = "a viewpoint that the camera passes goes on weighing the same, whatever the distances"});

}  // namespace
}  // namespace ulf::test
