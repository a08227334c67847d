// Tests: main, commands/commands, commands/about/wrong_usage, commands/light_field/info_command,
// commands/reports/light_field_report, commands/capture/capture_command, commands/capture/plan_command,
// coverage/session/record/map_cache, commands/options/subcommands, coverage/bound/capture_presets,
// commands/light_field/repair_command.
//
// The commands as a person or a script meets them.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/points/point_tracks.h"
#include "tests/support/test_paths.h"

namespace ulf::test::commands_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// Where the studio's subject is; small pictures, because they are drawn on the processor.
const std::string kStudio = "'sim:studio?width=160&height=120&look_away=0&row_deg=5&speed_deg_s=20'";
const std::string kLargeStudio = "'sim:studio?width=320&height=240&look_away=0&row_deg=5&speed_deg_s=20'";
const std::string kSubject = " --poses known --subject 0,0,0.07,0.162";

nlohmann::json JsonOf(const CommandResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << "one object, one line";
  return JsonFromText(result.output);
}

TEST(PlanCommand, PrintsWhatTheDerivationSays) {
  const auto json = JsonOf(RunUlf(
      "plan --focal-px 600 --width 640 --distance 2 --radius 0.6 --angle-deg 1 --distance-ratio 1 --json"));
  EXPECT_NEAR(json["disc_radius_deg"], 0.72, 0.006);
  EXPECT_NEAR(json["distance_window"][0], 0.933, 1e-3);
  EXPECT_NEAR(json["distance_window"][1], 1.104, 1e-3);
  EXPECT_NEAR(json["bound_px"], 8.904, 1e-3);
  EXPECT_GT(json["views_estimate"],
            2440);  // 0.98 x 0.716 sr / (sqrt(3) x 0.724 degrees squared), and the rim
  EXPECT_LT(json["views_estimate"], 2640);
  EXPECT_LT(json["views_spread"][0], json["views_estimate"]);
  EXPECT_GT(json["views_spread"][1], json["views_estimate"]);
}

TEST(PlanCommand, NoLimitIsNull) {
  const auto json = JsonOf(RunUlf("plan --focal-px 600 --width 640 --distance 1 --radius 0.1 --json"));
  EXPECT_NEAR(json["distance_window"][0], 0.687, 1e-3);
  EXPECT_TRUE(json["distance_window"][1].is_null());
  EXPECT_FALSE(json.contains("bound_px"));
}

TEST(PlanCommand, CoverageWidthScalesTheFocalLength) {
  const auto native = JsonOf(RunUlf("plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --json"));
  const auto large = JsonOf(RunUlf("plan --focal-px 3000 --width 3200 --distance 1 --radius 0.2 --json"));
  EXPECT_DOUBLE_EQ(native["disc_radius_deg"], large["disc_radius_deg"]);
}

TEST(PlanCommand, QualityIsAThreshold) {
  const std::string plan = "plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --json";
  EXPECT_EQ(JsonOf(RunUlf(plan + " --quality fast")), JsonOf(RunUlf(plan + " --threshold-px 12")));
  EXPECT_EQ(JsonOf(RunUlf(plan + " --quality high")), JsonOf(RunUlf(plan)));
}

TEST(PlanCommand, AShareOfTheCapTakesFewerViews) {
  const std::string plan = "plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --json --cap 60x40";
  EXPECT_NEAR(JsonOf(RunUlf(plan + ":49%"))["views_estimate"],
              0.5 * JsonOf(RunUlf(plan))["views_estimate"].get<double>(), 1e-6);
}

// 66 views in half a minute to two and a half: what simulated people take stands in docs/capture.md#guidance.
TEST(PlanCommand, TellsDistancesAndMinutesInWords) {
  const std::string plan = "plan --distance 1 --radius 0.15 --cap 40x30 --quality fast";
  const CommandResult given = RunUlf(plan + " --focal-px 560 --width 640");
  ASSERT_EQ(given.exit_code, 0) << given.errors;
  EXPECT_THAT(given.output,
              ContainsRegex("distances        keep at least 0\\.[0-9]+ of the first distance; farther "
                            "is fine\n"));
  EXPECT_THAT(given.output,
              ContainsRegex("time             about 0\\.[0-9] min \\(0\\.[0-9] to [01]\\.[0-9] min"));
  EXPECT_THAT(given.output, HasSubstr("at 15 frames a second"));
  const auto json = JsonOf(RunUlf(plan + " --focal-px 560 --width 640 --json"));
  EXPECT_LT(json["minutes_spread"][0], json["minutes_estimate"]);
  EXPECT_GT(json["minutes_spread"][1], json["minutes_estimate"]);
  EXPECT_TRUE(json["camera"].is_null());
}

