// Tests: render/output/picture_files, render/output/tiled_rendering, render/output/camera_path,
// render/output/video, commands/rendering/render_command.
//
// What `ulf render` leaves: formats, layers, folders that are filled by several and go on after a kill.
#include "render/output/picture_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <signal.h>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/available_memory.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/points/point_io.h"
#include "core/video/video_reader.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/output/camera_path.h"
#include "render/output/tiled_rendering.h"
#include "render/output/video.h"
#include "render/proxy/points_proxy.h"
#include "render/renderer/reference_renderer.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::picture_files_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using test::RunUlf;
using testing::ElementsAre;
using testing::HasSubstr;

const CameraModel kCamera = CameraModel::Pinhole(64, 48, 60);
const Rigid3 kPose = LookAt({0.1, 0.05, 2.1}, Vector3d::Zero(), Vector3d::UnitY());

// One channel of an EXR file, by OpenEXR itself.
cv::Mat Channel(const fs::path& file, const std::string& name) {
  Imf::InputFile exr(file.c_str());
  const auto window = exr.header().dataWindow();
  cv::Mat pixels(window.max.y + 1, window.max.x + 1, CV_32F);
  Imf::FrameBuffer buffer;
  buffer.insert(name,
                Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(pixels.data), sizeof(float), pixels.step));
  exr.setFrameBuffer(buffer);
  exr.readPixels(window.min.y, window.max.y);
  return pixels;
}

TEST(Exr, NamesItsColourSpaceWhereTheColoursAreKnown) {
  test::ScratchFolder scratch;
  Rendering picture;
  picture.linear = cv::Mat(4, 6, CV_32FC3, cv::Scalar::all(0.5));
  picture.confidence = cv::Mat::ones(4, 6, CV_32FC1);
  picture.drawn = cv::Mat(4, 6, CV_8UC1, cv::Scalar(255));
  for (const bool knows_colors : {true, false}) {
    const fs::path file = scratch / "x.exr";
    std::ofstream(file, std::ios::binary)
        << PictureBytes(picture, {.format = PictureFormat::kExr, .knows_colors = knows_colors});
    EXPECT_EQ(ExrAttribute(file.string(), "colorInteropID"), knows_colors ? "lin_rec709_scene" : "");
    EXPECT_EQ(ExrAttribute(file.string(), "comments").empty(), knows_colors);
    EXPECT_EQ(ExrColorsOf(file.string()), knows_colors ? ExrColors(kRec709) : std::nullopt);
    EXPECT_EQ(ReadExr(file.string()).at<cv::Vec3f>(2, 3), cv::Vec3f::all(0.5)) << "read with and without";
  }
}

