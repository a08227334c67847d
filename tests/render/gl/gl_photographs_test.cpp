// Tests: render/gl/gl_photographs, render/gl/gl_over_views.
//
// Light fields larger than graphics memory: the same pictures, never more memory than was granted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "core/base/error.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::gl_photographs_test {
namespace {

using Eigen::Vector3d;
using test::SceneSpec;

const CameraModel kCamera = CameraModel::Pinhole(64, 48, 60);

Rigid3 At(const Vector3d& center) { return LookAt(center, Vector3d(0.02, -0.01, 0), Vector3d::UnitY()); }

// Near the shell, moved in (where most views weigh), and past the hull, where the nearest view fills.
const std::vector<Vector3d> kCenters{{0.1, 0.05, 2.1}, {0.1, -0.05, 0.8}, {2.2, 0.4, 1.2}};

// Views that are added up together are rounded once, those of several passes each time.
void ExpectSame(const Rendering& a, const Rendering& b, const std::string& name) {
  constexpr double kRounding = 2e-6;
  EXPECT_LT(cv::norm(a.linear, b.linear, cv::NORM_INF), kRounding) << name;
  EXPECT_LT(cv::norm(a.confidence, b.confidence, cv::NORM_INF), kRounding) << name;
  EXPECT_EQ(a.filled_px, b.filled_px) << name;
  EXPECT_EQ(a.empty_px, b.empty_px) << name;
}

TEST(GlPhotographs, AThirdOfTheMemoryDrawsTheSame) {
  struct Case {
    std::string name;
    SceneSpec spec;
    std::vector<FieldKind> fields;
  };
  const auto cap = test::CapViewpoints(40, 0.7, 2.0, 0.03);
  const std::vector<Case> cases{
      {"plane", {.viewpoints = cap}, {FieldKind::kSubdivision, FieldKind::kLumigraph}},
      {"two sizes, a mesh that hides",
       {.viewpoints = cap, .two_sizes = true, .with_square = true},
       {FieldKind::kSubdivision, FieldKind::kLumigraphPerPixel}},
      {"half floats with gaps",
       {.viewpoints = cap, .linear_with_gaps = true},
       {FieldKind::kSubdivision, FieldKind::kNearest}},
  };
  for (const Case& c : cases) {
    std::shared_ptr<const RenderScene> scene = test::MakeScene(c.spec);
    if (c.spec.with_square)
      scene = WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare()));
    GlRenderer plenty(scene, {});
    std::map<FieldKind, std::vector<Rendering>> truths;
    for (const FieldKind field : c.fields) {
      plenty.SetField({.kind = field});
      for (const Vector3d& center : kCenters) truths[field].push_back(plenty.Render(kCamera, At(center)));
    }
    const GlPhotographs::Counts needed = plenty.photograph_counts();
    const double third_mb = 1e-6 * static_cast<double>(needed.most_bytes) / 3;
    GlRenderer scarce(scene, {.gpu_memory_mb = third_mb});
    for (const FieldKind field : c.fields) {
      scarce.SetField({.kind = field});
      for (std::size_t i = 0; i < kCenters.size(); ++i)
        ExpectSame(scarce.Render(kCamera, At(kCenters[i])), truths[field][i],
                   c.name + ", " + FieldName(field) + ", " + std::to_string(i));
    }
    const GlPhotographs::Counts counts = scarce.photograph_counts();
    EXPECT_LE(static_cast<double>(counts.most_bytes), 1e6 * third_mb) << c.name;
    EXPECT_GT(counts.uploads, needed.uploads) << c.name;  // it was too little
  }
}

// Nobody has looked up which photographs have holes where all are there already.
TEST(GlPhotographs, FillHolesInFirstAndLaterPictures) {
  const auto scene =
      test::MakeScene({.viewpoints = test::CapViewpoints(7, 0.4, 2.0), .linear_with_gaps = true});
  const Rigid3 pose = At(scene->views[0].center_in_world);
  const RenderOptions nearest{.field = {.kind = FieldKind::kNearest}};
  const Rendering at_first = MakeRenderer(scene, nearest)->Render(kCamera, pose);
  ASSERT_EQ(at_first.empty_px, 0);
  // What another view than the nearest shows is filled.
  const Rendering plain = MakeRenderer(scene, {.field = nearest.field, .renderer = RendererKind::kReference})
                              ->Render(kCamera, pose);
  ASSERT_GT(plain.filled_px, 300);
  EXPECT_NEAR(static_cast<double>(at_first.filled_px), static_cast<double>(plain.filled_px),
              0.1 * static_cast<double>(plain.filled_px));
  const auto renderer =
      MakeRenderer(scene, {.field = {.kind = FieldKind::kLumigraphPerPixel, .lumigraph_k = 7}});
  for (int i = 0; i < 2; ++i) renderer->Render(kCamera, pose);  // the second takes all
  renderer->SetField(nearest.field);
  ExpectSame(renderer->Render(kCamera, pose), at_first, "later");
}

