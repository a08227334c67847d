// Tests: render/quality/choice.
#include "render/quality/choice.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>

#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/points_proxy.h"
#include "render/proxy/proxy.h"
#include "render/proxy/soft_proxy.h"
#include "render/quality/evaluate.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::choice_test {
namespace {

using Eigen::Vector3d;

// Photographs of a plane, and a subject that was placed before or behind it.
TEST(Choice, AFittedPlaneLiesWhereThePhotographsShowIt) {
  test::SceneSpec spec{.viewpoints = test::GridViewpoints(6, 5, 0.15, 2.0)};
  for (const double placed : {0.5, -0.7}) {
    RenderScene scene = *test::MakeScene(spec);
    scene.subject.center_in_world = {0, 0, placed};
    scene.MakeMesh();
    const auto fitted = FitPlane(scene, {.kind = FieldKind::kLinear}, RendererKind::kGl);
    const Rigid3 pose = LookAt({0, 0, 2}, {0, 0, 0}, {0, 1, 0});
    EXPECT_NEAR(fitted->Background(pose).offset, 2, 0.06) << fitted->Name();
  }
  const auto few = test::MakeScene({.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)});
  EXPECT_EQ(FitPlane(*few, {}, RendererKind::kReference)->Name(), "plane");
}

// Counts how often it is read.
class CountedPhotograph : public Photograph {
 public:
  CountedPhotograph(std::shared_ptr<const Photograph> real, std::atomic<int>& reads)
      : Photograph(real->size(), real->linear()), real_(std::move(real)), reads_(reads) {}
  cv::Mat Level(int level) const override {
    ++reads_;
    return real_->Level(level);
  }

 private:
  std::shared_ptr<const Photograph> real_;
  std::atomic<int>& reads_;
};

TEST(Choice, APlaneIsFittedWithinTheMemoryGiven) {
  const auto reads = [](double gpu_memory_mb) {
    std::atomic<int> count = 0;
    RenderScene scene = *test::MakeScene({.viewpoints = test::GridViewpoints(6, 5, 0.15, 2.0)});
    for (SceneView& view : scene.views)
      view.photograph = std::make_shared<CountedPhotograph>(view.photograph, count);
    FitPlane(scene, {.kind = FieldKind::kLinear}, RendererKind::kGl, {.gpu_memory_mb = gpu_memory_mb});
    return count.load();
  };
  EXPECT_GT(reads(0.05), 2 * reads(0)) << "each photograph is read again and again";
}

// The true surface is worth its triangles where there is relief, and not where all is in the plane.
TEST(Choice, TakesTheFirstThatIsNearlyTheBest) {
  const std::vector<FieldOptions> fields{{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}};
  test::SceneSpec spec{
      .viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03), .width = 160, .height = 120, .focal_px = 130};
  for (const bool with_square : {true, false}) {
    spec.with_square = with_square;
    const auto scene = test::MakeScene(spec);
    auto surface = std::make_shared<TriangleMesh>(*test::PlaneAndSquare());
    if (!with_square) surface->triangles.resize(2);
    const std::vector<std::shared_ptr<const Proxy>> proxies{
        std::make_shared<PlaneProxy>(scene->subject, PlaneProxy::InWorld{Vector3d::UnitZ(), 0}),
        std::make_shared<MeshProxy>(scene->subject, surface)};
    const Choice choice = ChooseByEvidence(*scene, fields, proxies, RendererKind::kGl);
    EXPECT_EQ(choice.proxy->Name(), with_square ? "mesh" : "plane:0,0,1,0") << choice.why;
    ASSERT_EQ(choice.candidates.size(), 4u);
    EXPECT_EQ(choice.field.kind, FieldKind::kSubdivision) << choice.why;
    EXPECT_THAT(choice.why, testing::HasSubstr("plane:0,0,1,0 "));
    EXPECT_THAT(choice.why, testing::HasSubstr("linear "));
    // In sentences: what was taken, against what, by how much.
    EXPECT_THAT(
        choice.why,
        testing::ContainsRegex(
            with_square
                ? "^The proxy mesh shows left-out photographs best: [0-9.]+ dB "
                  "\\(plane:0,0,1,0 [0-9.]+\\)\\. The blending field subdivision 1 "
                : "^The proxy plane:0,0,1,0 (shows left-out photographs best: [0-9.]+ dB|is taken, "
                  "with [0-9.]+ dB on left-out photographs: mesh is (as good|only [0-9.]+ dB better), "
                  "and less simple) \\(mesh [0-9.]+\\)\\. The blending field subdivision 1 "));
    EXPECT_THAT(choice.why, testing::EndsWith(")."));
    // Asked why: what was tried, and the one that was taken.
    ASSERT_EQ(choice.explained.size(), 2u);
    for (const ModelChoice& explained : choice.explained) {
      const std::string taken = explained.question == "proxy" ? choice.proxy->Name() : "subdivision 1";
      ASSERT_EQ(explained.candidates.size(), 2u);
      for (const ModelCandidate& candidate : explained.candidates) {
        EXPECT_EQ(candidate.chosen, candidate.model == taken) << ToText(explained);
        EXPECT_THAT(candidate.evidence, testing::ContainsRegex("^[0-9.]+ dB, [0-9.e-]+ s a picture$"));
      }
    }
  }
}