TEST(Exr, ChannelsLayersAndValuesByItsOwnLibrary) {
  test::ScratchFolder scratch;
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(4, 3, 0.2, 2.0)});
  const CameraModel wide = CameraModel::Pinhole(64, 48, 20);  // with corners that nobody sees
  const Rendering picture =
      MakeRenderer(scene, {.renderer = RendererKind::kReference, .depth = true, .weights = true})
          ->Render(wide, kPose);
  ASSERT_GT(picture.empty_px, 0);
  for (const ExrCompression compression : {ExrCompression::kZip, ExrCompression::kPiz}) {
    const fs::path file = scratch / "x.exr";
    std::ofstream(file, std::ios::binary) << PictureBytes(
        picture, {.format = PictureFormat::kExr, .exposure_stops = 3, .exr_compression = compression});
    Imf::InputFile exr(file.c_str());
    const Imf::ChannelList& channels = exr.header().channels();
    for (const char* name : {"R", "G", "B", "A", "confidence.Y"}) {
      ASSERT_NE(channels.findChannel(name), nullptr) << name;
      EXPECT_EQ(channels.findChannel(name)->type, Imf::HALF) << name;
    }
    ASSERT_NE(channels.findChannel("Z"), nullptr);
    EXPECT_EQ(channels.findChannel("Z")->type, Imf::FLOAT);
    std::set<std::string> layers;
    channels.layers(layers);
    ASSERT_EQ(layers.size(), 1 + picture.weights.size());
    EXPECT_TRUE(layers.contains("confidence"));
    EXPECT_TRUE(layers.contains(fmt::format("weight.{:06}", picture.weights.front().view_id)));

    const cv::Mat r = Channel(file, "R"), b = Channel(file, "B"), a = Channel(file, "A"),
                  z = Channel(file, "Z"), confidence = Channel(file, "confidence.Y");
    cv::Mat sum = cv::Mat::zeros(r.size(), CV_32F);
    for (const ViewWeights& view : picture.weights)
      sum += Channel(file, fmt::format("weight.{:06}.Y", view.view_id));
    for (int y = 0; y < r.rows; ++y)
      for (int x = 0; x < r.cols; ++x) {
        const cv::Vec3f& light = picture.linear.at<cv::Vec3f>(y, x);
        EXPECT_NEAR(r.at<float>(y, x), light[2], 1e-3 * light[2]);  // not brighter: exposure is for displays
        EXPECT_NEAR(b.at<float>(y, x), light[0], 1e-3 * light[0]);
        EXPECT_EQ(z.at<float>(y, x), picture.depth.at<float>(y, x));
        EXPECT_NEAR(confidence.at<float>(y, x), picture.confidence.at<float>(y, x), 1e-3);
        EXPECT_EQ(a.at<float>(y, x), picture.drawn.at<std::uint8_t>(y, x) ? 1 : 0);
        EXPECT_NEAR(sum.at<float>(y, x), a.at<float>(y, x), 3e-3);
      }
  }
}

// The field's picture blends one colour a view: with the weights it can be made again.
TEST(Weights, MatchThePictureInBothRenderers) {
  const auto scene = test::MakeScene({.viewpoints = test::CapViewpoints(40, 0.6, 2.0, 0.03)});
  for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference})
    for (const FieldKind field :
         {FieldKind::kSubdivision, FieldKind::kLumigraphPerPixel, FieldKind::kNearest}) {
      const auto renderer = MakeRenderer(
          scene, {.field = {.kind = field}, .renderer = kind, .show_field = true, .weights = true});
      const Rendering picture = renderer->Render(kCamera, kPose);
      cv::Mat again = cv::Mat::zeros(picture.linear.size(), CV_32FC3);
      for (const ViewWeights& view : picture.weights)
        for (int y = 0; y < again.rows; ++y)
          for (int x = 0; x < again.cols; ++x)
            again.at<cv::Vec3f>(y, x) +=
                static_cast<float>(view.weight.at<cv::float16_t>(y, x)) * ViewColor(view.view_id);
      cv::Mat difference;
      cv::absdiff(again, picture.linear, difference);
      EXPECT_LT(cv::mean(difference)[1], 0.002) << renderer->Name() << ", " << FieldName(field);
    }
}

TEST(Depth, FromOpenGlEqualsTheProxys) {
  const auto scene = test::MakeScene({.viewpoints = test::GridViewpoints(4, 3, 0.2, 2.0)});
  for (const auto& proxy : std::vector<std::shared_ptr<const Proxy>>{
           scene->proxy, std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare())}) {
    const auto renderer = MakeRenderer(WithProxy(*scene, proxy), {.depth = true});
    const cv::Mat depth = renderer->Render(kCamera, kPose).depth, truth = proxy->Depth(kCamera, kPose);
    ASSERT_EQ(depth.size(), truth.size());
    cv::Mat difference;
    cv::absdiff(depth, truth, difference);
    EXPECT_LT(cv::countNonZero(difference > 1e-3 * truth), 0.01 * static_cast<double>(truth.total()))
        << proxy->Name();
  }
}

