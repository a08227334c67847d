// Tests: commands/rendering/render_command, commands/rendering/render_settings,
// commands/rendering/evaluate_command, commands/options/scene_options, commands/options/chosen_model,
// commands/reports/explain, render/quality/evaluate, render/proxy/proxy_choice.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/points/point_io.h"
#include "core/video/video_reader.h"
#include "render/fields/field_options.h"
#include "render/proxy/mesh_file.h"
#include "render/quality/evaluate.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::render_command_test {
namespace {

using Eigen::Vector3d;
using test::RunUlf;
using testing::AllOf;
using testing::HasSubstr;

test::SceneSpec SmallSpec() { return {.viewpoints = test::GridViewpoints(6, 5, 0.2, 2.0)}; }

// ---- Evaluation ----

TEST(Evaluate, ScoresHeldOutViewsAndSetsTheRimApart) {
  const auto scene =
      test::MakeScene({.viewpoints = test::GridViewpoints(9, 7, 0.1, 2.0), .width = 96, .height = 72});
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
    const EvaluateSummary summary =
        Evaluate(*scene, {.every = 4,
                          .fields = {{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kNearest}},
                          .renderer = kind});
    EXPECT_EQ(summary.views, 63);
    EXPECT_EQ(summary.held_out, 16);
    ASSERT_EQ(summary.results.size(), 2u);
    const FieldScore& subdivision = summary.results[0];
    EXPECT_GT(subdivision.rim.views, 2);
    EXPECT_GT(subdivision.inside.views, 2);
    EXPECT_EQ(subdivision.rim.views + subdivision.inside.views, 16);
    // The scene is nearly the proxy: blending must be good, and better than the nearest view.
    EXPECT_GT(subdivision.inside.psnr_db, 25);
    EXPECT_GT(subdivision.inside.psnr_db, summary.results[1].inside.psnr_db);
    EXPECT_GT(subdivision.inside.ssim, 0.9);
    EXPECT_GT(subdivision.ms_per_frame, 0);
  }
}

TEST(Evaluate, ComparesWithTheUndistortedPhotograph) {
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(5, 5, 0.1, 2.0),
                                      .width = 160,
                                      .height = 120,
                                      .focal_px = 130,
                                      .distortion = Distortion::kRadialTangential});
  const SceneView& view = scene->views[12];
  const UndistortedPhotograph photograph = Undistort(view);
  const cv::Mat truth = test::PhotographOfPlane(view.camera.WithoutDistortion(), view.cam_from_world);
  const Quality quality = CompareImages(photograph.srgb8, truth, photograph.valid);
  EXPECT_GT(quality.psnr_db, 24);
  EXPECT_GT(quality.pixels, 0.9 * 160 * 120);
  EXPECT_LT(CompareImages(view.photograph->Level(0), truth, photograph.valid).psnr_db, quality.psnr_db - 3);
}

TEST(Evaluate, SubjectDiscIsItsSilhouette) {
  const CameraModel camera = CameraModel::Pinhole(200, 200, 200);
  const cv::Mat disc =
      SubjectDisc(camera, LookAt({0, 0, 4}, Vector3d::Zero(), Vector3d::UnitY()), {{0, 0, 0}, 1});
  const double radius = 200 * std::tan(std::asin(0.25));
  EXPECT_NEAR(cv::countNonZero(disc), M_PI * radius * radius, 0.02 * M_PI * radius * radius);
}

TEST(Evaluate, NeedsSomethingLeft) {
  const auto one = test::MakeScene({.viewpoints = {{0, 0, 2}}});
  EXPECT_THROW(Evaluate(*one, {.fields = {{}}}), Error);
  const auto two = test::MakeScene({.viewpoints = {{0, 0, 2}, {0.1, 0, 2}}});
  EXPECT_THROW(Evaluate(*two, {.every = 1, .fields = {{}}}), Refusal);
  EXPECT_EQ(Evaluate(*two, {.every = 2, .fields = {{}}, .renderer = RendererKind::kReference}).held_out, 1);
}

// ---- The commands ----