// Two rows, taken in turns: every second view would be one row, which the other shows badly.
TEST(Choice, ScoresAsEvaluateDoes) {
  for (const int columns : {6, 12}) {
    test::SceneSpec spec;
    spec.with_square = true;
    for (int column = 0; column < columns; ++column)
      for (const double y : {-0.3, 0.3}) spec.viewpoints.emplace_back(0.12 * (column - columns / 2), y, 2.0);
    const auto scene = test::MakeScene(spec);
    const std::vector<FieldOptions> fields{{.kind = FieldKind::kLumigraph}};
    const std::vector<std::shared_ptr<const Proxy>> proxies{
        std::make_shared<PlaneProxy>(scene->subject, PlaneProxy::InWorld{Vector3d::UnitZ(), 0.1}),
        std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare())};
    const Choice choice = ChooseByEvidence(*scene, fields, proxies, RendererKind::kGl);
    const EvaluateSummary measured = Evaluate(*scene, {.fields = fields, .proxies = proxies});
    ASSERT_EQ(choice.candidates.size(), proxies.size());
    for (std::size_t i = 0; i < proxies.size(); ++i)
      EXPECT_NEAR(choice.candidates[i].psnr_db, measured.results[i].Main().psnr_db, 0.05)
          << columns << " columns, " << proxies[i]->Name();
  }
}

// They have no mesh for the first two fields, but the soft field needs none.
TEST(Choice, OfARowOfViewsTriesTheSoftField) {
  const auto ring = test::MakeScene({.viewpoints = test::RingViewpoints(30, M_PI / 3, 2, 0.005)});
  const auto soft = std::make_shared<SoftProxy>(ring->subject, test::PlaneAndSquare(), SoftProxy::Maps{});
  const Choice choice = ChooseByEvidence(*ring, EveryField(), {soft}, RendererKind::kGl);
  std::vector<std::string> tried;
  for (const ScoredChoice& candidate : choice.candidates) tried.push_back(FieldText(candidate.field));
  EXPECT_THAT(tried, testing::ElementsAre("lumigraph", "soft 0.5", "soft 0.8"));
  EXPECT_THAT(choice.why, testing::HasSubstr("weights are used in place of subdivision"));
}

TEST(Choice, AMeshDoesNotReplaceTheFittedPlane) {
  const test::ScratchFolder scratch;
  const std::filesystem::path dir = scratch / "lf";
  test::WriteLightField(dir, {.viewpoints = test::GridViewpoints(4, 3, 0.15, 2.0)}, true);
  WriteMeshPly(dir / kMeshProxyFile, *test::PlaneAndSquare());
  RenderScene scene = *LoadScene(ReadLightField(dir), {});
  scene.subject.center_in_world = {0, 0, 0.5};
  std::vector<std::string> names;
  for (const auto& proxy : ProxiesToTry(scene, kAuto, {.kind = FieldKind::kLinear}, dir, RendererKind::kGl))
    names.push_back(proxy->Name());
  EXPECT_THAT(names, testing::ElementsAre("plane", testing::StartsWith("plane:1."), "mesh"));
}

