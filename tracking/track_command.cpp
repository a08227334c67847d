#include "tracking/track_command.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <optional>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/counted.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/number_checks.h"
#include "acquisition/output_path.h"
#include "acquisition/replay_device.h"
#include "acquisition/stop_signal.h"
#include "tracking/pose_source.h"
#include "tracking/quantile.h"
#include "tracking/thread_clock.h"
#include "tracking/trajectory.h"

namespace ulf {
namespace {

struct TrackArgs {
  std::string uri;
  std::string output;
  std::string final_output;
  std::string truth;
  std::string calibration;
  std::string poses = "features";
  double focal_px = 0;
  double fps = 0;
  std::optional<double> speed;
  bool deterministic = false;
  unsigned seed = 1;
  int features = 1000;
  int frames = 0;
  bool benchmark = false;
  bool json = false;
};

// One frame's outcome, as it was given live.
struct Sample {
  double time_s = 0;
  Track track;
  double wall_ms = 0;
};

struct Run {
  std::vector<Sample> samples;
  std::vector<TimedPose> live, final;
  std::vector<TimedPose> known;  // what the device itself knows (simulator, recorded light field)
  std::vector<double> orb_cpu_ms;
  TrackerStatistics map;
};

// What cv::ORB costs on the same frame, thread and moment: the unit in which tracking cost is told.
double TimeOrb(const cv::Ptr<cv::ORB>& orb, const Frame& frame) {
  const cv::Mat gray = GrayForTracking(frame.image);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const double start_s = ThreadCpuSeconds();
  orb->detectAndCompute(gray, cv::noArray(), keypoints, descriptors);
  return 1000 * (ThreadCpuSeconds() - start_s);
}

Run Follow(const TrackArgs& args, const PosesSpec& spec, Device& device) {
  Run run;
  std::unique_ptr<PoseSource> poses;
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(1000);
  constexpr std::size_t kOrbEvery = 10;
  Progress progress("track", args.json);
  device.Start();
  while (!IsOver(device.State()) && !StopOnSignal::Asked()) {
    for (const DeviceEvent& event : device.TakeEvents()) spdlog::warn("{}", event.text);
    const auto frame = device.Next(std::chrono::milliseconds(200));
    if (!frame || frame->status != FrameStatus::kComplete || frame->kind != FrameKind::kLive) continue;
    if (!poses) {
      IntrinsicsArgs intrinsics{args.calibration, std::nullopt};
      if (args.focal_px > 0) intrinsics.focal_px = args.focal_px;
      poses = spec.Open(ResolveIntrinsics(device, intrinsics, frame->image.width(), frame->image.height()),
                        {.tracker = {.deterministic = args.deterministic,
                                     .seed = args.seed,
                                     .features = args.features,
                                     .wait_for_mapper = !device.IsLive()}});
    }
    if (frame->known_cam_from_world)
      run.known.push_back({frame->device_time_s, *frame->known_cam_from_world});
    Sample sample;
    sample.time_s = frame->device_time_s;
    const auto start = std::chrono::steady_clock::now();
    sample.track = poses->Step(*frame);
    sample.wall_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (sample.track.cam_from_world) run.live.push_back({sample.time_s, *sample.track.cam_from_world});
    if (args.benchmark && run.samples.size() % kOrbEvery == 0 && !frame->image.empty())
      run.orb_cpu_ms.push_back(TimeOrb(orb, *frame));
    run.samples.push_back(std::move(sample));
    const int count = static_cast<int>(run.samples.size());
    progress.Show(args.frames > 0 ? static_cast<double>(count) / args.frames : device.ShareDone().value_or(0),
                  fmt::format("frame {}", count));
    if (args.frames > 0 && count >= args.frames) break;
  }
  const bool lost = device.State() == DeviceState::kLost;
  device.Stop();
  if (!poses)
    throw Error("{}: no frame came; {}", args.uri,
                lost ? "the device was lost" : "check that it delivers images");
  if (lost) spdlog::warn("{}: the device was lost after {} frames", args.uri, run.samples.size());
  poses->Finish();
  for (const Sample& sample : run.samples)
    if (sample.track.anchor) run.final.push_back({sample.time_s, poses->PoseOf(*sample.track.anchor)});
  run.map = poses->Statistics();
  return run;
}

nlohmann::ordered_json Describe(const Run& run) {
  int tracked = 0, lost_count = 0, relocalised = 0;
  std::optional<int> init_frame;
  std::vector<double> wall_ms, cpu_ms;
  TrackState before = TrackState::kInitializing;
  for (int i = 0; i < static_cast<int>(run.samples.size()); ++i) {
    const Sample& sample = run.samples[static_cast<std::size_t>(i)];
    const Track& track = sample.track;
    tracked += track.cam_from_world.has_value();
    relocalised += track.relocalized;
    lost_count += before == TrackState::kTracking && track.state != TrackState::kTracking;
    if (!init_frame && track.cam_from_world) init_frame = i;
    before = track.state;
    if (track.skipped) continue;
    wall_ms.push_back(sample.wall_ms);
    cpu_ms.push_back(1000 * track.cpu_s);
  }
  nlohmann::ordered_json report{{"frames", run.samples.size()}};
  report["init_frame"] = init_frame ? nlohmann::ordered_json(*init_frame) : nlohmann::ordered_json(nullptr);
  report["tracked"] = tracked;
  report["lost_count"] = lost_count;
  report["relocalised_count"] = relocalised;
  report["ms_median"] = Quantile(wall_ms, 0.5);
  report["ms_p95"] = Quantile(wall_ms, 0.95);
  report["cpu_ms_median"] = Quantile(cpu_ms, 0.5);
  report["cpu_ms_p95"] = Quantile(cpu_ms, 0.95);
  report["map_points"] = run.map.map_points;
  report["keyframes"] = run.map.keyframes;
  if (!run.orb_cpu_ms.empty()) {
    report["orb_cpu_ms_median"] = Quantile(run.orb_cpu_ms, 0.5);
    report["cpu_over_orb"] = Quantile(cpu_ms, 0.5) / Quantile(run.orb_cpu_ms, 0.5);
  }
  return report;
}

void AddErrors(const Run& run, const std::vector<TimedPose>& truth, nlohmann::ordered_json& report) {
  double tolerance_s = 1.0 / 60;
  if (run.samples.size() > 1) {
    const double span_s = run.samples.back().time_s - run.samples.front().time_s;
    tolerance_s = 0.5 * span_s / static_cast<double>(run.samples.size() - 1);
  }
  const auto live = CompareTrajectories(run.live, truth, tolerance_s);
  const auto final = CompareTrajectories(run.final, truth, tolerance_s);
  const auto number = [](bool known, double value) {
    return known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  report["ate_live_rmse"] = number(live.has_value(), live ? live->ate_rmse : 0);
  report["ate_final_rmse"] = number(final.has_value(), final ? final->ate_rmse : 0);
  report["rpe_rmse"] = number(final.has_value(), final ? final->rpe_rmse : 0);
  report["scale"] = number(final.has_value(), final ? final->scale : 0);
  report["ate_live_max"] = number(live.has_value(), live ? live->ate_max : 0);
  report["ate_final_max"] = number(final.has_value(), final ? final->ate_max : 0);
  report["rotation_final_rmse_deg"] = number(final.has_value(), final ? final->rotation_rmse_deg : 0);
  report["compared"] = live ? live->matched : 0;
}

void PrintText(const std::string& truth_name, const nlohmann::ordered_json& report) {
  const int frames = report["frames"], tracked = report["tracked"];
  const auto& init = report["init_frame"];
  fmt::print("{}, {} tracked ({:.1f} %), ", Counted(frames, "frame"), tracked,
             100.0 * tracked / std::max(1, frames));
  if (init.is_null())
    fmt::print("never initialised\n");
  else
    fmt::print("initialised at frame {}, {:.1f} % tracked from there on\n", init.get<int>(),
               100.0 * tracked / std::max(1, frames - init.get<int>()));
  fmt::print("lost {}, found again {}; {}, {}\n", Counted(report["lost_count"].get<int>(), "time"),
             Counted(report["relocalised_count"].get<int>(), "time"),
             Counted(report["keyframes"].get<int>(), "keyframe"),
             Counted(report["map_points"].get<int>(), "map point"));
  fmt::print("per frame: {:.1f} ms (95 %: {:.1f}), CPU {:.1f} ms (95 %: {:.1f})\n",
             report["ms_median"].get<double>(), report["ms_p95"].get<double>(),
             report["cpu_ms_median"].get<double>(), report["cpu_ms_p95"].get<double>());
  if (report.contains("cpu_over_orb"))
    fmt::print("cv::ORB with 1000 features: {:.1f} ms; tracking costs {:.2f} times that\n",
               report["orb_cpu_ms_median"].get<double>(), report["cpu_over_orb"].get<double>());
  if (report.contains("ate_live_rmse")) {
    if (report["ate_live_rmse"].is_null())
      fmt::print("error: fewer than three frames of the truth were tracked\n");
    else
      fmt::print(
          "camera centres against {}: RMS {:.5f} live, {:.5f} after the run (largest {:.5f}, {:.5f}; {} "
          "poses)\n",
          truth_name, report["ate_live_rmse"].get<double>(), report["ate_final_rmse"].get<double>(),
          report["ate_live_max"].get<double>(), report["ate_final_max"].get<double>(),
          report["compared"].get<int>());
  }
}

int RunTrack(const TrackArgs& args) {
  for (const std::string& output : {args.output, args.final_output})
    if (!output.empty()) RequireWritable(output);
  const PosesSpec spec = PosesSpec::Parse(args.poses);
  const StopOnSignal signals;
  std::vector<TimedPose> truth;
  if (!args.truth.empty()) truth = ReadTum(args.truth);
  // OpenCV would spread single frames over all cores, which the other threads need.
  cv::setNumThreads(1);
  std::string uri = args.uri;
  if (args.fps > 0) uri += fmt::format("{}fps={}", uri.find('?') == std::string::npos ? '?' : '&', args.fps);
  const auto device = OpenDevice(WithReplaySpeed(uri, args.speed));
  const Run run = Follow(args, spec, *device);
  if (!args.output.empty()) WriteTum(args.output, run.live);
  if (!args.final_output.empty()) WriteTum(args.final_output, run.final);
  nlohmann::ordered_json report = Describe(run);
  // Without a file, the device's own poses serve where it knows them.
  const std::string truth_name = args.truth.empty() ? "the device's own poses" : args.truth;
  if (args.truth.empty()) truth = run.known;
  if (!truth.empty()) AddErrors(run, truth, report);
  if (args.json)
    fmt::print("{}\n", report.dump(2));
  else
    PrintText(truth_name, report);
  return run.live.empty() ? kFailed : kOk;
}

}  // namespace

void AddTrackCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<TrackArgs>();
  CLI::App* command =
      app.add_subcommand("track", "Camera poses of a sequence or a live camera, without recording");
  command->add_option("URI", args->uri,
                      "Device: replay:PATH, sim:studio, aravis:ID; none: the first real camera");
  command->add_option("-o,--output", args->output, "Poses as given live, TUM format (camera to world)");
  command->add_option("--final", args->final_output, "Poses after the run's last adjustment, TUM format");
  command->add_option("--truth", args->truth,
                      "True poses, TUM format: prints the error (without it, what the device knows)");
  command->add_option("--calibration", args->calibration, "Intrinsics")->check(CLI::ExistingFile);
  command->add_option("--focal-px", args->focal_px, "Focal length where nothing better is known")
      ->check(Positive());
  command->add_option("--poses", args->poses, kPosesHelp)->capture_default_str();
  command->add_option("--fps", args->fps, "Frame rate of a replayed folder")->check(Positive());
  command
      ->add_option("--speed", args->speed,
                   "Of a recording: 1 in time, N faster; none or 0: as fast as it goes")
      ->check(NonNegative());
  command->add_option("--frames", args->frames, "Stop after this many frames")->check(Positive());
  command->add_option("--features", args->features, "Features per frame")->check(CLI::Range(200, 5000));
  command->add_option("--seed", args->seed, "Of every random draw");
  command->add_flag("--deterministic", args->deterministic, "One thread, same result every time");
  command->add_flag("--benchmark", args->benchmark, "Time cv::ORB with 1000 features in the same run, too");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf track 'replay:kitchen?glob=*.color.jpg' --calibration intrinsics.txt -o poses.txt "
      "--truth reference.txt\nSIGINT ends a live camera's run: poses are written and figures printed.");
  command->callback([args, &chosen] { chosen = [args] { return RunTrack(*args); }; });
}

}  // namespace ulf