class RenderCommand : public testing::Test {
 protected:
  // Written once, copied for every test.
  void SetUp() override {
    static const test::ScratchFolder made;
    if (!std::filesystem::exists(made / "lf")) test::WriteLightField(made / "lf", SmallSpec(), true);
    std::filesystem::copy(made / "lf", dir_, std::filesystem::copy_options::recursive);
  }
  std::string Out(const std::string& name) const { return (scratch_ / name).string(); }
  test::ScratchFolder scratch_;
  std::filesystem::path dir_ = scratch_ / "lf";
};

TEST_F(RenderCommand, WritesPicturesVideosAndFolders) {
  // What is not given is tried out on left-out views, which takes longer than the pictures: once is enough.
  const std::string given = " --field linear --proxy plane --zoom 1 ";
  const auto picture = RunUlf("render " + dir_.string() + given + "-o " + Out("a.png"));
  EXPECT_EQ(picture.exit_code, 0) << picture.errors;
  EXPECT_EQ(cv::imread(Out("a.png")).size(), cv::Size(96, 72));

  const auto video = RunUlf("render " + dir_.string() + " --path dolly --frames 5 --width 65 -o " +
                            Out("b.mp4") + " --json");
  EXPECT_EQ(video.exit_code, 0) << video.errors;
  const auto report = JsonFromText(video.output);
  EXPECT_THAT(video.errors, HasSubstr("65x49 are cropped to 64x48"));
  EXPECT_EQ(report["frames"], 5);
  EXPECT_EQ(report["field"], "subdivision");
  EXPECT_LT(report["empty_share"], 0.05);
  VideoReader written(Out("b.mp4"));
  int frames = 0;
  while (written.Next()) ++frames;
  EXPECT_EQ(frames, 5);
  EXPECT_EQ(written.Facts().width, 64);

  for (const std::string fps : {"0.001", "1000000"}) {
    const auto refused =
        RunUlf("render " + dir_.string() + " --field linear --proxy plane --frames 2 --fps " + fps + " -o " +
               Out("e.mp4"));
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("--fps " + fps), testing::Not(HasSubstr("MPEG"))));
  }

  const auto folder = RunUlf("render " + dir_.string() + " --path " + dir_.string() + given +
                             "--renderer reference -o " + Out("c"));
  EXPECT_EQ(folder.exit_code, 0) << folder.errors;
  // The light field's own poses: its photographs come back.
  const LightField light_field = ReadLightField(dir_);
  const cv::Mat photograph = ReadViewImage(light_field, light_field.views[14]).pixels;
  const cv::Mat rendered = cv::imread(Out("c") + "/frame_00014.png");
  ASSERT_EQ(rendered.size(), photograph.size());
  cv::Mat difference;
  cv::absdiff(rendered, photograph, difference);
  EXPECT_LE(cv::mean(difference)[1], 1.0);

  const auto field = RunUlf("render " + dir_.string() + given + "--blending-field -o " + Out("d.png"));
  EXPECT_EQ(field.exit_code, 0) << field.errors;
}

// What would otherwise come out as something else than was meant, without a word.
TEST_F(RenderCommand, ReportsWhatIsNotAvailable) {
  const std::string render = "render " + dir_.string() + " --field linear --proxy plane ";
  const auto nowhere = RunUlf(render + "--frames 1");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.errors, HasSubstr("--output"));
  const auto narrow = RunUlf(render + "--aperture 0.001 -o " + Out("narrow.png"));
  EXPECT_EQ(narrow.exit_code, 0) << narrow.errors;
  EXPECT_THAT(narrow.errors, HasSubstr("no wider than the viewpoints are apart"));
  const auto wide = RunUlf(render + "--aperture 0.5 -o " + Out("wide.png"));
  EXPECT_THAT(wide.errors, testing::Not(HasSubstr("no wider")));
  const auto clipped = RunUlf(render + "--frames 1:9/2 -o " + Out("clipped"));
  EXPECT_EQ(clipped.exit_code, 0) << clipped.errors;
  EXPECT_THAT(clipped.errors, HasSubstr("the path ends after 2 pictures"));
  const auto resized = RunUlf(render + "--frames 0:1/2 --width 48 -o " + Out("clipped"));
  EXPECT_EQ(resized.exit_code, 2) << resized.errors;
  EXPECT_THAT(resized.errors, AllOf(HasSubstr("96x72"), HasSubstr("48x36")));
}