TEST(Choice, TellsHowMuchIsComparedAndEndsWhenAsked) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03)});
  const std::vector<FieldOptions> fields{{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}};
  const std::vector<std::shared_ptr<const Proxy>> proxies{
      scene->proxy, std::make_shared<PlaneProxy>(scene->subject, PlaneProxy::InWorld{Vector3d::UnitZ(), 0})};
  std::map<std::string, std::vector<double>> told;
  std::vector<std::string> order;
  ChooseByEvidence(*scene, fields, proxies, RendererKind::kGl,
                   {.between = [&](const std::string& compared, double share) {
                     if (told[compared].empty()) order.push_back(compared);
                     told[compared].push_back(share);
                   }});
  EXPECT_THAT(order, testing::ElementsAre("geometry", "fields"));
  for (const auto& [compared, shares] : told) {
    EXPECT_EQ(shares.front(), 0) << compared;
    EXPECT_EQ(shares.back(), 1) << compared;
    EXPECT_GT(shares.size(), 10u) << compared;
    EXPECT_TRUE(std::ranges::is_sorted(shares)) << compared;
  }

  struct Left {};
  int pictures = 0;
  EXPECT_THROW(ChooseByEvidence(*scene, fields, proxies, RendererKind::kGl,
                                {.between =
                                     [&](const std::string&, double) {
                                       if (++pictures == 3) throw Left();
                                     }}),
               Left);
  EXPECT_EQ(pictures, 3);
}

TEST(Choice, SaysWhyThereIsNone) {
  const std::vector<FieldOptions> fields{{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}};
  const auto ring = test::MakeScene({.viewpoints = test::RingViewpoints(30, M_PI / 3, 2, 0.005)});
  const Choice around = ChooseByEvidence(*ring, fields, {ring->proxy}, RendererKind::kGl);
  EXPECT_EQ(around.field.kind, FieldKind::kLumigraph);
  EXPECT_THAT(around.why, testing::HasSubstr("weights are used"));
  ASSERT_EQ(around.explained.size(), 2u);
  EXPECT_EQ(around.explained[1].candidates[0].model, "lumigraph");
  EXPECT_THAT(around.explained[1].candidates[0].evidence, testing::HasSubstr("span no surface"));

  // What comes to the same weights once views are left out is tried, and listed, once.
  const auto cap = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03)});
  const std::vector<FieldOptions> twice{
      {.kind = FieldKind::kLumigraph}, {.kind = FieldKind::kLumigraph}, {.kind = FieldKind::kNearest}};
  const Choice once = ChooseByEvidence(*cap, twice, {cap->proxy}, RendererKind::kGl);
  ASSERT_EQ(once.candidates.size(), 2u) << once.why;
}

// Too few to compare: weights that do not smooth over what little there is, and the geometry that knows most.
TEST(Choice, FewViewsGetTheLumigraphOnTheBestGeometry) {
  const auto few = test::MakeScene({.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)});
  ASSERT_EQ(few->mesh.span, Span::kSurface);
  const std::vector<FieldOptions> fields{{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLumigraph}};
  const auto mesh = std::make_shared<MeshProxy>(few->subject, test::PlaneAndSquare());
  const auto points = std::make_shared<PointsProxy>(few->subject, test::PointsOfPlaneAndSquare(50, 0));
  const auto choose = [&](const std::vector<FieldOptions>& of,
                          const std::vector<std::shared_ptr<const Proxy>>& over) {
    return ChooseByEvidence(*few, of, over, RendererKind::kReference);
  };
  const Choice all = choose(fields, {few->proxy, points, mesh});
  EXPECT_EQ(all.field.kind, FieldKind::kLumigraph);
  EXPECT_EQ(all.proxy, mesh);
  EXPECT_EQ(all.why, "lumigraph with the mesh proxy: 9 views, too few to leave some out and compare");
  ASSERT_EQ(all.explained.size(), 2u);
  EXPECT_EQ(all.explained[0].candidates[0].model, "mesh");
  EXPECT_EQ(all.explained[1].candidates[0].model, "lumigraph");
  EXPECT_EQ(choose(fields, {few->proxy, points}).proxy, points);
  EXPECT_EQ(choose(fields, {few->proxy}).field.kind, FieldKind::kLumigraph);
  // What was asked for by name stays.
  const Choice named = choose({fields[0]}, {few->proxy, mesh});
  EXPECT_EQ(named.field.kind, FieldKind::kSubdivision);
  EXPECT_EQ(named.proxy, mesh);
  EXPECT_TRUE(choose({fields[0]}, {few->proxy}).why.empty()) << "there was nothing to choose";
}