TEST(Tiles, EqualThePictureDrawnAtOnce) {
  const auto plane =
      test::MakeScene({.viewpoints = test::GridViewpoints(4, 3, 0.2, 2.0), .with_square = true});
  // Each tile by itself would triangulate others of them.
  const auto points =
      WithProxy(*plane, std::make_shared<PointsProxy>(plane->subject, test::PointsOfPlaneAndSquare(300, 30)));
  for (const std::shared_ptr<const RenderScene>& scene : {std::shared_ptr<const RenderScene>(plane), points})
    for (const RendererKind kind : {RendererKind::kGl, RendererKind::kReference}) {
      const auto renderer = MakeRenderer(scene, {.renderer = kind, .depth = true, .weights = true});
      const Rendering whole = renderer->Render(kCamera, kPose),
                      tiled = RenderInTiles(*renderer, kCamera, kPose, 25);
      SCOPED_TRACE(renderer->Name() + ", " + scene->proxy->Name());
      EXPECT_EQ(renderer->scene().proxy, scene->proxy);
      // Triangles meet at other pixels by a rounding.
      const double differ_at_most =
          kind == RendererKind::kGl ? 0.005 * static_cast<double>(kCamera.width * kCamera.height) : 0;
      cv::Mat difference;
      cv::absdiff(whole.linear, tiled.linear, difference);
      EXPECT_LE(cv::countNonZero(difference.reshape(1) > 2e-3), differ_at_most);
      cv::absdiff(whole.depth, tiled.depth, difference);
      EXPECT_LE(cv::countNonZero(difference > 1e-4), differ_at_most);
      EXPECT_EQ(cv::norm(whole.drawn, tiled.drawn, cv::NORM_INF), 0);
      EXPECT_EQ(whole.weights.size(), tiled.weights.size());
      EXPECT_EQ(whole.empty_px, tiled.empty_px);
    }
}