TEST_F(RenderCommand, TriesTrackedPointsWhereGiven) {
  cv::RNG random(2);
  std::vector<ScenePoint> points;
  for (int i = 0; i < 300; ++i) points.push_back({{random.uniform(-2., 2.), random.uniform(-2., 2.), 0}});
  WriteFileAtomically(dir_ / "points.ply", PointPlyBytes(points));
  const auto chosen = RunUlf("render " + dir_.string() + " --field linear -o " + Out("a.png"));
  ASSERT_EQ(chosen.exit_code, 0) << chosen.errors;
  EXPECT_THAT(chosen.errors,
              testing::ContainsRegex(
                  "The proxy planes (shows left-out photographs best: [0-9.]+ dB|is taken, with [^(]*) "
                  "\\(points [0-9.]+, plane [0-9.]+\\)\\. \\(--explain says more\\)"))
      << "the plane turns with the camera, what was photographed does not";
  const auto why = RunUlf("render " + dir_.string() + " --field linear --explain -o " + Out("b.png"));
  EXPECT_THAT(why.errors, testing::ContainsRegex("proxy: the first within.*\n  plane +[0-9.]+ dB, .*\n\\* "
                                                 "planes +[0-9.]+ dB, .*\n  points +[0-9.]+ dB"));
  const auto in_json =
      RunUlf("render " + dir_.string() + " --field linear --explain --json -o " + Out("c.png"));
  const auto explained = JsonFromText(in_json.output)["explain"];
  EXPECT_EQ(explained[0]["question"], "proxy");
  EXPECT_THAT(explained[0]["candidates"][1]["evidence"].get<std::string>(), HasSubstr("s a picture"));
  const auto given = RunUlf("evaluate " + dir_.string() + " --proxy points --fields linear --json");
  ASSERT_EQ(given.exit_code, 0) << given.errors;
  EXPECT_GT(JsonFromText(given.output)["results"][0]["psnr_db"], 30);
}

// A set by another program: no journal, and points under a name of its own.
TEST_F(RenderCommand, PointsAreUsedWithoutAJournal) {
  const auto text = [](int count) {
    cv::RNG random(2);
    std::string ply = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n",
        count);
    for (int i = 0; i < count; ++i)
      ply += fmt::format("{} {} 0\n", random.uniform(-2., 2.), random.uniform(-2., 2.));
    return ply;
  };
  std::filesystem::remove(dir_ / "journal.jsonl");
  std::filesystem::remove(dir_ / "points.ply");
  nlohmann::json document = JsonFromText(ReadWholeFile(dir_ / "transforms.json"));
  document["ply_file_path"] = "sparse_pc.ply";
  WriteFileAtomically(dir_ / "transforms.json", JsonText(document));
  WriteFileAtomically(dir_ / "sparse_pc.ply", text(300));
  const auto scored = RunUlf("evaluate " + dir_.string() + " --proxy points --fields linear --json");
  ASSERT_EQ(scored.exit_code, 0) << scored.errors;
  EXPECT_GT(JsonFromText(scored.output)["results"][0]["psnr_db"], 30);
  const auto drawn = RunUlf("render " + dir_.string() + " --proxy points --field linear -o " + Out("a.png"));
  EXPECT_EQ(drawn.exit_code, 0) << drawn.errors;
  // Without a vertex it is a set without points, and no reason to fail.
  WriteFileAtomically(dir_ / "sparse_pc.ply", text(0));
  const auto without = RunUlf("render " + dir_.string() + " --field linear -o " + Out("b.png"));
  EXPECT_EQ(without.exit_code, 0) << without.errors;
}

TEST_F(RenderCommand, DrawsByProcessorWithoutOpenGl) {
  const std::string render = "render " + dir_.string() + " --field linear --proxy plane --width 48 -o ";
  ASSERT_EQ(RunUlf(render + Out("gl.png")).exit_code, 0);
  const test::WithoutOpenGl here;
  const auto without = RunUlf(render + Out("cpu.png"));
  const auto wanted = RunUlf(render + Out("none.png") + " --renderer gl");
  EXPECT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_THAT(without.errors,
              AllOf(HasSubstr("OpenGL 4.5"),
                    HasSubstr("the reference renderer draws the pictures, on the processor")));
  EXPECT_LE(cv::norm(cv::imread(Out("gl.png")), cv::imread(Out("cpu.png")), cv::NORM_INF), 2);
  EXPECT_EQ(wanted.exit_code, 1);
  EXPECT_THAT(wanted.errors, HasSubstr("--renderer reference"));
}