TEST(PlanCommand, TakesTheLensOfACameraOrCalibration) {
  const std::string plan = "plan --distance 1 --radius 0.15 --cap 40x30 --quality fast --json ";
  const auto given = JsonOf(RunUlf(plan + "--focal-px 560 --width 640"));
  const auto of_camera = JsonOf(RunUlf(plan + "sim:studio"));
  EXPECT_NEAR(of_camera["camera"]["focal_px"], 560, 1);
  EXPECT_EQ(of_camera["camera"]["width_px"], 640);
  EXPECT_NEAR(of_camera["views_estimate"], given["views_estimate"], 1);
  ScratchFolder scratch;
  const std::string file = (scratch / "cameras.txt").string();
  std::ofstream(file) << "1 PINHOLE 1280 960 1120 1120 640 480\n";
  const auto of_file = JsonOf(RunUlf(plan + "--calibration " + file));
  EXPECT_EQ(of_file["camera"]["focal_px"], 1120);
  EXPECT_DOUBLE_EQ(of_file["disc_radius_deg"], given["disc_radius_deg"]);
  for (const std::string wrong : {"", "sim:studio --focal-px 560", "--focal-px 560"}) {
    const CommandResult result = RunUlf(plan + wrong);
    EXPECT_EQ(result.exit_code, 2) << wrong;
    EXPECT_THAT(result.errors, HasSubstr("--focal-px")) << wrong;
  }
}

TEST(PlanCommand, ReportsMoreViewsThanAnybodyTakes) {
  const std::string plan = "plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --threshold-px ";
  const CommandResult usual = RunUlf(plan + "7"), fine = RunUlf(plan + "2.0001");
  EXPECT_EQ(usual.errors, "");
  EXPECT_EQ(fine.exit_code, 0);
  EXPECT_THAT(fine.errors, AllOf(HasSubstr("more than a person can take"), HasSubstr("larger threshold")));
}

TEST(Commands, AnOptionThatIsGivenTwiceIsNamed) {
  const CommandResult result =
      RunUlf("plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --cap 1x1 --cap 2x2");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.errors, "ulf: --cap is given more than once; give it once\n");
}

TEST(Commands, DoNotReplaceTheirInput) {
  const ScratchFolder folder;
  const std::string camera = (folder / "camera.json").string(), truth = (folder / "truth.txt").string(),
                    light_field = (folder / "vase").string(), journal = light_field + "/journal.jsonl";
  fs::create_directories(light_field);
  for (const std::string& file : {camera, truth, journal}) std::ofstream(file) << "kept";
  for (const std::string& line :
       {"track replay:" + light_field + " --poses known --truth " + truth + " -o " + truth,
        "track 'replay:" + light_field + "?fps=5' --calibration " + camera + " --final " + camera,
        "track replay:" + light_field + " -o " + journal, "render " + light_field + " -o " + journal,
        "capture 'replay:" + light_field + "' -o " + light_field + "2 --map " + journal}) {
    const CommandResult result = RunUlf(line);
    EXPECT_EQ(result.exit_code, 2) << line;
    EXPECT_THAT(result.errors, AllOf(HasSubstr("reads and would be replaced"), HasSubstr("another name")))
        << line;
  }
  for (const std::string& file : {camera, truth, journal}) EXPECT_EQ(ReadWholeFile(file), "kept") << file;
}

TEST(Commands, SuggestTheOptionThatIsMeant) {
  const std::pair<const char*, const char*> cases[] = {
      {"inof x", "ulf: there is no command 'ulf inof'; do you mean 'info'?; 'ulf --help' lists them\n"},
      {"export colmp x -o y",
       "ulf: there is no command 'ulf export colmp'; do you mean 'colmap'?; there are "},
      {"export foo x -o y", "ulf: there is no command 'ulf export foo'; there are colmap, "},
      {"export", "ulf: ulf export needs one of: colmap, "},
      {"export colmap x -o y --undistrot",
       "ulf: ulf export colmap has no option '--undistrot'; do you mean '--undistort'?; 'ulf export colmap "
       "--help' "
       "lists them\n"},
      {"plan --focal 35", "ulf: ulf plan has no option '--focal'; do you mean '--focal-px'?; "},
      {"plan --zebra=3", "ulf: ulf plan has no option '--zebra'; 'ulf plan --help' lists them\n"}};
  for (const auto& [arguments, words] : cases) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.errors, StartsWith(words)) << arguments;
  }
  EXPECT_EQ(RunUlf("export --help").exit_code, 0);
  EXPECT_EQ(RunUlf("export colmap --help").errors, "");
}

