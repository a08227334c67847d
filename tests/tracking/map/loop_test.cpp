// Tests: core/geometry/similarity3, tracking/estimation/pose_graph, tracking/map/loop_closer.
// Loops, from the algebra up to a map whose drift is known.
#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/similarity3.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/pose_graph.h"
#include "tracking/map/loop_closer.h"

namespace ulf::loop_test {
namespace {

using Eigen::Vector3d;
using test::Draw;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

Similarity3 RandomSimilarity(Draw& draw) {
  Similarity3 similarity = Similarity3::FromRigid(test::RandomPose(draw, 2.5, 3));
  similarity.scale = draw.Uniform(0.5, 2);
  return similarity;
}

TEST(Similarity3Test, InverseAndProductDoWhatTheySay) {
  Draw draw(1);
  for (int i = 0; i < 20; ++i) {
    const Similarity3 a = RandomSimilarity(draw), b = RandomSimilarity(draw);
    const Vector3d point = 3 * draw.Direction();
    EXPECT_LT(((a * b) * point - a * (b * point)).norm(), 1e-12);
    EXPECT_LT((a.Inverse() * (a * point) - point).norm(), 1e-12);
    // Without its scale a camera sees the same image.
    EXPECT_LT(((a * point) / a.scale - a.WithoutScale() * point).norm(), 1e-12);
  }
}

TEST(Similarity3Test, ARigidAlignmentKeepsTheScale) {
  Draw draw(2);
  const Similarity3 truth = Similarity3::FromRigid(test::RandomPose(draw, 2, 3));
  std::vector<Vector3d> source, target;
  for (int i = 0; i < 30; ++i) {
    source.push_back(2 * draw.Direction());
    target.push_back(1.1 * (truth * source.back()));
  }
  const auto free = AlignPoints(source, target), rigid = AlignPoints(source, target, true);
  ASSERT_TRUE(free && rigid);
  EXPECT_NEAR(free->scale, 1.1, 1e-9);
  EXPECT_EQ(rigid->scale, 1);
  EXPECT_LT((rigid->rotation - truth.rotation).norm(), 1e-9);
}

TEST(PoseGraphTest, DerivativesMatchDifferences) {
  Draw draw(3);
  for (int round = 0; round < 20; ++round) {
    const Similarity3 from = RandomSimilarity(draw), to = RandomSimilarity(draw);
    Similarity3 measured = to * from.Inverse();
    Vector7d disturbance;
    for (int i = 0; i < 7; ++i) disturbance(i) = draw.Uniform(-0.4, 0.4);
    measured = Perturbed(measured, disturbance);
    const PoseGraphEdge edge{0, 1, measured, 1};
    constexpr double kUnit = 1.7, kStep = 1e-6;
    Matrix7d by_from, by_to, numeric_from, numeric_to;
    PoseGraphError(edge, from, to, kUnit, &by_from, &by_to);
    for (int i = 0; i < 7; ++i) {
      Vector7d step = Vector7d::Zero();
      step(i) = kStep;
      const auto slope = [&](const Vector7d& plus, const Vector7d& minus) {
        return Vector7d((plus - minus) / (2 * kStep));
      };
      numeric_from.col(i) = slope(PoseGraphError(edge, Perturbed(from, step), to, kUnit),
                                  PoseGraphError(edge, Perturbed(from, -step), to, kUnit));
      numeric_to.col(i) = slope(PoseGraphError(edge, from, Perturbed(to, step), kUnit),
                                PoseGraphError(edge, from, Perturbed(to, -step), kUnit));
    }
    EXPECT_LT((by_from - numeric_from).norm(), 1e-6 * (1 + by_from.norm())) << round;
    EXPECT_LT((by_to - numeric_to).norm(), 1e-6 * (1 + by_to.norm())) << round;
  }
}

TEST(PoseGraphTest, SpreadsTheErrorOverTheWay) {
  for (const bool rigid : {false, true}) {
    constexpr int kNodes = 40;
    std::vector<Similarity3> truth;
    for (int k = 0; k < kNodes; ++k) {
      const double angle = 2 * M_PI * k / kNodes;
      truth.push_back(Similarity3::FromRigid(
          LookAt({3 * std::cos(angle), 3 * std::sin(angle), 0}, Vector3d::Zero(), Vector3d::UnitZ())));
    }
    PoseGraph graph;
    graph.cam_from_world = truth;
    Vector7d drift;
    drift << 0.002, -0.003, 0.002, 0.004, 0.002, -0.003, rigid ? 0 : 0.004;
    double before = 0, after = 0;
    const auto error = [&](std::size_t k) {
      const Similarity3& pose = graph.cam_from_world[k];
      return (pose.Inverse().translation - truth[k].Inverse().translation).squaredNorm();
    };
    for (std::size_t k = 1; k < kNodes; ++k) {
      Vector7d in_cam = drift;  // which turns with the world
      in_cam.head<3>() = truth[k].rotation * drift.head<3>();
      in_cam.segment<3>(3) = truth[k].rotation * drift.segment<3>(3);
      const Similarity3 measured = Perturbed(truth[k] * truth[k - 1].Inverse(), in_cam);
      graph.cam_from_world[k] = measured * graph.cam_from_world[k - 1];
      graph.edges.push_back({static_cast<int>(k) - 1, static_cast<int>(k), measured, 1});
      before += error(k);
    }
    graph.edges.push_back({0, kNodes - 1, truth.back() * truth.front().Inverse(), 10});
    const PoseGraphSummary summary = OptimizePoseGraph(graph, {.rigid = rigid, .unit = 3});
    ASSERT_TRUE(summary.usable);
    EXPECT_LT(summary.final_cost, 0.1 * summary.initial_cost);
    for (std::size_t k = 1; k < kNodes; ++k) {
      after += error(k);
      if (rigid) {
        EXPECT_NEAR(graph.cam_from_world[k].scale, 1, 1e-12);
      }
    }
    EXPECT_LT(std::sqrt(after), 0.2 * std::sqrt(before)) << (rigid ? "rigid" : "similarity");
  }
}

// Once around a ball covered with points, and a little further. Drift is a similarity that grows with the
// angle: every image is exact for the world about it, but after a whole turn the world does not meet itself.
struct Turn {
  struct Options {
    double log_scale = 0.06, turn = 0.05, shift = 0.15;  // after a whole turn
    int symmetry = 1;  // the ball looks the same after 1 / symmetry of a turn
    double symmetric_share = 1;
    int keyframes = 80;  // 72 make a turn
    unsigned seed = 1;
  };
  Options options;
  CameraModel camera = test::SceneCamera();
  OwnedMap owned{Map(camera)};
  SharedMap& shared = owned.shared;
  KeyframeIndex index{1};
  std::vector<Rigid3> truth;
  int loops = 0;