TEST(Memory, RefusesAPictureThatDoesNotFit) {
  EXPECT_GT(MemoryForPicture(16384, 16384, {}), 5'000'000'000u);
  EXPECT_LT(MemoryForPicture(1920, 1080, {.format = PictureFormat::kExr}), 500'000'000u);
  EXPECT_GT(AvailableMemory(), 1'000'000u);
  RequireMemory(640, 480, {}, 1'000'000'000);
  EXPECT_THAT(
      [&] { RequireMemory(16384, 16384, {}, 2'000'000'000); },
      testing::ThrowsMessage<Error>(testing::AllOf(HasSubstr("16384x16384"), HasSubstr("2.0 GB are free"))));
}

TEST(Frames, NumbersAndRangesAreRead) {
  EXPECT_EQ(ParseFrames(""), FrameRange{});
  EXPECT_EQ(ParseFrames("12"), (FrameRange{.count = 12}));
  EXPECT_EQ(ParseFrames("3:7"), (FrameRange{.first = 3, .end = 7}));
  EXPECT_EQ(ParseFrames("3:"), (FrameRange{.first = 3}));
  EXPECT_EQ(ParseFrames(":7/9"), (FrameRange{.count = 9, .end = 7}));
  for (const char* bad : {"0", "-3", "a", "3:3", "5:2", "1:b", "1:2/0", "1:2/", "1.5", "1:2:3"})
    EXPECT_THROW(ParseFrames(bad), Refusal) << bad;
}

TEST(PictureOnADisplay, ExposureIsInStopsOfLight) {
  Rendering picture;
  picture.linear = cv::Mat(2, 2, CV_32FC3, cv::Scalar::all(0.1));
  const cv::Mat brighter = DisplaySrgb8(picture.linear, 2);
  EXPECT_EQ(brighter.at<cv::Vec3b>(0, 0)[0], std::lround(255 * SrgbFromLinear(0.4f)));
  // As much light as a half holds is white.
  EXPECT_EQ(DisplaySrgb8(cv::Mat(1, 1, CV_32FC3, cv::Scalar::all(65504)), 0).at<cv::Vec3b>(0, 0)[0], 255);
  const std::string png16 = PictureBytes(picture, {.format = PictureFormat::kPng16, .exposure_stops = -1});
  const cv::Mat read = cv::imdecode(std::vector<char>(png16.begin(), png16.end()), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_16UC3);
  EXPECT_EQ(read.at<cv::Vec3w>(1, 1)[2], std::lround(65535 * SrgbFromLinear(0.05f)));
}

// ---- The command ----

class RenderToFiles : public testing::Test {
 protected:
  void SetUp() override {
    test::WriteLightField(dir_, {.viewpoints = test::GridViewpoints(5, 4, 0.2, 2.0)}, true);
  }
  std::string Out(const std::string& name) const { return (scratch_ / name).string(); }
  // By what is chosen for the light field: tried out on left-out views, which takes longer than the pictures.
  std::string RenderAsChosen(const std::string& rest) const {
    return "render " + dir_.string() + " --renderer reference " + rest;
  }
  // By what is quickest, unless `rest` asks for something else.
  std::string Render(std::string rest) const {
    for (const auto& [option, value] :
         {std::pair{"--field", "linear"}, {"--proxy", "plane"}, {"--zoom", "1"}})
      if (!rest.starts_with(option) && rest.find(std::string(" ") + option) == std::string::npos)
        rest += std::string(" ") + option + " " + value;
    return RenderAsChosen(rest);
  }
  static std::vector<std::string> Pictures(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().filename() != "render.json") names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  test::ScratchFolder scratch_;
  fs::path dir_ = scratch_ / "lf";
};

TEST_F(RenderToFiles, PartsOfAPathHaveTheNumbersOfTheWhole) {
  fs::remove_all(dir_);
  test::WriteLightField(
      dir_, {.viewpoints = test::GridViewpoints(5, 4, 0.2, 2.0), .width = 32, .height = 24, .focal_px = 27},
      true);
  const auto part = RunUlf(RenderAsChosen("--frames 2:4/6 -o " + Out("parts")));
  ASSERT_EQ(part.exit_code, 0) << part.errors;
  EXPECT_THAT(Pictures(scratch_ / "parts"), ElementsAre("frame_00002.png", "frame_00003.png"));
  const auto kept_time = fs::last_write_time(scratch_ / "parts/frame_00002.png");
  const auto rest = RunUlf(RenderAsChosen("--frames 6 --json -o " + Out("parts")));
  ASSERT_EQ(rest.exit_code, 0) << rest.errors;
  EXPECT_EQ(JsonFromText(rest.output)["kept"], 2);
  EXPECT_EQ(JsonFromText(rest.output)["frames"], 4);
  EXPECT_EQ(Pictures(scratch_ / "parts").size(), 6u);
  EXPECT_EQ(fs::last_write_time(scratch_ / "parts/frame_00002.png"), kept_time);
  ASSERT_EQ(RunUlf(RenderAsChosen("--frames 6 -o " + Out("whole"))).exit_code, 0);
  for (const std::string& name : Pictures(scratch_ / "whole"))
    EXPECT_EQ(ReadWholeFile(scratch_ / "parts" / name), ReadWholeFile(scratch_ / "whole" / name)) << name;

  const auto other = RunUlf(RenderAsChosen("--frames 6 --field linear -o " + Out("parts")));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("field was subdivision, level 1, now linear"));
  const auto longer = RunUlf(RenderAsChosen("--frames 7 -o " + Out("parts")));
  EXPECT_EQ(longer.exit_code, 2);
  EXPECT_THAT(longer.errors, HasSubstr("path was"));
  EXPECT_EQ(RunUlf(Render("--frames 7 --overwrite -o " + Out("parts"))).exit_code, 0);
  EXPECT_EQ(Pictures(scratch_ / "parts").size(), 7u);
  const auto past = RunUlf(Render("--frames 9:/9 -o " + Out("past")));
  EXPECT_EQ(past.exit_code, 2);
  EXPECT_THAT(past.errors, HasSubstr("9 pictures"));
}

TEST_F(RenderToFiles, OnePictureOfSeveralSaysSo) {
  const auto said = [&](const std::string& rest) {
    const auto run = RunUlf(Render(rest));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.errors;
  };
  EXPECT_THAT(said("--frames 2 -o " + Out("a.png")),
              ::testing::AllOf(HasSubstr("the other one is not drawn"), HasSubstr("--frames 1:2/2")));
  for (const char* one : {"", "--frames 1 ", "--frames 1:2/3 "})
    EXPECT_THAT(said(one + ("-o " + Out("b.png"))), ::testing::Not(HasSubstr("not drawn"))) << one;
  WriteFileAtomically(scratch_ / "path.tum", "0 0 0 0 0 0 0 1\n1 0.1 0 0 0 0 0 1\n2 0.2 0 0 0 0 0 1\n");
  EXPECT_THAT(said("--path " + Out("path.tum") + " -o " + Out("c.png")),
              HasSubstr("the other 2 are not drawn"));
}

TEST_F(RenderToFiles, RefusesAFolderBeforeComparing) {
  ASSERT_EQ(RunUlf(Render("--frames 2 -o " + Out("d"))).exit_code, 0);
  const auto refused = [&](const std::string& rest, const std::string& why) {
    const auto run = RunUlf(RenderAsChosen(rest + " -o " + Out("d")));
    EXPECT_EQ(run.exit_code, 2) << rest;
    EXPECT_THAT(run.errors, ::testing::AllOf(HasSubstr(why), HasSubstr("choose another folder"),
                                             ::testing::Not(HasSubstr("comparison the next time"))))
        << rest;
  };
  refused("--frames 3", "path was orbit, 2 pictures");
  refused("--frames 2 --field nearest", "field was linear, now nearest");
  refused("--frames 2 --proxy points", "proxy was plane");
  std::ofstream(ReadLightField(dir_).root / ReadLightField(dir_).views[0].image_path, std::ios::app) << ' ';
  refused("--frames 2", "views was 20");
  fs::remove(scratch_ / "d/render.json");
  refused("--frames 2", "no render.json");
}

// render.json speaks for every picture of its folder: none of the former settings may stay.
TEST_F(RenderToFiles, OverwritingRemovesOlderPictures) {
  const auto render = [&](const std::string& rest) { return RunUlf(Render(rest + " -o " + Out("d"))); };
  ASSERT_EQ(render("--field nearest --frames 4").exit_code, 0);
  std::ofstream(scratch_ / "d/frame_notes.png") << "not a picture of ours";
  const auto part = render("--field linear --frames 0:2/4 --overwrite");
  ASSERT_EQ(part.exit_code, 0) << part.errors;
  EXPECT_THAT(part.errors, HasSubstr("4 pictures of another render removed (field was nearest, now linear)"));
  EXPECT_THAT(Pictures(scratch_ / "d"), ElementsAre("frame_00000.png", "frame_00001.png", "frame_notes.png"));
  const auto rest = render("--field linear --frames 4 --json");
  ASSERT_EQ(rest.exit_code, 0) << rest.errors;
  EXPECT_EQ(JsonFromText(rest.output)["frames"], 2);
  ASSERT_EQ(RunUlf(Render("--field linear --frames 4 -o " + Out("whole"))).exit_code, 0);
  for (const std::string& name : Pictures(scratch_ / "whole"))
    EXPECT_EQ(ReadWholeFile(scratch_ / "d" / name), ReadWholeFile(scratch_ / "whole" / name)) << name;

  // The same settings: only what is asked for is made again.
  const auto again = render("--field linear --frames 3:/4 --overwrite --json");
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(JsonFromText(again.output)["frames"], 1);
  EXPECT_EQ(Pictures(scratch_ / "d").size(), 5u);

  // Whose they are nobody knows: true pictures of a path have such names, too.
  fs::remove(scratch_ / "d/render.json");
  const auto unknown = render("--field linear --frames 1 --overwrite");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("no render.json"));
  EXPECT_EQ(Pictures(scratch_ / "d").size(), 5u);
}

TEST_F(RenderToFiles, ResumesOnlyWithTheSameSettings) {
  const auto corners = [&](double z) {
    std::ofstream(scratch_ / "wall.obj")
        << fmt::format("v -50 -50 {0}\nv 50 -50 {0}\nv 50 50 {0}\nf 1 2 3\n", z);
  };
  const auto points = [&](double z) {
    std::vector<ScenePoint> scattered;
    for (int i = 0; i < 49; ++i) scattered.push_back({{0.2 * (i % 7) - 0.6, 0.2 * (i / 7) - 0.6, z}});
    WriteFileAtomically(dir_ / "points.ply", PointPlyBytes(scattered));
  };
  corners(0);
  points(0);
  struct Case {
    std::string begun, goes_on, differs;
    std::function<void()> meanwhile = {};
  };
  const std::string mesh = "--field linear --proxy " + Out("wall.obj"), lumigraph = "--field lumigraph";
  const std::string tracked = "--field linear --proxy points", plane = "--field linear --proxy plane";
  int count = 0;
  for (const Case& c :
       {Case{lumigraph, lumigraph + " --lumigraph-views 3", "field was"},
        Case{lumigraph, lumigraph + " --lumigraph-resolution 0.3", "field was"},
        Case{lumigraph, lumigraph + " --lumigraph-triangles 500", "field was"},
        Case{plane, plane + " --viewpoint-mesh plane", "viewpoint mesh was sphere, now plane"},
        Case{plane, "--field linear --proxy plane:0,0,1,0.1", "proxy was"},
        Case{mesh, mesh, "proxy was", [&] { corners(0.2); }},
        Case{tracked, tracked, "proxy was", [&] { points(0.2); }},
        Case{plane, plane, "views was", [&] {
               std::ofstream(dir_ / ReadLightField(dir_).views[2].image_path, std::ios::app) << "retouched";
             }}}) {
    const std::string out = " --zoom 1 --width 24 --frames 2 -o " + Out(fmt::format("on{}", count++));
    ASSERT_EQ(RunUlf(Render(c.begun + out)).exit_code, 0) << c.begun;
    const auto same = RunUlf(Render(c.begun + out));
    EXPECT_EQ(same.exit_code, 0) << same.errors;
    if (c.meanwhile) c.meanwhile();
    const auto other = RunUlf(Render(c.goes_on + out));
    EXPECT_EQ(other.exit_code, 2) << c.goes_on;
    EXPECT_THAT(other.errors, HasSubstr(c.differs)) << c.goes_on;
  }
}

TEST_F(RenderToFiles, AKilledRenderGoesOn) {
  const std::vector<std::string> command{std::getenv("ULF_BINARY"),
                                         "render",
                                         dir_.string(),
                                         "--renderer",
                                         "reference",
                                         "--field",
                                         "linear",
                                         "--proxy",
                                         "plane",
                                         "--zoom",
                                         "1",
                                         "--frames",
                                         "40",
                                         "--width",
                                         "128",
                                         "--format",
                                         "exr",
                                         "-o",
                                         Out("killed")};
  for (const int after : {1, 4}) {
    test::ChildProcess render(command);
    const fs::path awaited = scratch_ / fmt::format("killed/frame_{:05}.exr", after);
    for (int waited = 0; waited < 3000 && !fs::exists(awaited); ++waited)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    render.Kill();
    ASSERT_TRUE(fs::exists(awaited));
    ASSERT_FALSE(fs::exists(scratch_ / "killed/frame_00039.exr")) << "it was over before it was killed";
  }
  const auto rest = RunUlf(Render("--frames 40 --width 128 --format exr --json -o " + Out("killed")));
  ASSERT_EQ(rest.exit_code, 0) << rest.errors;
  EXPECT_GE(JsonFromText(rest.output)["kept"], 5);
  ASSERT_EQ(RunUlf(Render("--frames 40 --width 128 --format exr -o " + Out("whole"))).exit_code, 0);
  for (const std::string& name : Pictures(scratch_ / "whole"))
    EXPECT_EQ(ReadWholeFile(scratch_ / "killed" / name), ReadWholeFile(scratch_ / "whole" / name)) << name;
}

TEST_F(RenderToFiles, HasTheAskedFormatsAndSizes) {
  ASSERT_EQ(RunUlf(Render("--width 1 --height 1 -o " + Out("dot.png"))).exit_code, 0);
  EXPECT_EQ(cv::imread(Out("dot.png")).size(), cv::Size(1, 1));
  ASSERT_EQ(RunUlf(Render("--width 1 --height 1 --weights -o " + Out("dot.exr"))).exit_code, 0);
  EXPECT_GT(Channel(scratch_ / "dot.exr", "Z").at<float>(0, 0), 1.5);
  ASSERT_EQ(RunUlf(Render("--format png16 -o " + Out("deep.png"))).exit_code, 0);
  EXPECT_EQ(cv::imread(Out("deep.png"), cv::IMREAD_UNCHANGED).depth(), CV_16U);
  const auto dot_video = RunUlf(Render("--width 1 --frames 2 -o " + Out("dot.mp4")));
  EXPECT_EQ(dot_video.exit_code, 1);
  EXPECT_THAT(dot_video.errors, HasSubstr("at least 2x2"));
  EXPECT_EQ(RunUlf(Render("--format exr -o " + Out("x.png"))).exit_code, 2);
  EXPECT_EQ(RunUlf(Render("--format png -o " + Out("x.mp4"))).exit_code, 2);
  EXPECT_EQ(RunUlf(Render("--weights -o " + Out("x.png"))).exit_code, 2);
  EXPECT_EQ(RunUlf(Render("--fov-deg 40 --focal-px 30 -o " + Out("x.png"))).exit_code, 2);

  // Wider than a tile: two are drawn and put together.
  ASSERT_EQ(RunUlf(Render("--width 4100 --height 3 -o " + Out("wide.png"))).exit_code, 0);
  const cv::Mat wide = cv::imread(Out("wide.png"));
  ASSERT_EQ(wide.size(), cv::Size(4100, 3));
  EXPECT_LE(cv::norm(wide.col(4095), wide.col(4096), cv::NORM_INF), 4);
  EXPECT_GT(cv::mean(wide.colRange(4096, 4100))[1], 10);

  if (test::kIsSanitized) return;  // it asks for terabytes of addresses itself
  // With two gigabytes to run in, sixteen thousand pixels square are too many, and it says so.
  const std::string limited = "ulimit -v 2000000; exec \"$ULF_BINARY\" " +
                              Render("--width 16384 --height 16384 -o " + Out("huge.png")) + " 2>" +
                              Out("says.txt");
  EXPECT_EQ(WEXITSTATUS(std::system(limited.c_str())), 1);
  EXPECT_THAT(ReadWholeFile(Out("says.txt")), HasSubstr("16384x16384 takes about"));
  EXPECT_FALSE(fs::exists(Out("huge.png")));
}

TEST_F(RenderToFiles, RefusesANumberThatContradictsThePath) {
  const Rigid3 world_from_cam = kPose.Inverse();
  const auto& c = world_from_cam.translation;
  const auto& q = world_from_cam.rotation;
  std::string lines;
  for (int i = 0; i < 3; ++i)
    lines += fmt::format("{} {} {} {} {} {} {} {}\n", i, c.x(), c.y(), c.z(), q.x(), q.y(), q.z(), q.w());
  WriteFileAtomically(scratch_ / "poses.txt", lines);
  nlohmann::json nerfstudio{{"render_width", 24}, {"render_height", 18}, {"camera_type", "perspective"}};
  for (int i = 0; i < 3; ++i)
    nerfstudio["camera_path"].push_back(
        {{"fov", 50}, {"camera_to_world", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1}}});
  WriteFileAtomically(scratch_ / "nerfstudio.json", JsonText(nerfstudio));
  const std::string with = " --field linear --proxy plane --width 24 ";
  for (const auto& [path, poses] : {std::pair{Out("poses.txt"), "3 poses"},
                                    {Out("nerfstudio.json"), "3 poses"},
                                    {dir_.string(), "20 poses"}})
    for (const char* frames : {"7", "0:2/7"}) {
      const auto refused =
          RunUlf(Render("--path " + path + with + "--frames " + frames + " -o " + Out("refused")));
      EXPECT_EQ(refused.exit_code, 2) << path;
      EXPECT_THAT(refused.errors, HasSubstr(fmt::format("--frames {}", frames)));
      EXPECT_THAT(refused.errors, HasSubstr(poses));
    }
  const std::string poses = "--path " + Out("poses.txt") + with;
  EXPECT_EQ(RunUlf(Render(poses + "--frames 1:3/3 -o " + Out("part"))).exit_code, 0);
  EXPECT_EQ(Pictures(scratch_ / "part").size(), 2u);
  EXPECT_EQ(RunUlf(Render(poses + "-o " + Out("one.png"))).exit_code, 0) << "the first one";
}

TEST_F(RenderToFiles, NamesLensesAndPaths) {
  for (const char* path : {"vertigo", "spiral"}) {
    const auto run = RunUlf(Render(std::string("--path ") + path + " --frames 3 -o " + Out(path)));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_EQ(Pictures(scratch_ / path).size(), 3u);
  }
  // A lens twice as long shows the middle half.
  ASSERT_EQ(RunUlf(Render("--focal-px 80 -o " + Out("short.png"))).exit_code, 0);
  ASSERT_EQ(RunUlf(Render("--focal-px 160 -o " + Out("long.png"))).exit_code, 0);
  ASSERT_EQ(RunUlf(Render("--fov-deg 61.9275130641 -o " + Out("degrees.png"))).exit_code, 0);
  const cv::Mat wide = cv::imread(Out("short.png")), narrow = cv::imread(Out("long.png"));
  EXPECT_LE(cv::norm(wide, cv::imread(Out("degrees.png")), cv::NORM_INF), 1);  // 96 wide at 80: 2 atan 0.6
  cv::Mat half, middle = wide(cv::Rect(24, 18, 48, 36)), difference;
  cv::resize(narrow, half, middle.size(), 0, 0, cv::INTER_AREA);
  cv::absdiff(half, middle, difference);
  EXPECT_LT(cv::mean(difference)[1], 6);
}

TEST(Disk, FullDiskIsReportedAndFilesStay) {
  test::ScratchFolder scratch;
  if (const auto problem = test::MountSmallDisk(scratch.path(), 6 << 20)) GTEST_SKIP() << *problem;
  test::WriteLightField(scratch / "lf", {.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)}, true);
  const auto run = RunUlf("render " + (scratch / "lf").string() +
                          " --field linear --proxy plane --width 480 --frames 60 --format exr -o " +
                          (scratch / "out").string());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.errors, HasSubstr("No space left"));
  int whole = 0;
  for (const auto& entry : fs::directory_iterator(scratch / "out")) {
    if (entry.path().filename() == "render.json") continue;
    EXPECT_EQ(entry.path().extension(), ".exr") << entry.path();
    EXPECT_EQ(Channel(entry.path(), "R").cols, 480);
    ++whole;
  }
  EXPECT_GT(whole, 0);

  // No room from the start: not the codecs' fault.
  const auto none = RunUlf("render " + (scratch / "lf").string() +
                           " --field linear --proxy plane --frames 3 -o " + (scratch / "none.mp4").string());
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, AllOf(HasSubstr("there is no room for a video"), Not(HasSubstr("H.264"))));
  EXPECT_FALSE(fs::exists(scratch / "none.mp4"));

  fs::remove_all(scratch / "out");
  const cv::Mat picture(120, 160, CV_8UC3, cv::Scalar(30, 90, 150));
  auto video = OpenPictureSink(scratch / "v.mp4", 30);
  for (int i = 0; i < 5; ++i) video->Add(picture);
  std::ofstream(scratch / "filler") << std::string(FreeBytes(scratch.path()) - (900 << 10), 'x');
  EXPECT_THAT([&] { video->Add(picture); },
              testing::ThrowsMessage<DiskFullError>(HasSubstr("after 5 pictures")));
  VideoReader written(scratch / "v.mp4");
  int frames = 0;
  while (written.Next()) ++frames;
  EXPECT_EQ(frames, 5);
}

}  // namespace
}  // namespace ulf::picture_files_test
