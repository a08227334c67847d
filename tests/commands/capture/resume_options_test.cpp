// Tests: commands/capture/resume_options.
//
// No option of a capture is passed over when one goes on with a light field.
#include "commands/capture/resume_options.h"
#include "commands/options/command_line.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>

#include "commands/options/subcommands.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::commands::resume_options_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::set<std::string> OptionsOfCapture() {
  CLI::App app;
  ChosenCommand chosen;
  AddCommands(app, chosen);
  std::set<std::string> names;
  for (const CLI::Option* option : app.get_subcommand("capture")->get_options())
    names.insert(option->get_single_name());
  return names;
}

TEST(ResumeOptions, EveryOptionOfACaptureHasOneRule) {
  std::set<std::string> ruled;
  for (const ResumeRule& rule : ResumeRules()) {
    EXPECT_TRUE(ruled.insert(std::string(rule.option)).second) << rule.option << " has two";
    const bool may_be_refused = rule.what == OnResume::kMustAgree || rule.what == OnResume::kCannotBeHonoured;
    EXPECT_EQ(rule.refusal != nullptr, may_be_refused) << rule.option;
  }
  EXPECT_EQ(ruled, OptionsOfCapture())
      << "say in commands/capture/resume_options.cpp what a resume does with the option";
}

TEST(ResumeOptions, ThoseOnTheCommandLineAreFound) {
  CLI::App app;
  ChosenCommand chosen;
  AddCommands(app, chosen);
  app.parse("capture sim:studio -o lf --resume --quality fast");
  EXPECT_EQ(GivenOptions(*app.get_subcommand("capture")),
            (std::set<std::string>{"URI", "output", "resume", "quality"}));
}

// A light field of one view, which was begun with 7 px.
class Resumed : public ::testing::Test {
 protected:
  void Begin(bool with_subject = true, const std::string& units = "arbitrary", int views = 1,
             const std::string& board = "") {
    fs::remove_all(dir());
    CaptureHeader header;
    header.camera = CameraModel::Pinhole(64, 48, 50);
    header.threshold_px = 7;
    header.units = units;
    LightFieldWriter writer = LightFieldWriter::Create(dir(), header);
    if (with_subject) writer.SetSubject({{1, 2, 3}, 0.5});
    if (!board.empty()) writer.SetTurntable({board});
    Frame frame;
    frame.image.pixels = cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, 30));
    for (int i = 0; i < views; ++i) writer.AddView(frame, {});
  }
  fs::path dir() const { return scratch_ / "lf"; }
  CaptureArgs Args() const {
    CaptureArgs args;
    args.dir = dir().string();
    args.resume = true;
    args.headless = true;
    return args;
  }
  void Refused(const CaptureArgs& args, const std::string& option, const std::vector<std::string>& words) {
    for (const std::string& word : words)
      EXPECT_THAT([&] { RequireResumable(args, {option}); },
                  ThrowsMessage<Refusal>(AllOf(HasSubstr(": --" + option), HasSubstr(word))));
    EXPECT_NO_THROW(RequireResumable(args, {})) << "not given: " << option;
    ++refused_;
  }
  static void TearDownTestSuite() {
    test::PrintFaultRow("a capture resumed with an option that it cannot honour", refused_,
                        "nothing; each is refused by name, with both values", std::nullopt);
  }
  static inline int refused_ = 0;
  const test::ScratchFolder scratch_;
};

TEST_F(Resumed, RefusalNamesBothValues) {
  Begin();
  CaptureArgs args = Args();
  args.quality = "fast";
  Refused(args, "quality", {"fast (12 px)", "7 px", "leave it out"});
  args.quality = "high";
  EXPECT_NO_THROW(RequireResumable(args, {"quality"}));
  args.threshold_px = 9.5;
  Refused(args, "threshold-px", {"9.5", "7 px", "leave it out"});
  args.threshold_px = 7;
  EXPECT_NO_THROW(RequireResumable(args, {"threshold-px"}));
  args.coverage_width_px = 320;
  Refused(args, "coverage-width", {"320", "640", "leave it out"});
  args.no_subject = true;
  Refused(args, "no-subject", {"1,2,3,0.5", "leave it out"});
}

TEST_F(Resumed, AWorldMustAgree) {
  const std::string board = "charuco:5x5:54:40:DICT_4X4_50";
  Begin();
  CaptureArgs args = Args();
  args.poses = tracking::PosesSpec::Parse(args.poses_text = "markers:" + board);
  Refused(args, "poses", {board, "metres", "leave it out"});
  Begin(true, "metres");
  EXPECT_NO_THROW(RequireResumable(args, {"poses"}));
  args.poses = tracking::PosesSpec::Parse(args.poses_text = "markers:marker:80:DICT_4X4_50");
  Refused(args, "poses", {"NUMBER"});

  args.turntable = board;
  args.poses = tracking::PosesSpec::Parse("markers:" + board);
  Refused(args, "turntable", {board, "stood still in its 1 view", "leave it out"});
  Begin(true, "metres", 1, "charuco:7x5:30:22:DICT_5X5_100");
  Refused(args, "turntable", {board, "charuco:7x5:30:22:DICT_5X5_100"});
  Begin(true, "metres", 1, args.poses.markers().board.Text());
  EXPECT_NO_THROW(RequireResumable(args, {"turntable"}));
}

TEST_F(Resumed, RefusesWhatItCannotHonour) {
  Begin();
  CaptureArgs args = Args();
  Refused(args, "subject", {"auto", "1,2,3,0.5", "leave it out"});
  args.subject = "0,0,0,1";
  EXPECT_NO_THROW(RequireResumable(args, {"subject"})) << "another place";
  Refused(args, "subject-size", {"0.28", "1,2,3,0.5"});
  args.headless = false;
  EXPECT_NO_THROW(RequireResumable(args, {"subject-size"})) << "the display places it anew";
  args.intrinsics.force = true;
  Refused(args, "force-calibration", {"leave it out"});
  args.intrinsics.calibration_path = "lens.json";
  EXPECT_NO_THROW(RequireResumable(args, {"force-calibration"}));
  args.lens = tracking::LensUse::kCheck;
  EXPECT_NO_THROW(RequireResumable(args, {"intrinsics"}));
  args.lens = tracking::LensUse::kRefine;
  Refused(args, "intrinsics", {"refine", "1 view", "ulf refine"});
  Refused(args, "calibration-out", {"has 1", "leave it out"});
  Begin(false, "arbitrary", 0);
  EXPECT_NO_THROW(RequireResumable(args, {"intrinsics", "calibration-out", "subject", "subject-size"}))
      << "there is nothing yet that speaks against them";
}

TEST_F(Resumed, NeverRefusesUsedOptions) {
  Begin();
  std::set<std::string> used;
  for (const ResumeRule& rule : ResumeRules())
    if (!rule.refusal) used.insert(std::string(rule.option));
  EXPECT_GT(used.size(), 20u);
  EXPECT_NO_THROW(RequireResumable(Args(), used));
  CaptureArgs begun = Args();
  begun.resume = false;
  begun.quality = "fast";
  EXPECT_NO_THROW(RequireResumable(begun, {"quality"})) << "no resume";
}

}  // namespace
}  // namespace ulf::commands::resume_options_test