TEST(PlanCommand, WrongUsageExitsWithTwoAndSaysWhy) {
  const std::string good = "plan --focal-px 600 --width 640 --distance 1 ";
  for (const auto& [arguments, words] : {std::pair<std::string, std::string>{good, "--radius"},
                                         {good + "--radius 2", "outside the subject's sphere"},
                                         {good + "--radius -1", "positive"},
                                         {good + "--radius nan", "positive"},
                                         {good + "--radius 0.5", "stand at 1.27 or farther"},
                                         {good + "--radius 0.2 --quality fast --threshold-px 9", "excludes"},
                                         {good + "--radius 0.2 --threshold-px 2", "2 px"},
                                         {good + "--radius 0.2 --cap 60", "60x40"},
                                         {good + "--radius 0.2 --angle-deg 3", "--distance-ratio"}}) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.errors, HasSubstr(words)) << arguments;
    EXPECT_THAT(result.output, IsEmpty()) << arguments;
  }
}

TEST(CaptureCommand, FailsWithoutAViewAndSaysWhy) {
  const ScratchFolder scratch;
  const CommandResult result = RunUlf("capture --no-geometry " + kStudio + " -o " +
                                      (scratch / "lf").string() + " --headless --frames 3");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.errors, HasSubstr("nothing was recorded"));
  EXPECT_THAT(result.errors, HasSubstr("sideways"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "lf")) << "nothing is left of it";
  const CommandResult again = RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " +
                                     (scratch / "lf").string() + " --headless --frames 3");
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), 1u);
  const CommandResult taken = RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " +
                                     (scratch / "lf").string() + " --headless --frames 3");
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_THAT(taken.errors, HasSubstr("--resume"));
}

TEST(CaptureCommand, RawWithoutAMosaicIsSaid) {
  const ScratchFolder scratch;
  const CommandResult result = RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " +
                                      (scratch / "lf").string() + " --headless --frames 3 --raw");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("not a mosaic"));
}

TEST(CaptureCommand, CapturesALightFieldAndPrintsItsRow) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  const auto json = JsonOf(RunUlf("capture --no-geometry " + kLargeStudio + kSubject + " -o " + dir +
                                  " --headless --quality fast --frames 120 "
                                  "--until-covered 60x40 --overlay " +
                                  (scratch / "overlay.png").string() + " --map " +
                                  (scratch / "map.png").string() + " --json"));
  EXPECT_EQ(json["frames"], 120);
  EXPECT_EQ(json["stopped_because"], "frames");
  EXPECT_EQ(json["views"], json["recorded"]);
  EXPECT_GT(json["views"], 10);
  EXPECT_GT(json["covered"], 0.02);
  EXPECT_LT(json["covered"], 0.9);
  EXPECT_NEAR(json["subject"]["radius"], 0.162, 1e-9);
  EXPECT_GT(json["ms_track_median"], 0);
  EXPECT_EQ(json["device"]["dropped"], 0);
  std::uint64_t sum = 0;
  for (const char* reason : {"recorded", "covered", "outside_rectangle", "behind", "inside_sphere",
                             "tracking", "blur", "exposure", "speed", "spool"}) {
    ASSERT_TRUE(json["reasons"].contains(reason)) << reason;
    sum += json["reasons"][reason].get<std::uint64_t>();
  }
  EXPECT_EQ(sum, 120u);
  for (const char* picture : {"overlay.png", "map.png"})
    EXPECT_GT(ReadImageFile((scratch / picture).string()).cols, 600) << picture;

  const auto info = JsonOf(RunUlf("info " + dir + " --cap 60x40 --json"));
  for (const char* key :
       {"views", "capture_s", "angular_range_deg", "mean_edge_deg", "subject", "covered", "reasons"})
    EXPECT_EQ(info[key], json[key]) << key;
  EXPECT_EQ(JsonOf(RunUlf("info " + dir + " --json"))["covered"], json["covered"])
      << "of the cap that was to be covered";
  EXPECT_THAT(RunUlf("info " + dir).output, HasSubstr("of 60 x 40 degrees within 12 px"));
  EXPECT_EQ(ReadLightField(dir).units, "metres");
  EXPECT_EQ(*ReadLightField(dir).threshold_px, 12);
}