TEST_F(RenderCommand, EvaluateWorksWithoutOpenGl) {
  const std::string evaluate = "evaluate " + dir_.string() + " --fields linear --proxy plane --json";
  const test::WithoutOpenGl here;
  const auto without = RunUlf(evaluate);
  const auto wanted = RunUlf(evaluate + " --renderer gl");
  ASSERT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_THAT(without.errors, HasSubstr("the reference renderer draws the pictures, on the processor"));
  EXPECT_GT(JsonFromText(without.output)["results"][0]["psnr_db"], 20);
  EXPECT_EQ(wanted.exit_code, 1);
  EXPECT_THAT(wanted.errors, AllOf(HasSubstr("libegl-mesa0"), HasSubstr("or use --renderer reference")));
}

TEST_F(RenderCommand, EvaluateReportsAsAgreed) {
  const auto result =
      RunUlf("evaluate " + dir_.string() + " --every 4 --fields subdivision,lumigraph,nearest --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto report = JsonFromText(result.output);
  EXPECT_EQ(report["views"], 30);
  EXPECT_EQ(report["held_out"], 8);
  ASSERT_EQ(report["results"].size(), 3u);
  for (const auto& entry : report["results"]) {
    for (const char* key : {"field", "level", "proxy", "psnr_db", "ssim", "ms_per_frame", "psnr_disc_db",
                            "filled_px", "rim", "inside", "per_view"})
      EXPECT_TRUE(entry.contains(key)) << key;
    EXPECT_EQ(entry["per_view"].size(), 8u);
  }
  const auto table =
      RunUlf("evaluate " + dir_.string() + " --every 4 --fields subdivision --renderer reference");
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  EXPECT_THAT(table.output, HasSubstr("subdivision"));
}

TEST_F(RenderCommand, EvaluateComparesEveryProxyThereIs) {
  std::vector<ScenePoint> points;
  for (int i = 0; i < 400; ++i) points.push_back({{0.2 * (i % 20) - 1.9, 0.2 * (i / 20) - 1.9, 0}});
  WriteFileAtomically(dir_ / "points.ply", PointPlyBytes(points));
  TriangleMesh wall;
  wall.vertices = {{-50, -50, 0}, {50, -50, 0}, {0, 50, 0}};
  wall.triangles = {{0, 1, 2}};
  WriteMeshPly(dir_ / "proxy.ply", wall);
  const std::string evaluate = "evaluate " + dir_.string() + " --every 4 --fields linear,nearest --json";
  const auto all = RunUlf(evaluate + " --table " + Out("scores.csv"));
  ASSERT_EQ(all.exit_code, 0) << all.errors;
  EXPECT_THAT(all.errors, HasSubstr("--leave-out-every 4"));
  const auto report = JsonFromText(all.output);
  std::vector<std::string> proxies;
  for (const auto& result : report["results"]) proxies.push_back(result["proxy"].get<std::string>());
  EXPECT_THAT(proxies,
              testing::ElementsAre("plane", "plane", "planes", "planes", "points", "points", "mesh", "mesh"));
  const std::string table = ReadWholeFile(Out("scores.csv"));
  EXPECT_EQ(std::ranges::count(table, '\n'), 9);
  for (const char* text : {"field,field_used,proxy,views,ms_per_frame,psnr_db", "linear,linear,\"plane\",",
                           "nearest,nearest,\"mesh\","})
    EXPECT_THAT(table, HasSubstr(text));
}

TEST_F(RenderCommand, WrongUsageExitsWithTwoFailureWithOne) {
  const std::string dir = dir_.string();
  EXPECT_EQ(RunUlf("render " + dir + " --field bicubic -o " + Out("x.png")).exit_code, 2);
  for (const char* bad : {"1,2", "1,2,nan,1", "1,2,3,inf", "1,2,3,-1"})
    EXPECT_EQ(RunUlf("render " + dir + " --subject " + bad + " -o " + Out("x.png")).exit_code, 2) << bad;
  EXPECT_EQ(RunUlf("render " + dir + " --width 100000 -o " + Out("x.png")).exit_code, 2);
  EXPECT_EQ(RunUlf("render " + dir + " --level 9 -o " + Out("x.png")).exit_code, 2);
  EXPECT_EQ(RunUlf("render " + dir + " -o " + Out("x.gif")).exit_code, 2);
  EXPECT_EQ(RunUlf("render").exit_code, 2);
  EXPECT_EQ(RunUlf("evaluate " + dir + " --every 1").exit_code, 2);
  EXPECT_EQ(RunUlf("render " + Out("nowhere") + " -o " + Out("x.png")).exit_code, 1);
  const auto without_path = RunUlf("render " + dir + " --path " + Out("nopath.txt") + " -o " + Out("x.png"));
  EXPECT_EQ(without_path.exit_code, 1);
  EXPECT_THAT(without_path.errors, HasSubstr("nopath.txt: no such camera path"));
  EXPECT_THAT(without_path.errors, testing::Not(HasSubstr("left-out"))) << "said after all was tried out";
  const auto light_field = ReadLightField(dir_);
  std::filesystem::resize_file(dir_ / light_field.views[3].image_path, 100);
  const auto truncated = RunUlf("render " + dir + " -o " + Out("x.png"));
  EXPECT_EQ(truncated.exit_code, 1);
  EXPECT_THAT(truncated.errors, HasSubstr("truncated"));
}

TEST_F(RenderCommand, ReportsLightThatCannotBeFound) {
  const std::string evaluate = "evaluate " + dir_.string() + " --fields linear --proxy plane --light fit";
  const auto refused = RunUlf(evaluate);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("--light fit"), HasSubstr("only a mesh")));
}