// Of the candidates in the order in which they are tried.
TEST(Choice, IsTheFirstNearTheBest) {
  struct Case {
    std::vector<double> psnr_db;  // of candidates in the order in which they are tried
    std::size_t taken;
  };
  for (const Case& c :
       {Case{{30, 30, 30, 30}, 0}, Case{{30, 30.2, 30.29, 30.25}, 0}, Case{{30, 30.4, 30.5, 30.6}, 1},
        Case{{30, 29, 30.4, 30.6}, 2}, Case{{30, 30.1, 30.1, 31}, 3}, Case{{30.7, 30.1, 31, 25}, 0}}) {
    std::vector<ScoredChoice> candidates;
    for (const double psnr_db : c.psnr_db) candidates.push_back({{}, nullptr, psnr_db});
    EXPECT_EQ(&FirstWithinTolerance(candidates), &candidates[c.taken]) << c.psnr_db[1] << " " << c.psnr_db[3];
  }
}

// Several times as slow, it must be better than what would be drawn without it.
TEST(Choice, IsTheSoftFieldWhereItGains) {
  struct Case {
    std::vector<double> psnr_db;  // of EveryField(): the last two are soft
    std::size_t taken;
  };
  for (const Case& c : {Case{{30, 30, 30, 30.05, 30.09}, 0}, Case{{30, 30, 30, 30.05, 30.2}, 4},
                        Case{{30, 30.2, 30.25, 30.3, 30.2}, 3}, Case{{30, 30, 30, 30.2, 30.24}, 3},
                        Case{{30, 30, 30, 30.2, 30.26}, 4}, Case{{30, 30.4, 30.6, 30.45, 30}, 1},
                        Case{{30, 29, 29, 25, 24}, 0}}) {
    std::vector<ScoredChoice> candidates;
    const std::vector<FieldOptions> fields = EveryField();
    for (std::size_t i = 0; i < fields.size(); ++i) candidates.push_back({fields[i], nullptr, c.psnr_db[i]});
    EXPECT_EQ(&PreferredField(candidates), &candidates[c.taken]) << c.psnr_db[3] << " " << c.psnr_db[4];
  }
  const std::vector<FieldOptions> fields = EveryField();
  const std::vector<ScoredChoice> plain{{fields[0], nullptr, 30}, {fields[1], nullptr, 30.2}};
  EXPECT_EQ(&PreferredField(plain), &plain[0]);
  EXPECT_EQ(&PreferredField(plain, 30.4), &plain[1]) << "another proxy had 30.4 dB";
  EXPECT_EQ(&PreferredField(plain, 31), &plain[1]) << "none is near: the best";
  const std::vector<ScoredChoice> soft{{fields[3], nullptr, 30}, {fields[4], nullptr, 30.06}};
  EXPECT_EQ(&PreferredField(soft), &soft[1]) << "of soft fields alone the best";
}