  static Vector3d CenterAt(double angle) {
    return {4 * std::cos(angle), 4 * std::sin(angle), 0.4 * std::sin(3 * angle)};
  }

  // Grows about the camera: that is where a tracker goes wrong.
  Similarity3 Grow(const Similarity3& drift, double angle, double step) const {
    const double share = step / (2 * M_PI);
    const Vector3d axis = Vector3d(0.3, 0.5, 0.8).normalized(), along(0.6, -0.5, 0.62);
    Similarity3 about{std::exp(options.log_scale * share),
                      Eigen::AngleAxisd(options.turn * share, axis).toRotationMatrix(), Vector3d::Zero()};
    about.translation = CenterAt(angle) - about * CenterAt(angle) + options.shift * share * along;
    return drift * about;
  }
  Similarity3 Drift(double angle) const {
    constexpr double kFirst = -M_PI, kStep = 0.01;
    if (drifts.empty()) drifts.push_back({});
    const double steps = (angle - kFirst) / kStep;
    while (static_cast<double>(drifts.size()) <= steps)
      drifts.push_back(Grow(drifts.back(), kFirst + kStep * static_cast<double>(drifts.size() - 1), kStep));
    const double whole = std::floor(steps);
    return Grow(drifts[static_cast<std::size_t>(whole)], kFirst + kStep * whole, kStep * (steps - whole));
  }
  mutable std::vector<Similarity3> drifts;