// In uneven light left-out views would tell of exposures, not of fields.
TEST_F(RenderCommand, FieldsAreComparedInEvenLight) {
  TriangleMesh plane = *test::PlaneAndSquare();
  plane.triangles.resize(2);
  WriteMeshPly(dir_ / "proxy.ply", plane);
  for (const View& view : ReadLightField(dir_).views) {
    if (view.id % 2 == 0) continue;
    const std::string file = (dir_ / view.image_path).string();
    cv::imwrite(file, 0.7 * cv::imread(file));
  }
  const auto psnr_db = [&](const std::string& light) {
    const auto run = RunUlf("render " + dir_.string() + " --proxy mesh --frames 1 --explain --json --light " +
                            light + " -o " + Out(light + ".png"));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    const auto fields = JsonFromText(run.output)["explain"][0];
    EXPECT_EQ(fields["question"], "blending field");
    return std::stod(fields["candidates"][0]["evidence"].get<std::string>());
  };
  EXPECT_GT(psnr_db("fit"), psnr_db("as-recorded") + 3);
}

// What is said to skip the comparison makes the picture whose figure was told.
TEST_F(RenderCommand, TheTipMakesTheSamePicture) {
  // All is compared with all, at every size in the same way.
  std::filesystem::remove_all(dir_);
  test::WriteLightField(
      dir_, {.viewpoints = test::GridViewpoints(5, 4, 0.2, 2.0), .width = 48, .height = 36, .focal_px = 40},
      true);
  WriteMeshPly(dir_ / "proxy.ply", *test::PlaneAndSquare());
  for (const View& view : ReadLightField(dir_).views) {
    if (view.id % 2 == 0) continue;  // uneven light, which is evened over the mesh
    const std::string file = (dir_ / view.image_path).string();
    cv::imwrite(file, 0.8 * cv::imread(file));
  }
  int number = 0;
  for (const std::string asked : {"--field soft --soft-width 0.8", "--field subdivision --level 2",
                                  "--proxy plane", "--proxy plane:fitted --field lumigraph", ""}) {
    const std::string by_evidence = Out(fmt::format("evidence{}.png", number)),
                      by_name = Out(fmt::format("name{}.png", number++));
    const auto chosen = RunUlf("render " + dir_.string() + " " + asked + " -o " + by_evidence);
    ASSERT_EQ(chosen.exit_code, 0) << chosen.errors;
    constexpr char kTip[] = "to skip this comparison the next time: ";
    const std::size_t at = chosen.errors.find(kTip);
    if (at == std::string::npos) {
      EXPECT_THAT(asked, HasSubstr("plane:fitted"))
          << "nothing else was without a comparison: " << chosen.errors;
      continue;
    }
    const std::size_t begin = at + sizeof kTip - 1;
    const std::string tip = chosen.errors.substr(begin, chosen.errors.find('\n', begin) - begin);
    const auto again = RunUlf("render " + dir_.string() + " " + tip + " -o " + by_name);
    ASSERT_EQ(again.exit_code, 0) << again.errors;
    EXPECT_EQ(ReadWholeFile(by_name), ReadWholeFile(by_evidence)) << asked << " -> " << tip;
  }
}

