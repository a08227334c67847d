// Tests: commands/tracking/track_command, commands/capture/capture_command,
// commands/options/tracking_options, commands/tracking/track_report.
// ulf track as a process: told to stop, it writes what it has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "acquisition/calibration/calibration_io.h"
#include "commands/tracking/track_report.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/track.h"

namespace ulf::track_command_test {
namespace {

TEST(TrackCommand, SigintWritesThePosesSoFar) {
  test::ScratchFolder scratch;
  const std::string poses = (scratch / "poses.txt").string(), log = (scratch / "log").string();
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(log.c_str(), O_WRONLY | O_CREAT, 0644);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    const char* binary = std::getenv("ULF_BINARY");
    execl(binary, binary, "track", "sim:studio?width=320&height=240&duration_s=600", "-o", poses.c_str(),
          nullptr);
    _exit(127);
  }
  // Progress lines come every two seconds: the second one is well after the start.
  for (int i = 0; i < 600; ++i) {
    usleep(100000);
    const std::string said = std::filesystem::exists(log) ? ReadWholeFile(log) : "";
    if (said.find("frame", said.find("frame") + 1) != std::string::npos) break;
  }
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << ReadWholeFile(log);
  EXPECT_GT(ReadTum(poses).size(), test::kIsSanitized ? 2u : 20u);
  EXPECT_THAT(ReadWholeFile(log), testing::HasSubstr("tracked"));
}

TEST(TrackCommand, OutputsAreCheckedBeforeTheWork) {
  const auto refused = test::RunUlf("track sim:studio --frames 5 -o /nonexistent/poses.txt");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, testing::HasSubstr("does not exist"));
}

TEST(TrackCommand, OnAFullDiskTheReportIsPrinted) {
  const test::ScratchFolder scratch;
  if (const auto problem = test::MountSmallDisk(scratch.path(), 1 << 20)) GTEST_SKIP() << *problem;
  test::FillDisk(scratch / "filler");
  const std::filesystem::path poses = scratch / "poses.txt";
  const auto run =
      test::RunUlf("track 'sim:studio?width=160&height=120' --frames 40 --poses known --deterministic -o " +
                   poses.string());
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.output, testing::HasSubstr("40 frames, 40 tracked"));
  EXPECT_THAT(run.errors, testing::HasSubstr("poses.txt: writing failed: No space left on device"));
  EXPECT_FALSE(std::filesystem::exists(poses)) << "an empty file is none";
  const std::filesystem::path table = scratch / "run.csv";
  const auto listed = test::RunUlf(
      "track 'sim:studio?width=160&height=120' --frames 10 --poses known --deterministic --table " +
      table.string());
  EXPECT_EQ(listed.exit_code, 1);
  EXPECT_THAT(listed.errors, testing::HasSubstr("No space left on device"));
  EXPECT_FALSE(std::filesystem::exists(table));
}

// A map that fails and finds itself within one frame was lost as often as it was found.
TEST(TrackReport, FindingAgainFollowsLosing) {
  TrackRun run;
  for (const bool found : {false, false, true, false}) {
    TrackedFrame frame;
    frame.track.state = TrackState::kTracking;
    frame.track.cam_from_world = Rigid3{};
    frame.track.relocalized = found;
    run.frames.push_back(frame);
  }
  EXPECT_THAT(ToText(run, nullptr), testing::HasSubstr("lost 1 time, found again 1 time"));
}