// Far more of them than texture units. With gaps: all but the last have a hole in the middle.
std::shared_ptr<RenderScene> SceneOfManySizes(bool with_gaps) {
  auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(20, 0.6, 2.0, 0.03)});
  for (std::size_t i = 0; i < scene->views.size(); ++i) {
    SceneView& view = scene->views[i];
    view.camera = view.camera.ScaledTo(96 + static_cast<int>(i), 72);
    cv::Mat light = test::LightOfPlane(view.camera, view.cam_from_world);
    if (with_gaps) light(cv::Rect(20, 20, 50, 30)) = cv::Scalar::all(i == 19 ? 0.5 : std::nan(""));
    view.photograph =
        test::HoldPhotograph(with_gaps ? MakeLinearPyramid(light) : MakePyramid(Srgb8FromLinear(light)));
  }
  return scene;
}

TEST(GlPhotographs, FillHolesFromEverySize) {
  const auto scene = SceneOfManySizes(true);
  const FieldOptions nearest{.kind = FieldKind::kNearest};
  GlRenderer renderer(scene, {.field = {.kind = FieldKind::kLumigraphPerPixel}});
  const auto reference = MakeRenderer(scene, {.field = nearest, .renderer = RendererKind::kReference});
  for (const SceneView& view : scene->views) {
    const Rigid3 pose = At(view.center_in_world);
    renderer.SetField({.kind = FieldKind::kLumigraphPerPixel});
    for (int i = 0; i < 2; ++i) renderer.Render(kCamera, pose);  // all are there
    renderer.SetField(nearest);
    const Rendering plain = reference->Render(kCamera, pose);
    EXPECT_NEAR(static_cast<double>(renderer.Render(kCamera, pose).empty_px),
                static_cast<double>(plain.empty_px), 30)
        << view.id;
  }
}

TEST(GlPhotographs, OnePhotographAlwaysFits) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(7, 0.4, 2.0)});
  GlRenderer renderer(scene, {.gpu_memory_mb = 1e-6});
  EXPECT_EQ(renderer.Render(kCamera, At({0.1, 0.05, 2})).empty_px, 0);
}

TEST(GlPhotographs, ManySizesAndLevelsShareTheMemory) {
  // The camera goes away and comes back.
  const auto scene = SceneOfManySizes(false);
  GlRenderer plenty(scene, {}), scarce(scene, {.gpu_memory_mb = 0.2});
  for (const FieldKind field : {FieldKind::kSubdivision, FieldKind::kNearest}) {
    plenty.SetField({.kind = field});
    scarce.SetField({.kind = field});
    for (const double distance : {1.0, 4.5, 1.1}) {
      const Rigid3 pose = At({0.1, 0.05, distance});
      ExpectSame(scarce.Render(kCamera, pose), plenty.Render(kCamera, pose),
                 FieldName(field) + " from " + std::to_string(distance));
    }
  }
  EXPECT_LE(scarce.photograph_counts().most_bytes, 200000u);
}

// Read when they are asked for, and counted.
class CountedPhotograph : public Photograph {
 public:
  explicit CountedPhotograph(std::shared_ptr<const Photograph> real, bool broken = false)
      : Photograph(real->size(), real->linear()), real_(std::move(real)), broken_(broken) {}
  cv::Mat Level(int level) const override {
    ++reads;
    if (broken_) throw Error("photograph is broken");
    return real_->Level(level);
  }
  mutable std::atomic<int> reads = 0;

 private:
  std::shared_ptr<const Photograph> real_;
  bool broken_;
};

