// `ulf record`: records every frame of a device, so that a session can be run again.
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "acquisition/device/repeated_events.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/reports/device_report.h"
#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/stop_signal.h"

namespace ulf::commands {
namespace {

struct RecordArgs {
  std::string uri;
  std::string dir;
  std::uint64_t frames = 0;
  double max_seconds = 0;
  bool json = false;
};

using Clock = std::chrono::steady_clock;

struct RecordRun {
  acquisition::FrameRecorderSummary summary;
  acquisition::DeviceStatistics device;
  double seconds = 0;
  bool lost = false;
  FrameSource source = FrameSource::kCamera;
  std::string remark;  // for a replay: conversions
};

bool IsComplete(const RecordArgs& args, std::uint64_t frames, double seconds) {
  return StopOnSignal::Requested() || (args.frames > 0 && frames >= args.frames) ||
         (args.max_seconds > 0 && seconds >= args.max_seconds);
}

// Keeps every photograph, also raw files, but no incomplete live frames, which the device counts.
bool IsKept(const Frame& frame) {
  return frame.kind == FrameKind::kStill || frame.status == FrameStatus::kComplete;
}

// Reports when the recorder starts and stops leaving frames out.
void ReportPause(const acquisition::FrameRecorder& recorder, Progress& progress, bool& paused) {
  const auto why = recorder.Pause();
  if (why && !paused) progress.Say("frames are left out: " + *why);
  if (!why && paused) progress.Say("frames are kept again");
  paused = why.has_value();
}

RecordRun Record(const RecordArgs& args) {
  std::error_code unknown;
  const bool was_there = std::filesystem::exists(args.dir, unknown);
  acquisition::RequireNewRecording(args.dir);
  std::unique_ptr<acquisition::Device> device;
  try {
    device = acquisition::OpenDevice(args.uri);
    device->Start();
  } catch (...) {
    if (!was_there) std::filesystem::remove(args.dir, unknown);  // empty
    throw;
  }
  acquisition::FrameRecorder recorder(args.dir, acquisition::RecordingHeader::Of(*device));
  Progress progress("record");
  RecordRun run;
  run.source = device->Source();
  run.remark = device->Info().remark;
  bool paused = false;
  acquisition::RepeatedEvents repeated;
  std::uint64_t frames = 0;
  const auto start = Clock::now();
  while (!acquisition::IsOver(device->State())) {
    run.seconds = SecondsSince(start);
    if (IsComplete(args, frames, run.seconds)) break;
    const auto frame = device->Next(std::chrono::milliseconds(100));
    const std::vector<acquisition::DeviceEvent> events = device->TakeEvents();
    for (const std::string& line : repeated.Update(events, EpochSeconds())) progress.Say(line);
    for (const acquisition::DeviceEvent& event : events) recorder.Note(event.text);
    ReportPause(recorder, progress, paused);
    if (frame && IsKept(*frame)) {
      ++frames;
      recorder.TryAdd(*frame);
    }
    const double share = args.frames > 0 ? static_cast<double>(frames) / static_cast<double>(args.frames)
                         : args.max_seconds > 0 ? run.seconds / args.max_seconds
                                                : device->ShareDone().value_or(0);
    const acquisition::DeviceState state = device->State();
    progress.Show(share, fmt::format("{}{}", Counted(frames, "frame"),
                                     state == acquisition::DeviceState::kStreaming
                                         ? ""
                                         : fmt::format("; the device is {}", Name(state))));
  }
  for (const std::string& line : repeated.Finish()) progress.Say(line);
  run.lost = device->State() == acquisition::DeviceState::kLost;
  device->Stop();
  // Photographs may arrive after Stop().
  while (const auto frame = device->TakesStills() ? device->Next(std::chrono::milliseconds(0)) : std::nullopt)
    if (frame->kind == FrameKind::kStill) recorder.TryAdd(*frame);
  run.device = device->Statistics();
  run.summary = recorder.Finish();
  run.seconds = SecondsSince(start);
  return run;
}

int RunRecord(const RecordArgs& args) {
  const StopOnSignal signals;
  const RecordRun run = Record(args);
  const acquisition::FrameRecorderSummary& summary = run.summary;
  const double mb_per_s = run.seconds > 0 ? 1e-6 * static_cast<double>(summary.bytes) / run.seconds : 0;
  if (args.json) {
    nlohmann::ordered_json json{{"frames", summary.written}, {"left_out", summary.left_out},
                                {"bytes", summary.bytes},    {"seconds", run.seconds},
                                {"mb_per_s", mb_per_s},      {"disk_s", summary.disk_s},
                                {"problem", summary.problem}};
    json["device"] = commands::ToJson(run.device);
    if (!run.remark.empty()) json["remark"] = run.remark;
    fmt::print("{}\n", JsonText(json));
  } else {
    fmt::print("{}: {}, {:.1f} MB in {:.1f} s ({:.1f} MB/s); {} left out{}\n", args.dir,
               Counted(summary.written, "frame"), 1e-6 * static_cast<double>(summary.bytes), run.seconds,
               mb_per_s, summary.left_out, summary.problem.empty() ? "" : ": " + summary.problem);
    fmt::print("device         {}\n", ToText(run.device));
  }
  if (run.lost) fmt::print(stderr, "ulf: {}: the device was lost; what came before is recorded\n", args.uri);
  if (!run.lost && summary.written == 0)
    fmt::print(stderr, "ulf: nothing was recorded: {}\n",
               IsTaken(run.source) ? "no complete picture is in it"
               : run.device.incomplete > 0
                   ? "every frame arrived incomplete (packets lost); see the receive buffer and packet size "
                     "above, and docs/devices.md"
                   : "no frame arrived; check whether the camera waits for a trigger");
  return run.lost || summary.written == 0 || summary.left_out > 0 ? kFailed : kOk;
}

}  // namespace

void AddRecordCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "record", "Record every frame of a device (run again by replay:FOLDER)", RunRecord);
  command->add_option("URI", args->uri, "Device (see 'ulf devices'); none: the first real camera");
  command->add_option("-o,--output", args->dir, "New folder")->required();
  command->add_option("--frames", args->frames, "Stop after so many frames (default: no limit)")
      ->check(Positive());
  command->add_option("--max-seconds", args->max_seconds, "Stop after so many seconds (default: no limit)")
      ->check(Positive());
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf record aravis:192.168.1.20 -o session --max-seconds 60\n"
      "Then:    ulf capture replay:session -o light_field --deterministic\n"
      "Ends with status 1 when frames had to be left out.");
}

}  // namespace ulf::commands
