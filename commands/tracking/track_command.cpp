// `ulf track` tracks a sequence, and reports poses, errors against a truth, and cost.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/device/repeated_events.h"
#include "acquisition/device/replay_device.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/options/tracking_options.h"
#include "commands/reports/explain.h"
#include "commands/tracking/track_report.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/stop_signal.h"
#include "core/geometry/trajectory.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/track.h"

namespace ulf::commands {
namespace {

struct TrackArgs {
  std::string uri;
  std::string output;
  std::string final_output;
  std::string truth;
  std::string table;
  std::string calibration;
  std::string poses = "features";
  double focal_px = 0;
  double fps = 0;
  tracking::ReadoutArgs readout;
  LensUseArgs lens;
  std::optional<double> speed;
  bool deterministic = false;
  unsigned seed = 1;
  int features = tracking::TrackerOptions{}.features;
  int tracking_side_px = tracking::TrackerOptions{}.max_side_px;
  int frames = 0;
  bool benchmark = false;
  bool explain = false;
  bool json = false;
};

// Returns CPU milliseconds of cv::ORB on the same frame, at the tracked size, in the same thread: the unit in
// which the cost of tracking is reported.
double TimeOrb(const cv::Ptr<cv::ORB>& orb, const Frame& frame, const tracking::TrackedSize& size) {
  cv::Mat gray = GrayForTracking(frame.image);
  if (size.width > 0 && (gray.cols != size.width || gray.rows != size.height))
    cv::resize(gray, gray, {size.width, size.height}, 0, 0, cv::INTER_AREA);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const double start_s = ThreadCpuSeconds();
  orb->detectAndCompute(gray, cv::noArray(), keypoints, descriptors);
  return 1000 * (ThreadCpuSeconds() - start_s);
}

// A run with the poses that the device knows (simulator, recorded light field).
struct TrackedSequence {
  TrackRun run;
  std::vector<TimedPose> known;
};

// Warns at once when the images contradict the lens.
void NoteLens(const TrackedFrame& sample, const tracking::PoseSource& poses, tracking::LensUse use,
              TrackRun& run) {
  const auto after_s = [&] {
    const auto first = std::ranges::find_if(run.frames, &TrackedFrame::HasPose);
    return first == run.frames.end() ? 0 : sample.time_s - first->time_s;
  };
  const tracking::Track& track = sample.track;
  if (track.focal_ratio && !run.frames.back().track.focal_ratio)
    spdlog::warn("{}", tracking::ZoomInWords(*track.focal_ratio, run.source));
  if (const int before = run.frames.empty() ? 0 : run.frames.back().track.lens_revision;
      track.lens_revision > before) {
    if (!run.wrong_lens_after_s) run.wrong_lens_after_s = after_s();
    if (const auto lens = poses.Statistics().refined_lens)
      spdlog::info("images fit {}: tracking goes on with this lens, and the poses so far are corrected",
                   lens->Text());
  }
  // A lens that is replaced before the next frame needs no warning.
  if (!track.wrong_lens || run.wrong_lens_after_s || use == tracking::LensUse::kRefine) return;
  const auto lens = poses.Statistics().calibration;
  if (!lens) return;
  run.wrong_lens_after_s = after_s();
  spdlog::warn("{}", lens->Advice(run.source));
}

// Returns 0 without a pose, or if the source tracks no points.
double SeenDistance(const tracking::PoseSource& poses, const tracking::Track& track) {
  if (!track.cam_from_world) return 0;
  std::vector<double> distances;
  for (const tracking::VisiblePoint& point : poses.VisiblePoints())
    distances.push_back((*track.cam_from_world * point.position_in_world).norm());
  return distances.empty() ? 0 : Median(std::move(distances));
}

// Tracks until the device ends, enough frames have come or the operator stops.
void TrackSequence(const TrackArgs& args, const tracking::PosesSpec& spec, acquisition::Device& device,
                   std::unique_ptr<tracking::PoseSource>& poses, TrackedSequence& followed) {
  TrackRun& run = followed.run;
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(1000);
  constexpr std::size_t kOrbEvery = 10;
  Progress progress("track", args.json);
  acquisition::RepeatedEvents repeated;
  tracking::LensUse use = args.lens.use;
  device.Start();
  while (!acquisition::IsOver(device.State()) && !StopOnSignal::Requested()) {
    for (const std::string& line : repeated.Update(device.TakeEvents(), EpochSeconds()))
      spdlog::warn("{}", line);
    const auto frame = device.Next(std::chrono::milliseconds(200));
    if (!frame) acquisition::RequireLiveFrames(device);
    if (!frame || frame->status != FrameStatus::kComplete || frame->kind != FrameKind::kLive) continue;
    if (!poses) {
      acquisition::IntrinsicsArgs intrinsics{args.calibration, std::nullopt};
      if (args.focal_px > 0) intrinsics.focal_px = args.focal_px;
      // Nobody can calibrate the lens of pictures that are taken already.
      const bool may_seek = !args.lens.is_asked && IsTaken(device.Source()) && spec.FindLens();
      if (may_seek || use == tracking::LensUse::kRefine)
        intrinsics.guessed_focal_px = acquisition::GuessFocalPx(*frame);
      auto origin = acquisition::LensOrigin::kMeasured;
      const CameraModel camera = acquisition::ResolveIntrinsics(device, intrinsics, frame->image.width(),
                                                                frame->image.height(), nullptr, &origin);
      if (may_seek && origin == acquisition::LensOrigin::kGuessed) use = tracking::LensUse::kRefine;
      poses = spec.Open(camera, {.tracker = {.deterministic = args.deterministic,
                                             .seed = args.seed,
                                             .features = args.features,
                                             .max_side_px = args.tracking_side_px,
                                             .wait_for_mapper = !device.IsLive(),
                                             .readout = args.readout,
                                             .lens = use,
                                             .lens_is_guess = origin != acquisition::LensOrigin::kMeasured},
                                 .stop = StopOnSignal::Requested});
    }
    if (frame->known_cam_from_world)
      followed.known.push_back({frame->device_time_s, *frame->known_cam_from_world});
    TrackedFrame sample;
    sample.time_s = frame->device_time_s;
    const auto start = std::chrono::steady_clock::now();
    sample.track = poses->Step(*frame);
    sample.wall_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (!args.truth.empty() || frame->known_cam_from_world)
      sample.seen_distance = SeenDistance(*poses, sample.track);
    if (args.benchmark && run.frames.size() % kOrbEvery == 0 && !frame->image.empty())
      run.orb_cpu_ms.push_back(TimeOrb(orb, *frame, poses->Statistics().size));
    NoteLens(sample, *poses, use, run);
    run.frames.push_back(std::move(sample));
    const int count = static_cast<int>(run.frames.size());
    progress.Show(args.frames > 0 ? static_cast<double>(count) / args.frames : device.ShareDone().value_or(0),
                  fmt::format("frame {}, {}", count, InWords(run.frames.back().track, run.source)));
    if (args.frames > 0 && count >= args.frames) break;
  }
  for (const std::string& line : repeated.Finish()) spdlog::warn("{}", line);
}

TrackedSequence Follow(const TrackArgs& args, const tracking::PosesSpec& spec, acquisition::Device& device) {
  TrackedSequence followed;
  TrackRun& run = followed.run;
  run.deterministic = args.deterministic;
  run.source = device.Source();
  std::unique_ptr<tracking::PoseSource> poses;
  try {
    TrackSequence(args, spec, device, poses, followed);
  } catch (const std::exception& error) {
    if (LivePoses(run) == 0) throw;
    run.failure = fmt::format("frame {}: {}", run.frames.size(), error.what());
  }
  const bool lost = device.State() == acquisition::DeviceState::kLost;
  device.Stop();
  if (!poses)
    throw Error("{}: no frame came; {}", args.uri,
                lost ? "the device was lost" : "check that it delivers images");
  if (lost) spdlog::warn("{}: the device was lost after {}", args.uri, Counted(run.frames.size(), "frame"));
  try {
    poses->Finish();
  } catch (const std::exception& error) {
    if (run.failure.empty()) run.failure = fmt::format("the last adjustment: {}", error.what());
  }
  for (TrackedFrame& sample : run.frames) {
    sample.final_cam_from_world = poses->PoseNow(sample.track);
    sample.final_map = poses->MapNow(sample.track);
  }
  run.map = poses->Statistics();
  run.from_outside = poses->Counts();
  return followed;
}

// Returns "poses.txt", for number 2 "poses.map2.txt".
std::filesystem::path EarlierMapFile(const std::filesystem::path& file, std::size_t number) {
  return file.parent_path() /
         fmt::format("{}.map{}{}", file.stem().string(), number, file.extension().string());
}

// Writes the last map's poses; those of discarded or separate maps lie in other worlds and get files of their
// own.
void WritePoses(const TrackRun& run, const std::string& path, std::vector<TimedPose> GivenPoses::*which) {
  if (path.empty()) return;
  const std::vector<GivenPoses> maps = PosesOfMaps(run);
  WriteTum(path, maps.empty() ? std::vector<TimedPose>() : maps.back().*which);
  for (std::size_t i = 0; i + 1 < maps.size(); ++i) {
    if ((maps[i].*which).empty()) continue;
    const std::filesystem::path file = EarlierMapFile(path, i + 1);
    WriteTum(file, maps[i].*which);
    spdlog::warn("{}: {} of another map, which nothing joins to the last one: in a world of its own",
                 file.string(), Counted((maps[i].*which).size(), "pose"));
  }
}

int RunTrack(const TrackArgs& args) {
  RequireUsable(args.lens);
  for (const std::string& output : {args.output, args.final_output, args.table})
    if (!output.empty()) RequireWritable(output);
  const tracking::PosesSpec spec = tracking::PosesSpec::Parse(args.poses);
  spec.RequireFor(args.lens.use);
  const StopOnSignal signals;
  std::vector<TimedPose> truth;
  if (!args.truth.empty()) truth = ReadTum(args.truth);
  // OpenCV would use all processors for a single frame; the other threads need them.
  cv::setNumThreads(1);
  std::string uri = args.uri;
  if (args.fps > 0) uri += fmt::format("{}fps={}", uri.find('?') == std::string::npos ? '?' : '&', args.fps);
  const auto device = acquisition::OpenDevice(acquisition::WithReplaySpeed(uri, args.speed));
  const auto [run, known] = Follow(args, spec, *device);
  // Print the report even when a file cannot be written.
  std::vector<std::string> unwritten;
  for (const auto& [path, which] :
       {std::pair(&args.output, &GivenPoses::live), {&args.final_output, &GivenPoses::final}})
    try {
      WritePoses(run, *path, which);
    } catch (const Error& error) {
      unwritten.push_back(error.what());
    }
  // Without a file, compare with the device's own poses, if it knows them.
  std::optional<TrackErrors> errors;
  if (!args.truth.empty())
    errors = CompareWithTruth(run, truth, args.truth);
  else if (!known.empty())
    errors = CompareWithTruth(run, known, "the device's own poses");
  const TrackErrors* compared = errors ? &*errors : nullptr;
  if (args.json) {
    nlohmann::ordered_json json = ToJson(run, compared);
    if (args.explain) AddExplained(json, Explained(run));
    fmt::print("{}\n", JsonText(json, 2));
  } else {
    fmt::print("{}", ToText(run, compared));
    if (args.explain) fmt::print("{}", ExplainedText(Explained(run)));
  }
  std::fflush(stdout);
  WriteFoundLens(args.lens, *device, run.map.refined_lens, run.map.calibration, "ulf track");
  if (!args.table.empty()) WriteFileAtomically(args.table, ToCsv(run, compared));
  if (!unwritten.empty()) throw Error("{}", fmt::join(unwritten, "; "));
  if (!run.failure.empty())
    throw Error("{}: {}; {} until then were kept", args.uri, run.failure, Counted(LivePoses(run), "pose"));
  return LivePoses(run) == 0 ? kFailed : kOk;
}

}  // namespace

void AddTrackCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "track", "Camera poses of a sequence or a live camera, without recording", RunTrack);
  command->add_option("URI", args->uri,
                      "Device: replay:PATH, sim:studio, aravis:ID; none: the first real camera");
  command->add_option("-o,--output", args->output,
                      "Poses as given live, TUM format (camera to world); those of maps that were given up "
                      "or are apart beside it (poses.map1.txt)");
  command->add_option("--final", args->final_output, "Poses after the run's last adjustment, TUM format");
  command->add_option(
      "--truth", args->truth,
      "True poses, TUM format: prints the error (default: the device's own poses, where it has them)");
  command->add_option("--table", args->table,
                      "CSV file to write: quality, map points found and errors, a line for each frame");
  command
      ->add_option("--calibration", args->calibration,
                   "Intrinsics, a file of ulf calibrate (default: the device's own, where it has some)")
      ->check(CLI::ExistingFile);
  command->add_option("--focal-px", args->focal_px, "Focal length where nothing better is known")
      ->check(Positive());
  OfferValues(command->add_option("--poses", args->poses, tracking::kPosesHelp), tracking::kPosesValues)
      ->capture_default_str();
  AddReadoutOption(*command, args->readout);
  AddLensUseOptions(*command, args->lens);
  command
      ->add_option("--fps", args->fps,
                   "Frame rate of a replayed folder (default: the one that its files tell)")
      ->check(Positive());
  command
      ->add_option(
          "--speed", args->speed,
          "Speed of a recording: 1 for real time, N for N times as fast; none or 0: as fast as possible")
      ->check(NonNegative());
  command->add_option("--frames", args->frames, "Stop after this many frames")->check(Positive());
  command->add_option("--features", args->features, "Features per frame")
      ->check(CLI::Range(200, 5000))
      ->capture_default_str();
  AddTrackingSideOption(*command, args->tracking_side_px);
  command->add_option("--seed", args->seed, "Seed of every random draw")->capture_default_str();
  command->add_flag("--deterministic", args->deterministic, "One thread, same result every time");
  command->add_flag("--benchmark", args->benchmark,
                    "Also time cv::ORB with 1000 features on the same frames");
  command->add_flag("--explain", args->explain,
                    "Say why the map started from its model, and what it kept of what it made");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf track 'replay:kitchen?glob=*.color.jpg' --calibration intrinsics.txt -o poses.txt "
      "--truth reference.txt --table run.csv\nSIGINT ends the run of a live camera: the program writes the "
      "poses and prints the report.");
}

}  // namespace ulf::commands