std::vector<std::shared_ptr<CountedPhotograph>> CountReads(RenderScene& scene, int broken = -1) {
  std::vector<std::shared_ptr<CountedPhotograph>> counted;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    counted.push_back(
        std::make_shared<CountedPhotograph>(scene.views[i].photograph, static_cast<int>(i) == broken));
    scene.views[i].photograph = counted.back();
  }
  return counted;
}

TEST(GlPhotographs, OnePictureReadsFewManyReadAll) {
  auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(60, 1.2, 2.0, 0.03)});
  const auto counted = CountReads(*scene);
  const auto read = [&] {
    return std::count_if(counted.begin(), counted.end(), [](const auto& each) { return each->reads > 0; });
  };
  GlRenderer renderer(scene, {.field = {.kind = FieldKind::kLumigraphPerPixel}, .fill = false});
  renderer.Render(kCamera, At({0.1, 0.05, 1.5}));
  EXPECT_LT(read(), 40);
  renderer.Render(kCamera, At({0.1, 0.05, 1.4}));
  EXPECT_EQ(read(), 60);
}

TEST(GlPhotographs, ProgressivePicturesConverge) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.7, 2.0, 0.03)});
  for (const FieldKind field :
       {FieldKind::kSubdivision, FieldKind::kLumigraphPerPixel, FieldKind::kNearest}) {
    GlRenderer waits(scene, {.field = {.kind = field}});
    GlRenderer goes_on(scene, {.field = {.kind = field}, .complete = false});
    for (const Vector3d& center : kCenters) {
      const Rendering truth = waits.Render(kCamera, At(center));
      Rendering picture = goes_on.Render(kCamera, At(center));
      EXPECT_GT(cv::countNonZero(picture.drawn), 0) << FieldName(field);
      for (int n = 0; n < 2000 && goes_on.loading(); ++n) picture = goes_on.Render(kCamera, At(center));
      EXPECT_FALSE(goes_on.loading());
      ExpectSame(picture, truth, FieldName(field));
    }
  }
}

TEST(GlPhotographs, UnreadableOneIsAnErrorOrLeftOut) {
  auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(5, 5, 0.2, 2.0)});
  CountReads(*scene, 12);
  const Rigid3 pose = At({0.05, 0.02, 2.1});
  EXPECT_THROW(GlRenderer(scene, {}).Render(kCamera, pose), Error);
  GlRenderer goes_on(scene, {.complete = false});
  Rendering picture = goes_on.Render(kCamera, pose);
  for (int n = 0; n < 2000 && goes_on.loading(); ++n) picture = goes_on.Render(kCamera, pose);
  EXPECT_FALSE(goes_on.loading());
  EXPECT_EQ(picture.empty_px, 0);
}

TEST(GlPhotographs, ReadExpectedOnesAhead) {
  auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.7, 2.0, 0.03)});
  const auto counted = CountReads(*scene);
  const auto read = [&] {
    std::set<std::size_t> views;
    for (std::size_t i = 0; i < counted.size(); ++i)
      if (counted[i]->reads > 0) views.insert(i);
    return views;
  };
  const RenderOptions options{.fill = false};
  const Rigid3 here = At({0.9, 0.1, 1.8}), there = At({-0.9, -0.1, 1.8});
  std::set<std::size_t> wanted;
  {
    GlRenderer renderer(scene, options);
    renderer.Render(kCamera, there);
    wanted = read();
    for (const auto& photograph : counted) photograph->reads = 0;
  }
  GlRenderer renderer(scene, options);
  renderer.Prefetch(kCamera, there);
  renderer.Render(kCamera, here);
  const auto begin = std::chrono::steady_clock::now();
  const auto all_read = [&] {
    const auto now = read();
    return std::includes(now.begin(), now.end(), wanted.begin(), wanted.end());
  };
  while (!all_read() && std::chrono::steady_clock::now() - begin < std::chrono::seconds(10))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_TRUE(all_read());
  EXPECT_LT(read().size(), counted.size());
  // And not again when it is drawn.
  std::vector<int> reads_before;
  for (const auto& photograph : counted) reads_before.push_back(photograph->reads);
  renderer.Render(kCamera, there);
  for (const std::size_t i : wanted) EXPECT_EQ(counted[i]->reads, reads_before[i]) << i;
}

}  // namespace
}  // namespace ulf::gl_photographs_test