// Two frames of a map that was given up, three of the one that stays, two that were followed apart and joined
// to it, and one that is apart to the end.
TEST(TrackReport, PosesStandWithTheirWorld) {
  TrackRun run;
  const auto add = [&](std::optional<int> live_map, std::optional<int> final_map) {
    TrackedFrame frame;
    frame.time_s = static_cast<double>(run.frames.size());
    frame.track.state = live_map ? TrackState::kTracking : TrackState::kApart;
    frame.track.map_id = live_map.value_or(final_map.value_or(0));
    if (live_map) frame.track.cam_from_world = Rigid3{};
    if (final_map) frame.final_cam_from_world = Rigid3{};
    frame.final_map = final_map.value_or(0);
    run.frames.push_back(frame);
  };
  for (const auto& [live, final] : std::vector<std::pair<std::optional<int>, std::optional<int>>>{
           {0, 0}, {0, 0}, {1, 1}, {{}, 1}, {{}, 1}, {1, 1}, {1, 1}, {{}, 2}})
    add(live, final);
  const std::vector<GivenPoses> maps = PosesOfMaps(run);
  ASSERT_EQ(maps.size(), 3u);
  EXPECT_EQ(maps[0].live.size(), 2u);
  EXPECT_EQ(maps[1].live.size(), 0u);
  EXPECT_EQ(maps[1].final.size(), 1u);
  EXPECT_EQ(maps[2].live.size(), 3u) << "the last map that gave live poses comes last";
  EXPECT_EQ(maps[2].final.size(), 5u);
  EXPECT_EQ(LastMapPoses(run).final.size(), 5u);
  EXPECT_EQ(LivePoses(run), 5);
  run.map.parts = 2;
  EXPECT_THAT(ToText(run, nullptr),
              testing::HasSubstr(
                  "3 frames followed apart from the rest of the map, without a live pose; 2 of them have"));
  const auto json = ToJson(run, nullptr);
  EXPECT_EQ(json["apart"], 3);
  EXPECT_EQ(json["apart_joined"], 2);
  EXPECT_EQ(json["parts"], 2);
}

// Sixty poses on an arc; what is seen is 2 m away. Some are off, and some of these say so.
TEST(TrackReport, CountsWrongPosesAndThoseThatSaySo) {
  TrackRun run;
  std::vector<TimedPose> truth;
  for (int k = 0; k < 60; ++k) {
    const double angle = 0.02 * k;
    const Eigen::Vector3d at(2 * std::sin(angle), 0.1 * std::sin(3 * angle), -2 * std::cos(angle));
    const Rigid3 pose = LookAt(at, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY());
    truth.push_back({0.1 * k, pose});
    TrackedFrame frame;
    frame.time_s = 0.1 * k;
    frame.seen_distance = k == 50 ? 0 : 2;
    frame.track.state = TrackState::kTracking;
    frame.track.quality = k == 20 || k == 30 ? 0.3 : 0.8;
    frame.track.cam_from_world = frame.final_cam_from_world = pose;
    if (k == 10 || k == 20 || k == 50) frame.track.cam_from_world->translation.x() += 0.1;
    if (k == 30 || k == 40)
      frame.track.cam_from_world =
          Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(Radians(3), Eigen::Vector3d::UnitZ())),
                 Eigen::Vector3d::Zero()} *
          pose;
    run.frames.push_back(frame);
  }
  const TrackErrors errors = CompareWithTruth(run, truth, "the truth");
  EXPECT_EQ(errors.wrong.compared, 59) << "of one nobody knows how far away things were";
  EXPECT_EQ(errors.wrong.wrong, 4);
  EXPECT_EQ(errors.wrong.unsaid, 2);
  EXPECT_THAT(ToText(run, &errors), testing::HasSubstr("4 of 59 poses; 2 of them with a quality"));
  EXPECT_EQ(ToJson(run, &errors)["wrong_live"]["unsaid"], 2);
}

// Frames of files wait for the mapper: it makes a keyframe of every frame that is to be one.
TEST(TrackCommand, FilesDoNotOutrunTheMapper) {
  const test::ScratchFolder scratch;
  const test::TexturedRoom room({});
  const CameraModel camera = test::TexturedRoom::Camera().ScaledTo(320, 240);
  for (int k = 0; k < 90; ++k)
    cv::imwrite(
        (scratch / fmt::format("{:03}.png", k)).string(),
        room.Take(test::TexturedRoom::WalkingAt(3 * k), static_cast<std::uint64_t>(k), camera).image.pixels);
  const auto run =
      test::RunUlf(fmt::format("track replay:{} --focal-px {} --json", scratch.path().string(), camera.fx));
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  EXPECT_GT(report["keyframes"], 8);
  EXPECT_EQ(report["keyframes_left_out"], 0);
}

