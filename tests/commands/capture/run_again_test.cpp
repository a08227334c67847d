// Tests: commands/capture/capture_command, commands/capture/capture_closing, commands/capture/capture_start,
// commands/options/tracking_options.
//
// A session that was captured can be run again, and comes to the same.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "tests/support/test_paths.h"

namespace ulf::test::run_again_test {
namespace {

namespace fs = std::filesystem;

nlohmann::json Capture(const std::string& uri, const fs::path& dir, const std::string& more = "") {
  const CommandResult result = RunUlf("capture --no-geometry '" + uri + "' -o " + dir.string() +
                                      " --headless --deterministic --json " + more);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  if (result.exit_code != 0) return {};
  return JsonFromText(result.output);
}

std::string Journal(const fs::path& dir) { return ReadWholeFile(dir / "journal.jsonl"); }

// The header names the device, which is another one when a session is run again.
std::string WithoutHeader(const std::string& journal) { return journal.substr(journal.find('\n') + 1); }

TEST(RunAgain, EveryFrameKeptGivesTheSameSession) {
  const ScratchFolder scratch;
  const auto live = Capture("sim:studio?width=320&height=240", scratch / "live",
                            "--frames 60 --keep-frames " + (scratch / "frames").string());
  EXPECT_EQ(live["frames"], 60);
  EXPECT_GT(live["recorded"], 3) << "nothing was recorded: the test shows nothing";
  Capture("replay:" + (scratch / "frames").string(), scratch / "again");
  Capture("replay:" + (scratch / "frames").string(), scratch / "once_more");
  EXPECT_EQ(WithoutHeader(Journal(scratch / "again")), WithoutHeader(Journal(scratch / "live")));
  EXPECT_EQ(Journal(scratch / "again"), Journal(scratch / "once_more"));
  const LightField light_field = ReadLightField(scratch / "again");
  for (const View& view : light_field.views)
    EXPECT_EQ(ReadWholeFile(scratch / "again" / view.image_path),
              ReadWholeFile(scratch / "live" / view.image_path));
}

TEST(RunAgain, ARecordingOfACameraIsASession) {
  const ScratchFolder scratch;
  const CommandResult recorded = RunUlf("record 'sim:studio?width=320&height=240' --frames 60 --json -o " +
                                        (scratch / "frames").string());
  ASSERT_EQ(recorded.exit_code, 0) << recorded.errors;
  const auto report = JsonFromText(recorded.output);
  EXPECT_EQ(report["frames"], 60);
  EXPECT_EQ(report["device"]["delivered"], 60);
  Capture("sim:studio?width=320&height=240", scratch / "live", "--frames 60");
  Capture("replay:" + (scratch / "frames").string(), scratch / "again");
  EXPECT_EQ(WithoutHeader(Journal(scratch / "again")), WithoutHeader(Journal(scratch / "live")));
}

TEST(RunAgain, ASessionThatGoesOnKnowsTheShutter) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const std::string uri = "sim:studio?width=320&height=240&readout_ms=20";
  Capture(uri, dir, "--frames 45 --readout-ms 20");
  const LightField first = ReadLightField(dir);
  ASSERT_TRUE(first.readout);
  EXPECT_EQ(first.readout->readout_s, 0.02);
  EXPECT_FALSE(first.readout->sigma_s) << "it was given";
  ASSERT_GT(first.views.size(), 1u);
  EXPECT_TRUE(first.views[1].twist);
  const auto go_on = [&](const std::string& more) {
    const CommandResult result = RunUlf("capture --no-geometry '" + uri + "' -o " + dir.string() +
                                        " --headless --deterministic --json --resume --frames 1 " + more);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return std::pair(JsonFromText(result.output)["rolling_shutter"], result.errors);
  };
  for (const bool anew : {false, true}) {
    if (anew) fs::remove(dir / "cache" / "map.ulf");
    const auto [shutter, said] = go_on("");
    EXPECT_EQ(shutter["readout_ms"], 20) << anew;
    EXPECT_TRUE(shutter["compensated"]) << anew;
    EXPECT_NE(said.find("compensated from the first frame on"), std::string::npos) << said;
  }
  const auto [shutter, said] = go_on("--readout-ms 10");
  EXPECT_EQ(shutter["readout_ms"], 10);
  EXPECT_NE(said.find("the sessions before were given 20.0 ms; 10 is used"), std::string::npos) << said;
  EXPECT_EQ(ReadLightField(dir).readout->readout_s, 0.01);
}

TEST(RunAgain, ALightFieldReplaysItsViews) {
  const ScratchFolder scratch;
  Capture("sim:studio?width=160&height=120", scratch / "live",
          "--poses known --subject 0,0,0.07,0.162 --frames 200");
  for (const char* name : {"a", "b"})
    Capture("replay:" + (scratch / "live").string(), scratch / name, "--poses known");
  EXPECT_EQ(Journal(scratch / "a"), Journal(scratch / "b"));
  const LightField live = ReadLightField(scratch / "live"), again = ReadLightField(scratch / "a");
  ASSERT_GT(live.views.size(), 3u);
  ASSERT_EQ(again.views.size(), live.views.size()) << "each was wanted then, and is now";
  for (std::size_t i = 0; i < live.views.size(); ++i)
    EXPECT_EQ(again.views[i].device_time_s, live.views[i].device_time_s);
}

}  // namespace
}  // namespace ulf::test::run_again_test
