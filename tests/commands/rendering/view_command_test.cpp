// Tests: commands/rendering/view_command.
//
// `ulf view` itself: a picture without a display, a window with somebody before it, and what it says where
// there is none.
#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/support/x11_person.h"

namespace ulf::test::view_command_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class ViewCommand : public ::testing::Test {
 protected:
  void SetUp() override { WriteLightField(dir_, {.viewpoints = GridViewpoints(5, 4, 0.2, 2.0)}, true); }
  ScratchFolder scratch_;
  std::filesystem::path dir_ = scratch_ / "lf";
};

TEST_F(ViewCommand, TakesAPictureWithoutADisplay) {
  const std::string view = "view " + dir_.string() + " --width 320 --height 240 ";
  const auto plain = RunUlf(view + "--screenshot " + (scratch_ / "a.png").string() + " --json");
  ASSERT_EQ(plain.exit_code, 0) << plain.errors;
  const auto report = JsonFromText(plain.output);
  EXPECT_GE(report["frames"], 1);
  EXPECT_EQ(report["field"], "subdivision");
  EXPECT_EQ(report["proxy"], "plane");
  EXPECT_GT(report["first_picture_s"], 0);
  EXPECT_GE(report["complete_picture_s"], report["first_picture_s"]);
  const auto switched =
      RunUlf(view + "--field linear --keys b,m,t --screenshot " + (scratch_ / "b.png").string() + " --json");
  ASSERT_EQ(switched.exit_code, 0) << switched.errors;
  EXPECT_GE(JsonFromText(switched.output)["frames"], 4);
  const cv::Mat a = cv::imread(scratch_ / "a.png"), b = cv::imread(scratch_ / "b.png");
  ASSERT_EQ(a.size(), cv::Size(320, 240));
  ASSERT_EQ(b.size(), a.size());
  EXPECT_GT(cv::norm(a, b, cv::NORM_L1) / static_cast<double>(3 * a.total()), 10);

  EXPECT_EQ(RunUlf(view + "--keys b").exit_code, 2) << "only for a picture";
  const auto unknown = RunUlf(view + "--keys b,Elsewhere --screenshot " + (scratch_ / "c.png").string());
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("'Elsewhere'"));
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "c.png"));
}

TEST_F(ViewCommand, BeginsWithTheBestThatIsQuickEnough) {
  const std::string view = "view " + dir_.string() + " --width 160 --height 120 --screenshot " +
                           (scratch_ / "a.png").string() + " --json --explain ";
  const auto report = [&](const std::string& options) {
    const auto result = RunUlf(view + options);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return JsonFromText(result.output);
  };
  for (const bool in_time : {true, false}) {
    const auto begun = report(in_time ? "--frame-ms 100000" : "--frame-ms 0.001");
    const auto& explained = begun["explain"];
    ASSERT_FALSE(explained.empty()) << in_time;  // the fitted plane may be the plane itself
    for (const auto& question : explained) {
      EXPECT_THAT(
          question["criterion"].get<std::string>(),
          AllOf(StartsWith(in_time ? "of those that take at most 100000 ms" : "none takes at most 0.001 ms"),
                HasSubstr("for a picture of 160x120")));
      std::vector<std::string> chosen;
      double chosen_s = 0, least_s = 1e9;
      for (const auto& candidate : question["candidates"]) {
        double psnr_db = 0, seconds = 0;
        const auto evidence = candidate["evidence"].get<std::string>();
        ASSERT_EQ(std::sscanf(evidence.c_str(), "%lf dB, %lf s", &psnr_db, &seconds), 2) << evidence;
        least_s = std::min(least_s, seconds);
        if (!candidate["chosen"]) continue;
        chosen.push_back(candidate["model"]);
        chosen_s = seconds;
      }
      ASSERT_EQ(chosen.size(), 1u) << question;
      EXPECT_THAT(chosen[0],
                  StartsWith(begun[question["question"] == "proxy" ? "proxy" : "field"].get<std::string>()));
      EXPECT_TRUE(in_time || chosen_s == least_s) << question;
    }
  }
  EXPECT_EQ(RunUlf("view " + dir_.string() + " --explain").exit_code, 2) << "nothing is compared";
  for (const char* refused : {"0", "-1", "nan"}) {
    const auto result = RunUlf(view + "--frame-ms " + refused);
    EXPECT_EQ(result.exit_code, 2) << refused;
    EXPECT_THAT(result.errors, AllOf(HasSubstr("--frame-ms"), HasSubstr("not a number above 0"))) << refused;
  }
}