TEST(TrackCommand, RunsAnySourceOfPoses) {
  const auto known = test::RunUlf(
      "track 'sim:studio?width=160&height=120' --frames 12 --poses known --deterministic --json");
  ASSERT_EQ(known.exit_code, 0) << known.errors;
  const auto report = JsonFromText(known.output);
  EXPECT_EQ(report["tracked"], 12);
  EXPECT_LT(report["ate_live_rmse"].get<double>(), 1e-9);
  EXPECT_EQ(report["map_points"], 0);

  const test::ScratchFolder scratch;
  const std::string table = (scratch / "run.csv").string();
  const auto unseen = test::RunUlf(
      "track 'sim:studio?width=320&height=240' --frames 5 --poses markers:charuco:7x5:30:22:DICT_5X5_100 "
      "--table " +
      table);
  EXPECT_EQ(unseen.exit_code, 1);
  EXPECT_THAT(unseen.output, testing::HasSubstr("no frame has a pose: check what --poses names"));
  const std::string rows = ReadWholeFile(table);
  EXPECT_EQ(std::ranges::count(rows, '\n'), 6);
  EXPECT_THAT(rows, testing::HasSubstr(",0,0.0000,0,,\n"));
  EXPECT_THAT(test::RunUlf("track sim:studio --frames 5 --poses tum:").errors,
              testing::HasSubstr("write tum:FILE"));
  const auto unknown = test::RunUlf("track sim:studio --frames 5 --poses rosary");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, testing::HasSubstr("--poses rosary"));
}

// The simulator knows where the camera was, which is not what explains a bent picture.
TEST(TrackCommand, RollingShutterPosesAreJudgedTwice) {
  const std::string sim = "track 'sim:studio?width=320&height=240&noise=0&readout_ms=20' --frames 45 ";
  const auto told = test::RunUlf(sim + "--deterministic --json --readout-ms 20");
  ASSERT_EQ(told.exit_code, 0) << told.errors;
  const auto report = JsonFromText(told.output);
  EXPECT_LT(report["middle_row"]["ate_live_rmse"], report["ate_live_rmse"]);
  EXPECT_LT(report["middle_row"]["ate_final_rmse"], report["ate_final_rmse"]);
  const auto global = test::RunUlf(sim + "--deterministic --json --readout-ms 0");
  EXPECT_TRUE(JsonFromText(global.output)["middle_row"].is_null());
}