TEST_F(RenderCommand, ProxiesAreNamedOrSaidToBeMissing) {
  const std::string dir = dir_.string();
  const auto unknown = RunUlf("render " + dir + " --proxy sphere -o " + Out("x.png"));
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("--proxy sphere"));
  EXPECT_EQ(RunUlf("render " + dir + " --proxy plane:0,0,0,1 -o " + Out("x.png")).exit_code, 2);
  const auto missing = RunUlf("render " + dir + " --proxy mesh -o " + Out("x.png"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.errors, HasSubstr("ulf proxy " + dir));
  const auto pointless = RunUlf("render " + dir + " --proxy points -o " + Out("x.png"));
  EXPECT_EQ(pointless.exit_code, 1);
  EXPECT_THAT(pointless.errors, HasSubstr("0 tracked points"));

  // The true surface, and a plane far behind it.
  std::ofstream(Out("true.obj")) << "v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nf 1 2 3 4\n";
  const auto compared = RunUlf("evaluate " + dir + " --fields linear --proxy plane:0,0,1,-2 --proxy " +
                               Out("true.obj") + " --json");
  ASSERT_EQ(compared.exit_code, 0) << compared.errors;
  const auto report = JsonFromText(compared.output);
  ASSERT_EQ(report["results"].size(), 2u);
  EXPECT_EQ(report["results"][0]["proxy"], "plane:0,0,1,-2");
  EXPECT_EQ(report["results"][1]["proxy"], "true.obj");
  EXPECT_LT(report["results"][0]["psnr_db"], 25);
  EXPECT_GT(report["results"][1]["psnr_db"], 30);

  // Another scene's mesh: rendered as asked, and said.
  std::ofstream(Out("strange.obj")) << "v -50 -50 1\nv 50 -50 1\nv 50 50 -3\nv -50 50 -3\nf 1 2 3 4\n";
  const auto strange =
      RunUlf("render " + dir + " --proxy " + Out("strange.obj") + " -o " + Out("strange.png"));
  EXPECT_EQ(strange.exit_code, 0);
  EXPECT_THAT(strange.errors, HasSubstr("is it a mesh of this scene"));
  const auto right = RunUlf("render " + dir + " --proxy " + Out("true.obj") + " -o " + Out("right.png"));
  EXPECT_THAT(right.errors, testing::Not(HasSubstr("is it a mesh of this scene")));
  EXPECT_THAT(right.errors, HasSubstr("--proxy " + Out("true.obj") + " --field "));
}

// ---- Viewpoints that are no use, or little ----

class OddViewpoints : public testing::Test {
 protected:
  test::CommandResult Render(const std::vector<Vector3d>& viewpoints, const std::string& rest = "") {
    const std::filesystem::path dir = scratch_ / fmt::format("lf{}", ++count_);
    test::WriteLightField(dir, {.viewpoints = viewpoints}, true);
    return RunUlf("render " + dir.string() + " " + rest + " -o " + Picture());
  }
  std::string Picture() const { return (scratch_ / "x.png").string(); }
  test::ScratchFolder scratch_;
  int count_ = 0;
};

// Whatever is too near the centre to have a direction is as good as there.
TEST_F(OddViewpoints, SubjectsCentreAsksForAnotherSubject) {
  for (const char* subject : {"0,0,2,0.3", "0,0,2.0000000000001,0.3", "0,0,2.0000000009,0.3"}) {
    const auto result =
        Render(std::vector<Vector3d>(4, {0, 0, 2}), std::string("--zoom 1 --subject ") + subject);
    EXPECT_EQ(result.exit_code, 1) << subject;
    EXPECT_THAT(result.errors, HasSubstr("every view stands at the subject's centre")) << subject;
    EXPECT_THAT(result.errors, HasSubstr("--subject")) << subject;
    EXPECT_FALSE(std::filesystem::exists(Picture())) << subject;
  }
}