TEST(CaptureCommand, ResumeAddsToWhatIsThere) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  const std::string tail = " -o " + dir + " --headless --json";
  const auto first =
      JsonOf(RunUlf("capture --no-geometry " + kStudio + kSubject + tail + " --quality fast --frames 30"));
  EXPECT_EQ(RunUlf("capture --no-geometry " + kStudio + kSubject + tail + " --frames 30").exit_code, 1)
      << "without --resume";
  const auto second =
      JsonOf(RunUlf("capture --no-geometry " + kStudio + " --poses known" + tail + " --resume --frames 60"));
  EXPECT_EQ(second["views"], first["views"].get<int>() + second["recorded"].get<int>());
  EXPECT_GT(second["recorded"], 0);
  EXPECT_EQ(second["subject"], first["subject"]);
}

TEST(CaptureCommand, ResumedTooBrightSessionFails) {
  const ScratchFolder scratch;
  const std::string tail = " --headless --json -o " + (scratch / "lf").string();
  const auto first = JsonOf(
      RunUlf("capture --no-geometry " + kLargeStudio + kSubject + tail + " --quality fast --frames 30"));
  const std::string bright = kLargeStudio.substr(0, kLargeStudio.size() - 1) + "&exposure_us=60000'";
  const CommandResult second =
      RunUlf("capture --no-geometry " + bright + " --poses known" + tail + " --resume --frames 120");
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.errors, AllOf(HasSubstr("before the first new view: light: too bright"),
                                   HasSubstr("nothing was recorded of 120 frames"),
                                   HasSubstr("'badly exposed'"), Not(HasSubstr("auto focus"))));
  EXPECT_EQ(ReadLightField(scratch / "lf").views.size(), first["views"].get<std::size_t>());
}

TEST(CaptureCommand, ResumeGoesOnToTheSameEnd) {
  const ScratchFolder scratch;
  const std::string capture = "capture --no-geometry " + kStudio +
                              " --poses known --headless --quality fast --json -o " +
                              (scratch / "lf").string();
  JsonOf(RunUlf(capture + " --subject 0,0,0.07,0.162 --frames 5 --until-covered 20x10:80%"));
  const std::string resume = "capture --no-geometry " + kStudio +
                             " --poses known --headless --json --resume -o " + (scratch / "lf").string();
  const CommandResult second = RunUlf(resume + " --frames 1000");
  EXPECT_EQ(JsonOf(second)["stopped_because"], "covered");
  EXPECT_THAT(second.errors, HasSubstr("goes on until 80 % of 20 x 10 degrees"));
  const auto covered_before = JsonOf(RunUlf(resume + " --frames 60"));
  EXPECT_EQ(covered_before["stopped_because"], "covered") << "nothing is left to record";
  EXPECT_EQ(covered_before["recorded"], 0);
  const auto third = JsonOf(RunUlf(resume + " --until-covered none --frames 60"));
  EXPECT_EQ(third["stopped_because"], "frames");
  EXPECT_FALSE(third["covered"].is_null()) << "it was to be covered all the same";
}