TEST_F(ViewCommand, OffersItsFirstChoiceOnce) {
  TriangleMesh plane = *PlaneAndSquare();
  plane.triangles.resize(2);
  const std::string mesh = (scratch_ / "other.ply").string();
  WriteMeshPly(mesh, plane);
  const auto next = RunUlf("view " + dir_.string() + " --width 160 --height 120 --frame-ms 100000 --proxy " +
                           mesh + " --keys p --json --screenshot " + (scratch_ / "a.png").string());
  ASSERT_EQ(next.exit_code, 0) << next.errors;
  EXPECT_EQ(JsonFromText(next.output)["proxy"], "plane");
}

TEST_F(ViewCommand, ComparesInEvenLight) {
  TriangleMesh plane = *PlaneAndSquare();
  plane.triangles.resize(2);
  WriteMeshPly(dir_ / "proxy.ply", plane);
  const auto questions = [&](const std::string& options) {
    const auto result =
        RunUlf("view " + dir_.string() + " --width 160 --height 120 --frame-ms 100000 --explain --json " +
               options + " --screenshot " + (scratch_ / "a.png").string());
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    std::vector<std::string> asked;
    const auto report = JsonFromText(result.output);
    for (const auto& choice : report["explain"]) asked.push_back(choice["question"]);
    return asked;
  };
  EXPECT_THAT(questions("--light as-recorded"), ElementsAre("proxy", "blending field"));
  // These exposures are not known.
  EXPECT_THAT(questions(""), ElementsAre("proxy", "blending field", HasSubstr("light")));
}

TEST_F(ViewCommand, TheLensIsThatOfTheCommandLine) {
  const std::string view = "view " + dir_.string() + " --width 320 --height 240 --keys t,w --screenshot ";
  const auto picture = [&](const std::string& name, const std::string& options) {
    const auto result = RunUlf(view + (scratch_ / name).string() + " " + options);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return cv::imread(scratch_ / name);
  };
  const auto apart = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(3 * a.total());
  };
  const cv::Mat closed = picture("closed.png", "--gpu-memory 8");
  const cv::Mat near = picture("near.png", "--aperture 0.5 --focus 1.4");
  const cv::Mat at = picture("at.png", "--aperture 0.5 --focus-at 100,50");
  EXPECT_GT(apart(near, closed), 2 * apart(at, closed));
  const auto unopened = RunUlf(view + (scratch_ / "c.png").string() + " --focus 1");
  EXPECT_EQ(unopened.exit_code, 2);
  EXPECT_THAT(unopened.errors, HasSubstr("--aperture"));
}

TEST_F(ViewCommand, OpensWhateverViewpointsThereAre) {
  struct Case {
    std::string name;
    std::vector<Eigen::Vector3d> viewpoints;
  };
  for (const Case& c : {Case{"one", {{0, 0, 2}}}, Case{"a ring", RingViewpoints(12, 0.2, 2.0)},
                        Case{"one place", {{0, 0, 2}, {0, 0, 2}, {0, 0, 2}}}}) {
    const auto dir = scratch_ / c.name.substr(0, 5);
    WriteLightField(dir, {.viewpoints = c.viewpoints}, true);
    const auto result =
        RunUlf("view '" + dir.string() + "' --width 160 --height 120 --keys o,b,m,c,n,k,2 -o " +
               scratch_.path().string() + " --screenshot " + (scratch_ / "a.png").string());
    EXPECT_EQ(result.exit_code, 0) << c.name << ": " << result.errors;
    EXPECT_EQ(cv::imread(scratch_ / "a.png").size(), cv::Size(160, 120)) << c.name;
    std::filesystem::remove(scratch_ / "a.png");
  }
}