TEST_F(OddViewpoints, PicturesThatShowNothingAreSaid) {
  std::ofstream(scratch_ / "away.txt") << "0 0 0 2 0 0 0 1\n";  // looks along +z, away from the scene
  const auto away = Render(test::GridViewpoints(4, 4, 0.2, 2.0),
                           "--proxy plane:0,0,1,0 --field linear --path " + (scratch_ / "away.txt").string());
  EXPECT_EQ(away.exit_code, 0) << away.errors;
  EXPECT_THAT(away.errors, HasSubstr("pictures that show nothing: 1 of 1"));
  const auto towards = Render(test::GridViewpoints(4, 4, 0.2, 2.0), "--proxy plane --field linear");
  EXPECT_THAT(towards.errors, testing::Not(HasSubstr("show nothing:")));
}

TEST_F(OddViewpoints, APathFarFromThemIsSaid) {
  const auto render = [&](double distance, const std::string& rest) {
    std::ofstream(scratch_ / "far.txt") << "0 0 0 " << distance << " 1 0 0 0\n";
    return Render(test::GridViewpoints(4, 4, 0.2, 2.0),
                  "--proxy plane --field linear --path " + (scratch_ / "far.txt").string() + rest)
        .errors;
  };
  EXPECT_THAT(render(40, ""), HasSubstr("far outside the recorded viewpoints"));
  EXPECT_THAT(render(2, ""), testing::Not(HasSubstr("outside the recorded viewpoints")));
  EXPECT_THAT(render(2, " --aperture 5"), HasSubstr("wider than the viewpoints reach"));
  EXPECT_THAT(render(2, " --aperture 0.3"), testing::Not(HasSubstr("wider than the viewpoints reach")));
}

// A camera held on its side, round a statue: the ring's axis is upwards, whichever way its cameras call up.
TEST_F(OddViewpoints, AxisOfASidewaysRingIsUp) {
  LightField light_field;
  for (const Vector3d& center : test::RingViewpoints(24, 0, 2, 0.02)) {
    View& view = light_field.views.emplace_back();
    const Rigid3 upright = LookAt(center, Vector3d::Zero(), Vector3d::UnitZ());
    view.cam_from_world =
        Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ())), Vector3d::Zero()} *
        upright;
  }
  EXPECT_GT(std::abs(light_field.UpInWorld().z()), 0.99);
  for (View& view : light_field.views)
    view.cam_from_world = LookAt(view.cam_from_world.OriginInSource(), Vector3d::Zero(), Vector3d::UnitZ());
  EXPECT_GT(light_field.UpInWorld().z(), 0.99);

  const std::vector<Vector3d> grid = test::GridViewpoints(4, 4, 0.2, 2.0);
  EXPECT_EQ(Render(grid, "--up 0,0").exit_code, 2);
  EXPECT_EQ(Render(grid, "--gpu-memory 0.5").exit_code, 2);  // nothing to be seen would fit
  const auto picture = [&](const std::string& rest) {
    const auto result = Render(grid, "--path orbit --proxy plane --field linear --zoom 1" + rest);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return cv::imread(Picture());
  };
  const cv::Mat upright = picture(""), again = picture(" --up 0,2,0"), turned = picture(" --up 1,0,0");
  EXPECT_EQ(cv::norm(upright, again, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(upright, turned, cv::NORM_L1), 5 * static_cast<double>(upright.total()));
}