TEST(CaptureCommand, ABetterLensIsASecondCamera) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf", lens = scratch / "cameras.txt";
  const std::string resume = "capture --no-geometry " + kStudio +
                             " --poses known --headless --json --resume -o " + dir.string() +
                             " --calibration " + lens.string();
  const auto first = JsonOf(RunUlf("capture --no-geometry " + kStudio + kSubject +
                                   " --headless --quality fast " + "--frames 30 --json -o " + dir.string()));
  const int views = first["views"];
  ASSERT_GE(views, 1);
  const std::string journal = ReadWholeFile(dir / "journal.jsonl");
  const CommandResult missing = RunUlf(resume + " --frames 60");
  EXPECT_EQ(missing.exit_code, 1) << "a file that is named is read";
  EXPECT_THAT(missing.errors, HasSubstr(lens.string()));
  WriteFileAtomically(lens, "1 PINHOLE 160 120 145 145\n");
  EXPECT_EQ(RunUlf(resume + " --frames 60").exit_code, 1) << "and must be whole";
  EXPECT_EQ(ReadWholeFile(dir / "journal.jsonl"), journal);

  WriteFileAtomically(lens, "1 PINHOLE 160 120 145 145 80 60\n");
  const CommandResult second = RunUlf(resume + " --frames 60");
  EXPECT_THAT(second.errors, ContainsRegex("the views from " + std::to_string(views + 1) +
                                           " on have a second camera: f 145.0 px instead of 14[0-9.]+ "));
  EXPECT_THAT(second.errors, HasSubstr("may miss that this one is wrong; 'ulf refine"));
  EXPECT_GT(JsonOf(second)["recorded"], 0);
  const LightField light_field = ReadLightField(dir);
  EXPECT_THAT(light_field.doubts, IsEmpty());
  ASSERT_EQ(light_field.cameras.size(), 2u);
  EXPECT_EQ(light_field.cameras[1].fx, 145);
  for (const View& view : light_field.views) EXPECT_EQ(view.camera, view.id > views ? 1 : 0) << view.id;
  EXPECT_EQ(RunUlf("repair " + dir.string()).output.find("differs"), std::string::npos);

  const CommandResult again = RunUlf(resume + " --frames 5");
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(again.errors.find("camera: f"), std::string::npos) << again.errors;
  EXPECT_EQ(ReadLightField(dir).cameras.size(), 2u) << "it is the one in use";
  const CommandResult focal =
      RunUlf("capture --no-geometry " + kStudio + " --poses known --headless --resume " +
             "--frames 5 --focal-px 150 -o " + dir.string());
  EXPECT_EQ(focal.exit_code, 2);
  EXPECT_THAT(focal.errors, HasSubstr("--focal-px 150"));

  const std::string colmap = (scratch / "colmap").string();
  EXPECT_EQ(RunUlf("export colmap " + dir.string() + " -o " + colmap).exit_code, 0);
  EXPECT_THAT(ReadWholeFile(fs::path(colmap) / "sparse/0/cameras.txt"),
              HasSubstr("\n2 PINHOLE 160 120 145 "));
}

TEST(CaptureCommand, WithoutADisplayItSaysWhereToMove) {
  const ScratchFolder scratch;
  // Long enough that progress is shown.
  const CommandResult captured =
      RunUlf("capture --no-geometry " + kLargeStudio + kSubject + " -o " + (scratch / "lf").string() +
             " --headless --quality fast --frames 250 --until-covered 60x40");
  EXPECT_THAT(captured.errors, ContainsRegex("covered; .*; next: .*° (right|left|down|up)"));
}