// The figures are those of the files, and so are the table's.
TEST(TrackCommand, FiguresAreThoseOfTheFiles) {
  const test::ScratchFolder scratch;
  const std::string sim = "track 'sim:studio?width=320&height=240&noise=0' --frames 40 --deterministic ";
  const auto in = [&](const char* name) { return (scratch / name).string(); };
  // The device's own poses, as a file of truth.
  ASSERT_EQ(test::RunUlf(sim + "--poses known -o " + in("truth.txt")).exit_code, 0);
  const auto run = test::RunUlf(sim + "--json --truth " + in("truth.txt") + " -o " + in("live.txt") +
                                " --final " + in("final.txt") + " --table " + in("run.csv"));
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto report = JsonFromText(run.output);
  const auto truth = ReadTum(in("truth.txt"));
  for (const auto& [which, file] : {std::pair("live", "live.txt"), std::pair("final", "final.txt")}) {
    const auto error = CompareTrajectories(ReadTum(in(file)), truth, 0.01);
    ASSERT_TRUE(error);
    const std::string name = which;
    const auto near = [&](const std::string& key, double value) {
      ASSERT_TRUE(report.contains(key)) << key;
      EXPECT_NEAR(report[key].get<double>(), value, 1e-4 * value + 1e-9) << key;
    };
    near("ate_" + name + "_rmse", error->ate_rmse);
    near("ate_" + name + "_median", error->ate_median);
    near("ate_" + name + "_max", error->ate_max);
    near("rpe_" + name + "_rmse", error->rpe_rmse);
    near("rpe_" + name + "_rotation_rmse_deg", error->rpe_rotation_rmse_deg);
    near("drift_" + name, error->drift);
  }
  EXPECT_FALSE(report.contains("explain")) << "not asked";
  const auto& stages = report["stage_cpu_ms_mean"];
  for (const char* stage : {"pyramid", "features", "matching", "alignment", "refinement", "initialisation"})
    EXPECT_GT(stages[stage].get<double>(), 0) << stage;
  EXPECT_GE(report["ms_longest"].get<double>(), report["ms_p95"].get<double>());
  std::istringstream table(ReadWholeFile(in("run.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "time_s,has_pose,quality,map_points_found,error_live,error_final");
  int rows = 0;
  double largest = 0;
  for (; std::getline(table, line); ++rows) {
    const std::string before_final = line.substr(0, line.rfind(','));
    const std::string live = before_final.substr(before_final.rfind(',') + 1);
    if (!live.empty()) largest = std::max(largest, std::stod(live));
  }
  EXPECT_EQ(rows, 40);
  const double live_max = report["ate_live_max"];
  EXPECT_NEAR(largest, live_max, 1e-4 * live_max);
}

TEST(TrackCommand, SaysWhatStartedTheMapAndWhatItKeeps) {
  const std::string track = "track 'sim:studio?width=320&height=240' --frames 20 --deterministic --explain ";
  const auto json = test::RunUlf(track + "--json");
  ASSERT_EQ(json.exit_code, 0) << json.errors;
  const auto explained = JsonFromText(json.output)["explain"];
  ASSERT_EQ(explained.size(), 3u);
  const auto count = [&](std::size_t choice, std::size_t candidate) {
    return std::stoi(explained[choice]["candidates"][candidate]["evidence"].get<std::string>());
  };
  const auto& start = explained[0]["candidates"];
  ASSERT_EQ(start.size(), 3u);
  const bool flat = count(0, 1) > 0.85 * count(0, 2);  // as the criterion says
  EXPECT_FALSE(start[0]["chosen"]) << "a rotation starts none";
  EXPECT_EQ(start[1]["chosen"], flat) << start;
  EXPECT_EQ(start[2]["chosen"], !flat) << start;
  EXPECT_LT(count(0, 0), count(0, 1));
  for (const std::size_t kept : {1u, 2u}) {
    EXPECT_GT(count(kept, 0), 1);
    EXPECT_LE(count(kept, 0), count(kept, 1));
  }
  EXPECT_LT(count(1, 1), count(1, 2));
  EXPECT_EQ(count(1, 2), 20);
  EXPECT_THAT(test::RunUlf(track).output,
              testing::HasSubstr(flat ? "\n* homography  " : "\n* essential matrix  "));
}

// `count` pictures of a room whose camera has a focal length of 520 px, as a folder to replay. They are made
// once: another name of the same file is exchanged by a test, never written into.
void WriteRoom(const std::filesystem::path& folder, int count) {
  static const test::ScratchFolder made;
  static int there = 0;
  const test::TexturedRoom room({});
  for (int k = 0; k < count; ++k) {
    const std::string name = fmt::format("{:02}.png", k);
    if (k == there) {
      cv::imwrite((made / name).string(),
                  room.Take(test::TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k)).image.pixels);
      ++there;
    }
    std::filesystem::create_hard_link(made / name, folder / name);
  }
}

TEST(TrackCommand, FailureKeepsThePosesUntilThen) {
  const test::ScratchFolder scratch;
  WriteRoom(scratch.path(), 60);
  std::string bytes = ReadWholeFile(scratch / "50.png");
  for (std::size_t i = 100; i < 300; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  WriteFileAtomically(scratch / "50.png", bytes);
  const std::string poses = (scratch / "poses.txt").string();
  const auto broken =
      test::RunUlf("track replay:" + scratch.path().string() + "?glob=*.png --focal-px 520 -o " + poses);
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_THAT(broken.errors, testing::AllOf(testing::HasSubstr("50.png"), testing::HasSubstr("were kept")));
  EXPECT_GT(ReadTum(poses).size(), 20u);
}

// A map that is given up a few frames after its start, because another room is seen: two worlds, two files.
TEST(TrackCommand, PosesOfALostMapHaveTheirOwnFile) {
  const test::ScratchFolder scratch;
  WriteRoom(scratch.path(), 40);
  const std::string track =
      "track replay:" + scratch.path().string() + "?glob=*.png --deterministic --focal-px 520 ";
  const auto first = test::RunUlf(track + "--json");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  const int started = JsonFromText(first.output)["init_frame"];
  const test::TexturedRoom other({.seed = 31});
  for (int k = started + 5; k < 70; ++k) {
    const std::filesystem::path picture = scratch / fmt::format("{:02}.png", k);
    std::filesystem::remove(picture);
    cv::imwrite(picture.string(),
                other.Take(test::TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k)).image.pixels);
  }
  const auto run = test::RunUlf(track + "-o " + (scratch / "live.txt").string() + " --final " +
                                (scratch / "final.txt").string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, testing::HasSubstr("live.map1.txt: 5 poses of another map"));
  for (const std::string name : {"live", "final"}) {
    EXPECT_EQ(ReadTum(scratch / (name + ".map1.txt")).size(), 5u);
    const auto last = ReadTum(scratch / (name + ".txt"));
    ASSERT_GT(last.size(), 20u);
    EXPECT_GT(last.front().time_s, ReadTum(scratch / (name + ".map1.txt")).back().time_s);
  }
}

TEST(TrackCommand, ReportsAWrongFocalLength) {
  const test::ScratchFolder scratch;
  WriteRoom(scratch.path(), 90);
  const auto run =
      test::RunUlf("track replay:" + scratch.path().string() + "?glob=*.png --deterministic --focal-px 546");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, testing::HasSubstr("below the 546.0 given"));
  EXPECT_THAT(run.output,
              testing::AllOf(testing::HasSubstr("below the 546.0 given"), testing::HasSubstr("calibration")));
}

TEST(TrackCommand, FindsTheLensFromAGuess) {
  const test::ScratchFolder scratch;
  const std::string room = "replay:" + (scratch / "room").string() + "?glob=*.png",
                    lens = (scratch / "lens.json").string();
  std::filesystem::create_directory(scratch / "room");
  WriteRoom(scratch / "room", 90);
  EXPECT_THAT(test::RunUlf("track '" + room + "' --intrinsics check").errors,
              testing::AllOf(testing::HasSubstr("intrinsics are not known"),
                             testing::HasSubstr("--intrinsics refine")));
  EXPECT_THAT(test::RunUlf("track '" + room + "' --frames 5").errors,
              testing::HasSubstr("a focal length of 544 px is guessed"));
  const auto run = test::RunUlf(
      "track '" + room + "' --deterministic --intrinsics refine --calibration-out " + lens + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, testing::AllOf(testing::HasSubstr("a focal length of 544 px is guessed"),
                                         testing::HasSubstr("tracking goes on with this lens"),
                                         testing::Not(testing::HasSubstr("544.0 given"))));
  const auto report = JsonFromText(run.output);
  EXPECT_NEAR(report["refined_lens"]["focal_px"].get<double>(), 520, 0.015 * 520);
  EXPECT_FALSE(report["calibration"]["wrong"]);
  EXPECT_EQ(acquisition::ReadCalibration(lens).fx, report["refined_lens"]["focal_px"].get<double>());
}

TEST(TrackCommand, ResumesUnderALensThatItFound) {
  const test::ScratchFolder scratch;
  const std::string room = "replay:" + (scratch / "room").string() + "?glob=*.png",
                    lens = (scratch / "lens.json").string(), dir = (scratch / "lf").string();
  std::filesystem::create_directory(scratch / "room");
  WriteRoom(scratch / "room", 90);
  const std::string capture = "capture '" + room + "' -o " + dir +
                              " --headless --deterministic --no-geometry --json --intrinsics refine ";
  const auto first = test::RunUlf(capture + "--calibration-out " + lens);
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_THAT(first.errors,
              testing::AllOf(testing::HasSubstr("a focal length of 544 px is guessed"),
                             testing::HasSubstr("not the 544.0 px in use: the capture goes on")));
  const auto report = JsonFromText(first.output);
  const double focal_px = report["refined_lens"]["focal_px"];
  EXPECT_NEAR(focal_px, 520, 0.015 * 520);
  EXPECT_EQ(acquisition::ReadCalibration(lens).fx, focal_px);
  EXPECT_EQ(ReadLightField(dir).cameras.at(0).fx, focal_px);

  const auto refused = test::RunUlf(capture + "--resume");
  EXPECT_EQ(refused.exit_code, 2) << "a lens is not sought over views that hold the map under theirs";
  EXPECT_THAT(refused.errors, testing::AllOf(testing::HasSubstr("--intrinsics refine"),
                                             testing::HasSubstr("ulf refine " + dir + " --intrinsics")));
  const auto second =
      test::RunUlf("capture '" + room + "' -o " + dir +
                   " --headless --deterministic --no-geometry --json --resume --calibration " + lens);
  ASSERT_EQ(second.exit_code, 0) << second.errors;
  EXPECT_THAT(second.errors, testing::AllOf(testing::HasSubstr("the map of the last session was loaded"),
                                            testing::Not(testing::HasSubstr("guessed"))));
  EXPECT_EQ(ReadLightField(dir).cameras.size(), 1u) << "the file holds the lens that the light field has";
  EXPECT_TRUE(JsonFromText(second.output)["refined_lens"].is_null());
  EXPECT_EQ(ReadLightField(dir).cameras.at(0).fx, focal_px);
}

TEST(TrackCommand, ALensIsWrittenOnlyWhereOneIsSought) {
  const test::ScratchFolder scratch;
  const std::string never = (scratch / "never").string();
  const auto run = test::RunUlf("track sim:studio --frames 5 --calibration-out " + never);
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.errors, testing::HasSubstr("--intrinsics refine"));
  const std::string dir = (scratch / "lf").string(),
                    capture = "capture sim:studio -o " + dir + " --headless ";
  EXPECT_THAT(test::RunUlf(capture + "--calibration-out " + never).errors,
              testing::HasSubstr("--intrinsics refine"));
  for (const std::string& command : {std::string("track sim:studio --frames 5"), capture})
    EXPECT_THAT(test::RunUlf(command + " --poses known --intrinsics refine").errors,
                testing::HasSubstr("tracked features alone"));
  EXPECT_FALSE(std::filesystem::exists(dir)) << "refused before anything is written";
  const std::string few = " --frames 12 --deterministic --intrinsics refine --calibration-out " + never;
  for (const std::string& command :
       {std::string("track 'sim:studio?width=160&height=120'"),
        "capture 'sim:studio?width=160&height=120' --headless --no-geometry -o " + dir})
    EXPECT_THAT(test::RunUlf(command + few).errors, testing::HasSubstr("never: no calibration is written"));
  EXPECT_FALSE(std::filesystem::exists(never));
  EXPECT_THAT(test::RunUlf("track sim:studio --frames 5 --intrinsics guess").errors,
              testing::HasSubstr("'guess' is none of fixed, check and refine"));
}

