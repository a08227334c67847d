// Tests: commands/camera/record_command, commands/reports/device_report.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "acquisition/device/frame_recording.h"
#include "commands/reports/device_report.h"
#include "core/base/json_text.h"
#include "tests/support/test_paths.h"

namespace ulf::commands::camera_commands_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(DeviceReport, CountsAreTheSameForPeopleAndPrograms) {
  acquisition::DeviceStatistics statistics;
  statistics.delivered = 30;
  statistics.dropped = 2;
  statistics.seconds = 2;
  statistics.bytes = 6000000;
  statistics.transport = {{acquisition::TransportFigure::kPacketsResent, 7},
                          {acquisition::TransportFigure::kPacketsMissing, 0}};
  const std::string text = ToText(statistics);
  EXPECT_THAT(text, HasSubstr("30 frames delivered in 2.0 s (15.0 a second, 3.0 MB/s)"));
  EXPECT_THAT(text, HasSubstr("2 dropped"));
  EXPECT_THAT(text, HasSubstr("packets resent 7"));
  EXPECT_THAT(text, Not(HasSubstr("packets missing")));
  const auto json = ToJson(statistics);
  EXPECT_EQ(json["fps"], 15);
  EXPECT_EQ(json["transport"]["packets missing"], 0);
  EXPECT_TRUE(json["clock_offset_s"].is_null());
}

TEST(RecordCommand, KeepsFramesAndRefusesATakenFolder) {
  const test::ScratchFolder folder;
  const std::string command =
      "record 'sim:wall?width=64&height=48' --json --frames 5 -o " + (folder / "session").string();
  const auto run = test::RunUlf(command);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(JsonFromText(run.output)["frames"], 5);
  EXPECT_EQ(acquisition::ReadFrameRecording(folder / "session").entries.size(), 5u);
  EXPECT_EQ(test::RunUlf(command).exit_code, 1);
}

}  // namespace
}  // namespace ulf::commands::camera_commands_test