TEST(CaptureCommand, ResumeFindsTheCameraAmongViews) {
  const ScratchFolder scratch;
  const std::string capture =
      "capture --no-geometry 'sim:studio?width=480&height=360&look_away=0&row_deg=5&speed_deg_s=20' -o " +
      (scratch / "lf").string() + " --headless --deterministic --json --quality fast --until-covered 60x40";
  const auto first = JsonOf(RunUlf(capture + " --frames 100"));
  ASSERT_GT(first["views"], 10);
  // The hand begins anew: what it sees first has all been recorded.
  const std::filesystem::path saved_map = scratch / "lf" / "cache" / "map.ulf";
  ASSERT_TRUE(std::filesystem::exists(saved_map));
  // However the map came about, all but a few views keep what they show of the points.
  const auto observations = [&](const std::string& folder) {
    const LightField light_field = ReadLightField(scratch / folder);
    const PointStatistics statistics = StatisticsOf(light_field.points);
    EXPECT_LT(statistics.mean_error_px, 0.5);
    EXPECT_GT(statistics.mean_track_length, 4);
    std::map<int, int> by_view;
    for (const ScenePoint& point : light_field.points)
      for (const ViewObservation& seen : point.track) ++by_view[seen.view_id];
    const auto poor = std::count_if(light_field.views.begin(), light_field.views.end(),
                                    [&](const View& view) { return by_view[view.id] < 50; });
    EXPECT_LE(poor, 2) << folder;
    return statistics.observations;
  };
  const std::size_t at_first = observations("lf");
  EXPECT_GT(at_first, 1000u);
  const CommandResult with_map = RunUlf(capture + " --resume --frames 130");
  EXPECT_EQ(with_map.errors.find("made anew"), std::string::npos) << with_map.errors;
  const auto second = JsonOf(with_map);
  const auto counted = [&](const char* reason) {
    return second["reasons"][reason].get<int>() - first["reasons"][reason].get<int>();
  };
  EXPECT_EQ(counted("recorded"), second["recorded"]);
  EXPECT_LT(counted("tracking"), 20) << "the tracker did not find itself on the rebuilt map";
  EXPECT_GT(counted("covered"), 70);
  EXPECT_GT(second["recorded"], 2) << "and it goes on";
  EXPECT_EQ(second["subject"], first["subject"]);
  EXPECT_GT(observations("lf"), at_first) << "those of both sessions";

  // Refined poses are another world than the saved map's.
  std::filesystem::copy(scratch / "lf", scratch / "refined", std::filesystem::copy_options::recursive);
  const auto covered = [&] {
    return JsonOf(RunUlf("info " + (scratch / "refined").string() + " --json"))["covered"];
  };
  const auto before = covered();
  const CommandResult refine = RunUlf("refine " + (scratch / "refined").string() + " --features 500 --json");
  ASSERT_EQ(refine.exit_code, 0) << refine.errors;
  EXPECT_EQ(observations("refined"), JsonFromText(refine.output)["observations"]);
  const auto change = JsonFromText(refine.output)["covered"];
  EXPECT_GT(change["before"], 0.05);
  EXPECT_EQ(change["before"], before);
  EXPECT_EQ(change["after"], covered());
  EXPECT_NE(change["after"], change["before"]) << "poses moved, and coverage stayed to the last direction";
  std::string refined = capture + " --resume --frames 15";
  refined.replace(refined.find("/lf "), 4, "/refined ");
  const CommandResult stale = RunUlf(refined);
  EXPECT_EQ(stale.exit_code, 0) << stale.errors;
  EXPECT_THAT(stale.errors,
              HasSubstr("views, poses or --tracking-side have changed since: the map is made again"));

  // The map is a cache: torn or missing, it is made anew.
  std::filesystem::resize_file(saved_map, std::filesystem::file_size(saved_map) / 2);
  const CommandResult torn = RunUlf(capture + " --resume --frames 15");
  EXPECT_THAT(torn.errors, HasSubstr("the kept map is damaged: the map is made again"));
  const auto third = JsonOf(torn);
  EXPECT_LT(third["reasons"]["tracking"].get<int>() - second["reasons"]["tracking"].get<int>(), 10);
  std::filesystem::remove(saved_map);
  const auto points = [&] { return StatisticsOf(ReadLightField(scratch / "lf").points).points; };
  const std::size_t points_before = points();
  const CommandResult without = RunUlf(capture + " --resume --frames 15");
  EXPECT_LT(JsonOf(without)["reasons"]["tracking"].get<int>() - third["reasons"]["tracking"].get<int>(), 10);
  EXPECT_THAT(without.errors, HasSubstr("the last session left no map: the map is made again"));
  EXPECT_TRUE(std::filesystem::exists(saved_map));
  EXPECT_GT(observations("lf"), at_first) << "without the map's memory, too";
  EXPECT_GE(points(), points_before) << "points that no recorded view shows are kept, too";
}

TEST(RepairCommand, HasNothingToDoAfterATrackedCapture) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  JsonOf(RunUlf("capture --no-geometry 'sim:studio?row_deg=6&width=320&height=240' -o " + dir +
                " --headless --deterministic --quality fast --frames 80 --json"));
  ASSERT_GT(StatisticsOf(ReadLightField(dir).points).tracked, 100u);
  EXPECT_THAT(RunUlf("repair " + dir).output, HasSubstr("nothing to repair"));
}

// A set by another program was never captured: there is nothing to count.
TEST(InfoCommand, CountsNoSessionOfASetByAnotherProgram) {
  const ScratchFolder scratch;
  const std::string first = (scratch / "first").string();
  JsonOf(RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " + first +
                " --headless --quality fast --frames 30 --json"));
  auto document = JsonFromText(ReadWholeFile(scratch / "first/transforms.json"));
  document.erase("ulf");
  std::filesystem::remove(scratch / "first/journal.jsonl");
  std::ofstream(scratch / "first/transforms.json") << JsonText(document);
  const CommandResult info = RunUlf("info " + first);
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  EXPECT_THAT(info.output, testing::Not(HasSubstr("not counted")));
}