TEST_F(OddViewpoints, TwoFarGroupsAreReportedAndDrawn) {
  std::vector<Vector3d> antipodal = test::GridViewpoints(4, 4, 0.2, 2.0);
  for (const Vector3d& center : test::GridViewpoints(4, 4, 0.2, -2.0)) antipodal.push_back(center);
  const auto result = Render(antipodal, "--field linear --proxy plane --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("they stand in 2 groups, 60 deg or more apart"));
  EXPECT_EQ(JsonFromText(result.output)["field"], "linear") << "each group is a surface";
  // The middle of the path is in a group, not between the two.
  EXPECT_EQ(JsonFromText(result.output)["empty_share"], 0);
  const auto one = Render(test::GridViewpoints(4, 4, 0.2, 2.0), "--field linear --proxy plane");
  EXPECT_THAT(one.errors, testing::Not(HasSubstr("groups")));
}

// What a turned light field looks like: the same scene, upside down in its world, cameras with it; or cameras
// that look the other way, as those of another convention do.
void WriteTurned(const std::filesystem::path& dir, const Rigid3& turned_from_world,
                 const Eigen::Quaterniond& turned_from_cam) {
  const test::SceneSpec spec = SmallSpec();
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(spec.width, spec.height, spec.focal_px);
  auto writer = LightFieldWriter::Create(dir, header);
  std::uint64_t id = 0;
  for (const Vector3d& center : spec.viewpoints) {
    View view;
    const Rigid3 pose = LookAt(center, Vector3d::Zero(), Vector3d::UnitY());
    view.cam_from_world = Rigid3{turned_from_cam, Vector3d::Zero()} * pose * turned_from_world.Inverse();
    Frame frame;
    frame.image = {.pixels = test::PhotographOfPlane(header.camera, pose), .transfer = Transfer::kSrgb};
    frame.id = id++;
    writer.AddView(frame, view);
  }
  writer.Close(1);
}

TEST(FlippedWorld, ThePictureStandsUprightOrItIsSaid) {
  test::ScratchFolder scratch;
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity(), half_turn(0, 1, 0, 0);
  WriteTurned(scratch / "upright", {}, straight);
  WriteTurned(scratch / "flipped", {half_turn, {0.3, 0.1, -2}}, straight);
  WriteTurned(scratch / "backwards", {}, half_turn);
  const auto render = [&](const std::string& name, const std::string& rest = "") {
    return RunUlf("render " + (scratch / name).string() + rest +
                  " --field linear --proxy plane --zoom 1.5 -o " + (scratch / (name + ".png")).string());
  };
  for (const char* name : {"upright", "flipped"}) {
    const auto result = render(name);
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.errors, testing::Not(HasSubstr("looks away"))) << name;
  }
  const cv::Mat upright = cv::imread((scratch / "upright.png").string());
  EXPECT_GT(cv::PSNR(upright, cv::imread((scratch / "flipped.png").string())), 45);
  cv::Mat turned;
  cv::rotate(upright, turned, cv::ROTATE_180);
  EXPECT_LT(cv::PSNR(upright, turned), 25) << "one would not see it";

  const auto unnamed = render("backwards");
  EXPECT_EQ(unnamed.exit_code, 2);
  EXPECT_THAT(unnamed.errors, HasSubstr("the poses are flipped"));
  const auto named = render("backwards", " --subject 0,0,0,0.3");
  EXPECT_EQ(named.exit_code, 0) << named.errors;
  EXPECT_THAT(named.errors, HasSubstr("every camera looks away from the subject"));
}

// Cameras with parallel axes that name no subject: the command asks.
TEST(RenderCommandAlone, AsksForASubjectWhereThereIsNone) {
  test::ScratchFolder scratch;
  {
    CaptureHeader header;
    header.camera = CameraModel::Pinhole(32, 24, 30);
    auto writer = LightFieldWriter::Create(scratch / "lf", header);
    for (int i = 0; i < 4; ++i) {
      View view;
      view.cam_from_world.translation = Vector3d(0.1 * i, 0, 0);
      Frame frame;
      frame.image.pixels = cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(90));
      writer.AddView(frame, view);
    }
    writer.Close(1);
  }
  const std::string dir = (scratch / "lf").string();
  const auto asked = RunUlf("render " + dir + " -o " + (scratch / "x.png").string());
  EXPECT_EQ(asked.exit_code, 2);
  EXPECT_THAT(asked.errors, HasSubstr("--subject"));
  const auto given = RunUlf("render " + dir + " --subject 0,0,5,1 -o " + (scratch / "x.png").string());
  EXPECT_EQ(given.exit_code, 0) << given.errors;
}

}  // namespace
}  // namespace ulf::render_command_test