// Pictures that a rolling shutter bends fit another focal length better.
TEST(TrackCommand, RollingShutterMayLookLikeAWrongLens) {
  const std::string track =
      "track 'sim:studio?width=320&height=240&duration_s=6&look_away=0&readout_ms=20' --deterministic";
  EXPECT_THAT(test::RunUlf(track).output, testing::HasSubstr("compensated from then on"));
  const auto run = test::RunUlf(track + " --readout-ms report");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, testing::AllOf(testing::HasSubstr("rolling shutter of about"),
                                         testing::HasSubstr("--readout-ms"),
                                         testing::HasSubstr("a rolling shutter can look like that")));
}

// What the person with the camera reads while nothing has started yet.
TEST(TrackCommand, TheStartIsToldInWords) {
  Track track;
  track.start = StartProgress{StartObstacle::kLowParallax, 0.43, 0.8, 150, 60};
  EXPECT_THAT(InWords(track, FrameSource::kCamera),
              testing::AllOf(testing::HasSubstr("sideways"), testing::HasSubstr("0.4 of 0.8 degrees")));
  track.start->obstacle = StartObstacle::kRotationOnly;
  EXPECT_THAT(InWords(track, FrameSource::kCamera), testing::HasSubstr("only turns"));
  track.start = StartProgress{StartObstacle::kTooFewMatches, 0, 0.8, 12, 60};
  EXPECT_THAT(InWords(track, FrameSource::kCamera), testing::HasSubstr("12 of 60"));
}