TEST(CaptureCommand, ReplayKnowsPosesAndSubject) {
  const ScratchFolder scratch;
  const std::string first = (scratch / "first").string(), again = (scratch / "again").string();
  const auto json = JsonOf(RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " + first +
                                  " --headless --quality fast --frames 60 --json"));
  const auto replayed = JsonOf(RunUlf("capture --no-geometry replay:" + first + " --poses known -o " + again +
                                      " --headless --quality fast --json"));
  EXPECT_EQ(replayed["views"], json["views"]) << "what was recorded is not covered by what came before";
  EXPECT_EQ(replayed["subject"], json["subject"]);
}

TEST(CaptureCommand, WrongUsageExitsWithTwoAndSaysWhy) {
  const ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string();
  for (const auto& [arguments, words] : {
           std::pair<std::string, std::string>{"capture --no-geometry " + kStudio, "--output"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --subject 0,0,0,1", "--subject"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --poses known", "--subject"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --poses known --subject 1,2,3", "1,2,3"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --poses known --subject 1,2,3,0",
            "must be positive"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --quality fast --threshold-px 9", "twice"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --threshold-px 2", "2 px"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --quality best", "best"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --until-covered 60", "60x40"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --until-covered 60x40:98", "share"},
           {"capture --no-geometry " + kStudio + " -o " + dir + " --subject-size 0.9", "0.8"},
           {"capture --no-geometry nonsense -o " + dir, "nonsense"},
       }) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments << "\n" << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(words)) << arguments;
    EXPECT_FALSE(fs::exists(dir)) << arguments;
  }
}

TEST(CaptureCommand, AFolderThatIsTakenIsAnError) {
  const ScratchFolder scratch;
  std::ofstream(scratch / "mine.txt") << "keep me";
  const CommandResult result = RunUlf("capture --no-geometry " + kStudio + kSubject + " -o " +
                                      scratch.path().string() + " --headless --frames 3");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("not empty"));
}

// Starts a capture, sends a signal after it has recorded something, and waits.
int ExitAfterSignal(const fs::path& dir, int signal) {
  const std::string command = std::string("exec ") + std::getenv("ULF_BINARY") + " capture " + kStudio +
                              kSubject + " -o " + dir.string() + " --headless --json > " + dir.string() +
                              ".json 2> /dev/null";
  const pid_t child = fork();
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  for (int i = 0; i < 400 && !fs::exists(dir / "images" / "000003.png"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(CaptureCommand, SignalsCloseItAndExitZero) {
  ASSERT_TRUE(std::getenv("ULF_BINARY")) << "run through ctest";
  for (const int signal : {SIGINT, SIGTERM}) {
    const ScratchFolder scratch;
    EXPECT_EQ(ExitAfterSignal(scratch / "lf", signal), 0) << signal;
    const LightField light_field = ReadLightField(scratch / "lf");
    EXPECT_GE(light_field.views.size(), 3u);
    EXPECT_TRUE(fs::exists(scratch / "lf" / "sparse" / "0" / "images.txt"));
    std::ifstream file(scratch / "lf.json");
    const auto json = JsonFromText(file);
    EXPECT_EQ(json["stopped_because"], "signal");
    EXPECT_EQ(json["views"], light_field.views.size());
    for (const View& view : light_field.views) EXPECT_EQ(ReadViewImage(light_field, view).width(), 160);
  }
}

TEST(InfoCommand, MissingThingsAreErrorsThatNameThem) {
  const ScratchFolder scratch;
  const CommandResult nothing = RunUlf("info " + (scratch / "none").string());
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.errors, HasSubstr("none"));
  const CommandResult empty = RunUlf("info " + scratch.path().string());
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.errors, HasSubstr("no light field"));
  EXPECT_EQ(RunUlf("info " + scratch.path().string() + " --cap 1x").exit_code, 2);
}

TEST(InfoCommand, DescribesARealCaptureInARow) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  const auto json = JsonOf(RunUlf("info " + fox.string() + " --cap 60x40 --json"));
  EXPECT_EQ(json["views"], 50);
  EXPECT_GT(json["angular_range_deg"][0], 30);
  EXPECT_GT(json["covered"], 0);
  EXPECT_LT(json["covered"], 1);
}

}  // namespace
}  // namespace ulf::test::commands_test