  explicit Turn(const Options& options_in) : options(options_in) {
    Draw draw(options.seed);
    struct Dot {
      Vector3d position;
      Descriptor look;
      std::vector<std::pair<double, int>> copies;  // unwrapped angle, map point
    };
    std::vector<Dot> dots;
    const auto random_look = [&] {
      Descriptor look{};
      for (auto& word : look)
        for (int bit = 0; bit < 64; ++bit) word = word << 1 | (draw.Uniform(0, 1) < 0.5 ? 1u : 0u);
      return look;
    };
    for (int i = 0; i < 900 / options.symmetry; ++i) {
      const double angle = draw.Uniform(0, 2 * M_PI / options.symmetry), height = draw.Uniform(-0.8, 0.8);
      const double radius = 1.5 * std::sqrt(1 - height * height) * draw.Uniform(0.9, 1);
      const Descriptor look = random_look();
      const bool repeats = draw.Uniform(0, 1) < options.symmetric_share;
      for (int s = 0; s < options.symmetry; ++s) {
        const double turned = angle + s * 2 * M_PI / options.symmetry;
        dots.push_back({{radius * std::cos(turned), radius * std::sin(turned), 1.5 * height},
                        repeats ? look : random_look(),
                        {}});
      }
    }
    Map& map = owned.map;
    for (int k = 0; k < options.keyframes; ++k) {
      const double angle = 2 * M_PI * k / 72;
      truth.push_back(LookAt(CenterAt(angle), Vector3d::Zero(), Vector3d::UnitZ()));
      Keyframe keyframe;
      const Similarity3 drifted = Similarity3::FromRigid(truth.back()) * Drift(angle).Inverse();
      keyframe.cam_from_world = drifted.WithoutScale();
      std::vector<Feature> features;
      std::vector<int> seen;
      for (Dot& dot : dots) {
        const Vector3d towards = truth.back().OriginInSource() - dot.position;
        if (towards.dot(dot.position) < 0.35 * towards.norm() * dot.position.norm()) continue;
        double at = std::atan2(dot.position.y(), dot.position.x());
        at += 2 * M_PI * std::round((angle - at) / (2 * M_PI));
        const Vector3d position = Drift(at) * dot.position;
        const auto img = camera.ImgFromCam(keyframe.cam_from_world * position);
        if (!img || !camera.Contains(*img)) continue;
        if (dot.copies.empty() || std::abs(dot.copies.back().first - at) > 1)
          dot.copies.emplace_back(at, map.AddPoint(position));
        Descriptor look = dot.look;
        for (int i = 0; i < 15; ++i) {
          const int bit = static_cast<int>(draw.Uniform(0, 255.9));
          look[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
        }
        const Eigen::Vector2d measured = *img + Eigen::Vector2d(draw.Normal(0.5), draw.Normal(0.5));
        features.push_back({measured, *camera.RayFromImg(measured), 0, 0, look});
        seen.push_back(dot.copies.back().second);
      }
      keyframe.features = std::make_shared<const FeatureSet>(features, camera.width, camera.height);
      const int id = map.AddKeyframe(std::move(keyframe));
      for (int i = 0; i < static_cast<int>(seen.size()); ++i)
        map.AddObservation(seen[static_cast<std::size_t>(i)],
                           {id, i, features[static_cast<std::size_t>(i)].img, 1});
    }
    for (const MapPoint& point : map.points()) map.Update(point.id);
  }

  // As the mapper does it: each keyframe is examined, then filed.
  void Close(int agreeing = LoopCloser::kAgreeing) {
    LoopCloser closer(camera, owned, index, 1, agreeing);
    for (int k = 0; k < options.keyframes; ++k) {
      if (!shared.ReadByOwner().keyframe(k).alive) continue;
      loops += closer.Examine(k).has_value();
      index.Add(shared.ReadByOwner().keyframe(k));
    }
  }

  double CenterError() const {
    std::vector<Vector3d> centers, true_centers;
    for (int k = 0; k < options.keyframes; ++k) {
      centers.push_back(shared.ReadByOwner().PoseOf(k).OriginInSource());
      true_centers.push_back(truth[static_cast<std::size_t>(k)].OriginInSource());
    }
    const Similarity3 fit = *AlignPoints(centers, true_centers);
    double sum = 0;
    for (std::size_t k = 0; k < centers.size(); ++k)
      sum += (fit * centers[k] - true_centers[k]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(centers.size()));
  }
};

TEST(LoopCloserTest, ComingRoundTakesTheDriftOut) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Turn turn({.seed = seed});
    const double before = turn.CenterError();
    const Map& map = turn.shared.ReadByOwner();
    const int points = map.LivingPoints();
    turn.Close();
    EXPECT_GE(turn.loops, 1) << "seed " << seed;
    EXPECT_LT(turn.CenterError(), 0.2 * before) << "seed " << seed;
    EXPECT_LT(map.LivingPoints(), points - 60) << "seed " << seed;
    EXPECT_EQ(turn.shared.loops, turn.loops);
    EXPECT_EQ(turn.shared.revision, turn.loops);
    // Both passes see the same points now.
    bool meets = false;
    for (int k = 60; k < turn.options.keyframes; ++k)
      for (const Map::Neighbour& partner : map.Covisible(k)) meets |= partner.keyframe < 20;
    EXPECT_TRUE(meets) << "seed " << seed;
  }
}

TEST(LoopCloserTest, AnchoredPosesFollowTheirKeyframe) {
  Turn turn({});
  const Map& map = turn.shared.ReadByOwner();
  // Beside keyframe 60, whose drifted world is larger: at a point's place, seen from the keyframe.
  const MapPoint& point = map.point(map.keyframe(60).point_of_feature[5]);
  const int id = point.id;
  Rigid3 beside;
  beside.translation = -(map.keyframe(60).cam_from_world * point.position);
  const Anchored anchor{60, beside, map.keyframe(60).unit};
  {
    const MapLock lock(turn.owned.shared);
    turn.owned.map.RemoveKeyframe(50);
  }
  const Rigid3 removed = map.PoseOf(50);
  const int parent = map.keyframe(50).parent;
  const double ratio = (removed.OriginInSource() - map.PoseOf(parent).OriginInSource()).norm() /
                       (map.PoseOf(parent).OriginInSource() - map.PoseOf(45).OriginInSource()).norm();
  turn.Close();
  ASSERT_GE(turn.loops, 1);
  EXPECT_GT(std::abs(std::log(map.keyframe(60).unit)), 0.02);
  EXPECT_LT((map.PoseOf(anchor).OriginInSource() - map.point(id).position).norm(), 0.03);
  const double ratio_after = (map.PoseOf(50).OriginInSource() - map.PoseOf(parent).OriginInSource()).norm() /
                             (map.PoseOf(parent).OriginInSource() - map.PoseOf(45).OriginInSource()).norm();
  EXPECT_NEAR(ratio_after, ratio, 0.02 * ratio);
}

TEST(LoopCloserTest, OneKeyframeAloneIsNotBelieved) {
  Turn few({.keyframes = 80});
  few.Close(100);
  EXPECT_EQ(few.loops, 0);
  EXPECT_EQ(few.shared.revision, 0);
}

// Looks like the first view a quarter of a turn later, then again: no drift is that large.
TEST(LoopCloserTest, SimilarLookingPlaceIsNoLoop) {
  for (const int symmetry : {2, 3, 8}) {
    Turn turn({.log_scale = 0, .turn = 0, .shift = 0, .symmetry = symmetry, .keyframes = 66});
    const double before = turn.CenterError();
    turn.Close();
    EXPECT_EQ(turn.loops, 0) << symmetry << "-fold";
    EXPECT_EQ(turn.CenterError(), before);
  }
}

// The true loop is found although other sides look alike for the most part.
TEST(LoopCloserTest, ClosesOnAMostlySymmetricSubject) {
  for (const unsigned seed : {1u, 2u}) {
    Turn turn({.symmetry = 3, .symmetric_share = 0.7, .seed = seed});
    const double before = turn.CenterError();
    turn.Close();
    EXPECT_GE(turn.loops, 1) << "seed " << seed;
    EXPECT_LT(turn.CenterError(), 0.15 * before) << "seed " << seed;
  }
}

TEST(LoopCloserTest, TheSameMapGivesTheSameBytesTwice) {
  Turn first({}), second({});
  first.Close();
  second.Close();
  for (int k = 0; k < first.options.keyframes; ++k) {
    const Rigid3 a = first.shared.ReadByOwner().PoseOf(k), b = second.shared.ReadByOwner().PoseOf(k);
    EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
    EXPECT_EQ(a.translation, b.translation);
  }
}

}  // namespace
}  // namespace ulf::loop_test