// Where the picture itself shows nothing, nobody is told to move otherwise.
TEST(TrackCommand, BlankPictureIsReportedNotTheMotion) {
  Tracker tracker(test::TexturedRoom::Camera(), {.deterministic = true});
  Frame frame;
  frame.status = FrameStatus::kComplete;
  frame.image = {.pixels = cv::Mat(480, 640, CV_8U, cv::Scalar(90)), .transfer = Transfer::kSrgb};
  const std::string starting = InWords(tracker.Step(frame), FrameSource::kCamera);
  EXPECT_THAT(starting,
              testing::AllOf(testing::HasSubstr("hardly any corners"), testing::HasSubstr("0 of 80"),
                             testing::Not(testing::HasSubstr("hand"))));
  Track lost;
  lost.state = TrackState::kLost;
  lost.features = 12;
  EXPECT_THAT(InWords(lost, FrameSource::kCamera),
              testing::AllOf(testing::HasSubstr("hardly any corners"), testing::HasSubstr("12 of 80"),
                             testing::Not(testing::HasSubstr("seen before"))));
  lost.features = 700;
  EXPECT_THAT(InWords(lost, FrameSource::kCamera), testing::HasSubstr("nothing in view is recognised"));
}

TEST(TrackCommand, TrackingSideIsObeyedOrRefused) {
  const auto size_of = [](const std::string& option) {
    const auto run = test::RunUlf("track 'sim:studio?width=320&height=240' --frames 2 --json " + option);
    return JsonFromText(run.output)["tracked_size"];
  };
  EXPECT_EQ(
      size_of("--tracking-side 200"),
      nlohmann::json({{"width", 200}, {"height", 150}, {"original_width", 320}, {"original_height", 240}}));
  // What fails on large pictures looks like a wrong movement: said beforehand.
  for (const bool full : {true, false}) {
    const auto run = test::RunUlf("track 'sim:studio?width=1000&height=96' --frames 2 " +
                                  std::string(full ? "--tracking-side full" : ""));
    EXPECT_EQ(run.errors.find("unless they are sharp") != std::string::npos, full) << run.errors;
    EXPECT_THAT(run.output, testing::AnyOf(testing::Not(testing::HasSubstr("never initialised")),
                                           testing::HasSubstr("of 2 frames")));
  }
  for (const char* option : {"", "--tracking-side full", "--tracking-side 0"})
    EXPECT_EQ(size_of(option)["width"], 320) << option;
  for (const char* command : {"track sim:studio", "capture --no-geometry sim:studio -o nowhere"})
    for (const char* wrong : {"12", "-1", "640.5", "half", "100000"}) {
      const auto refused = test::RunUlf(std::string(command) + " --frames 2 --tracking-side " + wrong);
      EXPECT_EQ(refused.exit_code, 2) << wrong;
      EXPECT_THAT(refused.errors,
                  testing::AllOf(testing::HasSubstr("--tracking-side"), testing::HasSubstr(wrong),
                                 testing::HasSubstr("from 160 to")));
    }
}

}  // namespace
}  // namespace ulf::track_command_test