TEST(Choice, InMotionIsAmongThoseThatAreQuickEnough) {
  const std::vector<ScoredChoice> candidates{
      {{}, nullptr, 30, 12}, {{}, nullptr, 31, 11}, {{}, nullptr, 32, 80}, {{}, nullptr, 29, 5}};
  const auto quick = [&](double most_ms) {
    std::vector<double> psnr_db;
    for (const ScoredChoice& candidate : WithinTime(candidates, most_ms))
      psnr_db.push_back(candidate.psnr_db);
    return psnr_db;
  };
  EXPECT_THAT(quick(12), testing::ElementsAre(30, 31, 29));
  EXPECT_THAT(quick(100), testing::ElementsAre(30, 31, 32, 29));
  EXPECT_THAT(quick(1), testing::ElementsAre(29)) << "none: the quickest";

  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03)});
  // The slow one comes first, and is chosen where there is time.
  const std::vector<FieldOptions> fields{{.kind = FieldKind::kLumigraphPerPixel},
                                         {.kind = FieldKind::kSubdivision}};
  const SceneView& view = scene->views.front();
  const auto choose = [&](double most_ms) {
    return ChooseByEvidence(*scene, fields, {scene->proxy}, RendererKind::kGl,
                            {.in_motion = MotionTiming{view.camera, view.cam_from_world, most_ms}});
  };
  const Choice late = choose(1e-6);
  ASSERT_EQ(late.candidates.size(), 2u);
  const auto quickest = std::ranges::min_element(late.candidates, {}, &ScoredChoice::ms);
  EXPECT_GT(quickest->ms, 0);
  EXPECT_EQ(quickest->field.kind, FieldKind::kSubdivision) << "the test shows nothing";
  EXPECT_EQ(late.field.kind, FieldKind::kSubdivision);
  EXPECT_THAT(late.explained.back().criterion, testing::StartsWith("none takes at most 1e-06 ms"));
  EXPECT_THAT(late.why,
              testing::StartsWith("No blending field draws a picture within 1e-06 ms; subdivision 1 "
                                  "is the quickest, with "));
  const Choice any = choose(1e9);
  EXPECT_EQ(any.field.kind, FieldKind::kLumigraphPerPixel);
  EXPECT_THAT(
      any.explained.back().criterion,
      testing::HasSubstr(fmt::format("for a picture of {}x{}", view.camera.width, view.camera.height)));
}

TEST(Choice, TimesWithTheMemoryThatTheViewerHas) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03)});
  const SceneView& view = scene->views.front();
  const auto subdivision_ms = [&](double gpu_memory_mb) {
    return ChooseByEvidence(*scene, {{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}},
                            {scene->proxy}, RendererKind::kGl,
                            {.in_motion = MotionTiming{view.camera, view.cam_from_world, 1e9},
                             .gpu_memory_mb = gpu_memory_mb})
        .candidates.front()
        .ms;
  };
  // Whatever else the processor does: once in five is enough.
  bool slower = false;
  for (int i = 0; i < 5 && !slower; ++i) slower = subdivision_ms(0.01) > 2 * subdivision_ms(0);
  EXPECT_TRUE(slower) << "each photograph is uploaded again";
}

// Viewpoints at very different distances from a surface that is not where the proxy has it: the mesh of the
// viewpoints blends the far with the near, the lumigraph takes the nearer.
TEST(Choice, TakesAnotherFieldWhereThatIsBetter) {
  test::SceneSpec spec;
  spec.viewpoints = test::CapViewpoints(72, 0.5, 2.0, 0.6);
  spec.subject = {{0, 0, 0.5}, 0.3};
  const auto scene = test::MakeScene(spec);
  const Choice choice = ChooseByName(
      *scene, kAuto, {}, ProxiesToTry(*scene, "plane", {}, {}, RendererKind::kGl), RendererKind::kGl);
  ASSERT_EQ(choice.candidates.size(), 3u);
  EXPECT_EQ(choice.field.kind, FieldKind::kLumigraph) << choice.why;
  for (const ModelCandidate& candidate : choice.explained.back().candidates)
    EXPECT_EQ(candidate.chosen, candidate.model == "lumigraph") << ToText(choice.explained.back());
}

}  // namespace
}  // namespace ulf::choice_test