TEST_F(ViewCommand, SaysWhatIsWrong) {
  const auto says = [&](const std::string& arguments, int exit_code, const std::string& what) {
    const auto result = RunUlf("view " + arguments + " --screenshot " + (scratch_ / "c.png").string());
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_THAT(result.errors, HasSubstr(what)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "c.png")) << arguments;
  };
  says((scratch_ / "nothing").string(), 1, "nothing");
  says(dir_.string() + " --field strange", 2, "strange");
  says(dir_.string() + " --level 7", 2, "7");
  says(dir_.string() + " --proxy " + (scratch_ / "none.ply").string(), 1, "none.ply");
  says(dir_.string() + " --proxy mesh", 1, "ulf proxy");
  says(dir_.string() + " --width 3", 2, "--width");
}

TEST_F(ViewCommand, WithoutADisplayItSaysWhatToDo) {
  ChildProcess view({"/bin/bash", "-c",
                     fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} view {} 2>&1",
                                 std::getenv("ULF_BINARY"), dir_.string())});
  EXPECT_THAT(view.ReadUntil("--screenshot", 30), HasSubstr("--screenshot FILE.png"));
  EXPECT_EQ(view.Wait(30), 1);

  ChildProcess missing({"/bin/bash", "-c",
                        fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} view {} 2>&1",
                                    std::getenv("ULF_BINARY"), (scratch_ / "missing").string())});
  EXPECT_THAT(missing.ReadUntil("folder", 30), HasSubstr("no such folder")) << "before it asks for a display";
  EXPECT_EQ(missing.Wait(30), 1);
}

TEST_F(ViewCommand, WithoutOpenGlItSaysWhatDoesWithoutIt) {
  const WithoutOpenGl here;
  const auto picture = RunUlf("view " + dir_.string() + " --screenshot " + (scratch_ / "a.png").string());
  ChildProcess window({"/bin/bash", "-c",
                       fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} view {} 2>&1",
                                   std::getenv("ULF_BINARY"), dir_.string())});
  const std::string says = window.ReadUntil("reference", 30);
  EXPECT_EQ(window.Wait(30), 1);
  EXPECT_EQ(picture.exit_code, 1);
  for (const std::string& text : {picture.errors, says}) {
    EXPECT_THAT(text, HasSubstr("libegl-mesa0 libgl1-mesa-dri"));
    EXPECT_THAT(text, HasSubstr("ulf render --renderer reference"));
    EXPECT_THAT(text, Not(HasSubstr("--screenshot"))) << "it draws by OpenGL, too";
  }
}

// On a display server of its own, which is killed in the end.
TEST_F(ViewCommand, ClosesByAPersonAndOutlivesTheServer) {
  ChildProcess server({"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24"});
  const std::string display = ":" + std::to_string(std::stoi(server.ReadUntil("\n", 30)));
  const std::string title = "ulf view " + dir_.string();
  const auto start = [&] {
    return ChildProcess({"/bin/bash", "-c",
                         fmt::format("exec env DISPLAY={} {} view {} --width 320 --height 240 --json 2>&1",
                                     display, std::getenv("ULF_BINARY"), dir_.string())});
  };
  {
    ChildProcess view = start();
    X11Person person(title, display);
    person.Press("Left");
    person.Press("q");
    EXPECT_THAT(view.ReadUntil("first_picture_s", 30), HasSubstr("\"frames\":"));
    EXPECT_EQ(view.Wait(30), 0);
  }
  {
    ChildProcess view({"/bin/bash", "-c",
                       fmt::format("exec env DISPLAY={} {} view {} --frame-ms 50 --json 2>&1", display,
                                   std::getenv("ULF_BINARY"), dir_.string())});
    X11Person person(title, display);
    person.CloseWindow();
    EXPECT_THAT(view.ReadUntil("compared", 30), Not(HasSubstr("\"frames\":"))) << "closed before";
    EXPECT_EQ(view.Wait(30), 0);
  }
  ChildProcess view = start();
  { const X11Person person(title, display); }
  server.Kill();
  EXPECT_THAT(view.ReadUntil("its window", 30), HasSubstr("the display server has ended"));
  EXPECT_EQ(view.Wait(30), 1);
}

}  // namespace
}  // namespace ulf::test::view_command_test
