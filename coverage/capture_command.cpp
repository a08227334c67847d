// ulf capture: the main job, from a device's URI to a light field on disk.
#include "coverage/capture_command.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/calibration/intrinsics_options.h"
#include "acquisition/counted.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/frame_recording.h"
#include "acquisition/import_export.h"
#include "acquisition/light_field_io.h"
#include "acquisition/number_checks.h"
#include "acquisition/output_path.h"
#include "acquisition/replay_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "acquisition/stop_signal.h"
#include "coverage/capture_report.h"
#include "coverage/capture_session.h"
#include "coverage/capture_start.h"
#include "coverage/coverage_drawing.h"
#include "coverage/light_field_report.h"
#include "coverage/map_cache.h"
#include "coverage/operator/run_with_display.h"
#include "coverage/pose_errors.h"
#include "coverage/request_lines.h"
#include "coverage/simulated_operator.h"
#include "tracking/marker_spec.h"
#include "tracking/readout_option.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

struct CaptureArgs {
  std::string uri;
  std::string dir;
  std::string subject = "auto";
  double subject_size = 0.28;
  std::string until_covered;
  std::string quality;
  std::optional<double> threshold_px;
  std::optional<int> coverage_width_px;
  IntrinsicsArgs intrinsics;
  std::string poses_text = "features";
  ReadoutArgs readout;
  PosesSpec poses;
  std::uint64_t frames = 0;
  double max_seconds = 0;
  std::optional<double> speed;
  std::string keep_frames;
  std::string person;
  std::string requests;
  bool headless = false;
  std::string marker;
  bool deterministic = false;
  bool resume = false;
  bool raw = false;
  bool json = false;
  std::string overlay;
  std::string map;
  std::string truth;
};

// "60x40", "60x40:0.95" or "60x40:95%".
void ParseUntilCovered(const std::string& text, CaptureOptions* options) {
  if (text.empty()) return;
  const std::size_t colon = text.find(':');
  options->cap = Cap::ParseDegrees(text.substr(0, colon));
  if (colon == std::string::npos) return;
  const std::string share = text.substr(colon + 1);
  double value = 0;
  int used = 0;
  if (std::sscanf(share.c_str(), "%lf%n", &value, &used) == 1) {
    const std::string rest = share.substr(static_cast<std::size_t>(used));
    if (rest == "%") value /= 100;
    if ((rest.empty() || rest == "%") && value > 0 && value <= 1) {
      options->until_share = value;
      return;
    }
  }
  throw UsageError("--until-covered {}: '{}' is not a share; write 0.95 or 95%", text, share);
}

CaptureOptions OptionsFrom(const CaptureArgs& args) {
  CaptureOptions options;
  ParseUntilCovered(args.until_covered, &options);
  if (!args.quality.empty() && args.threshold_px)
    throw UsageError("--quality {} and --threshold-px {} say the same thing twice; give one", args.quality,
                     *args.threshold_px);
  if (args.quality == "fast") options.threshold_px = 12;
  if (args.threshold_px) options.threshold_px = *args.threshold_px;
  if (!(options.threshold_px > 2))
    throw UsageError("--threshold-px {}: the bound of a view with itself is 2 px; give more",
                     options.threshold_px);
  if (args.coverage_width_px) options.coverage_width_px = *args.coverage_width_px;
  if (options.coverage_width_px < 16)
    throw UsageError("--coverage-width {} is not the width of an image", options.coverage_width_px);
  if (!(args.subject_size > 0 && args.subject_size <= 0.8))
    throw UsageError(
        "--subject-size {}: the sphere's share of the image's width, above 0 and at most 0.8 (the "
        "safety rectangle)",
        args.subject_size);
  options.subject_size = args.subject_size;
  options.deterministic = args.deterministic;
  options.max_frames = args.frames;
  options.max_seconds = args.max_seconds;
  if (args.subject != "auto") {
    if (!args.poses.HaveAWorld() && !args.resume)
      throw UsageError(
          "--subject {}: the tracker's world does not exist before it has begun; use --subject auto, go on "
          "with a "
          "light field (--resume), or take poses whose world is known (--poses known, markers:, tum:, tcp:)",
          args.subject);
    options.subject = ParseSubject(args.subject);
  }
  return options;
}

// With known poses there are no tracked points to find the subject by: a replayed light field has one.
std::optional<Subject> SubjectOfReplay(const std::string& uri) {
  const DeviceUri parsed = DeviceUri::Parse(uri);
  const fs::path dir = parsed.path;
  if (parsed.scheme != "replay" ||
      !(fs::exists(dir / "journal.jsonl") || fs::exists(dir / "transforms.json")))
    return std::nullopt;
  const LightField light_field = ReadLightField(dir);
  return light_field.subject ? light_field.subject : SubjectFromAxes(light_field);
}

struct Prepared {
  std::unique_ptr<Device> device;
  std::shared_ptr<SimulatedOperator> person;  // who holds a simulated camera, if anybody
  std::vector<Frame> first;                   // what came until the first live frame, which is the last
  CameraModel camera;                         // of live frames
  RecordingHeader recording;                  // what --keep-frames says of the session
  std::unique_ptr<PoseSource> poses;
  std::unique_ptr<LightFieldWriter> writer;
};

CameraModel CameraOfResumed(const LightField& light_field, const Frame& frame) {
  const CameraModel& camera = light_field.cameras.at(0);
  if (camera.width != frame.image.width() || camera.height != frame.image.height())
    throw Error(
        "{}: was captured at {}x{}, the device now gives {}x{}; set it back or begin a new light field",
        light_field.root.string(), camera.width, camera.height, frame.image.width(), frame.image.height());
  return camera;
}

std::optional<FlatField> FlatFieldOfResumed(const LightField& light_field) {
  const auto found = light_field.flat_fields.find(0);
  return found == light_field.flat_fields.end() ? std::nullopt : std::optional(found->second);
}

void TakeOver(const CaptureArgs& args, const LightField& light_field, CaptureOptions* options) {
  if (!args.threshold_px && args.quality.empty() && light_field.threshold_px)
    options->threshold_px = *light_field.threshold_px;
  if (light_field.threshold_px && options->threshold_px != *light_field.threshold_px)
    throw UsageError("{}: was begun with a threshold of {} px; leave out --threshold-px and --quality",
                     args.dir, *light_field.threshold_px);
  if (args.coverage_width_px && *args.coverage_width_px != light_field.coverage_width_px)
    throw UsageError("{}: was begun with --coverage-width {}; leave it out", args.dir,
                     light_field.coverage_width_px);
  options->coverage_width_px = light_field.coverage_width_px;
}

// Poses of one camera and intrinsics of another make no light field.
void RequireSameCamera(const std::string& dir, const LightField& recorded, const DeviceInfo& info) {
  if (recorded.device_serial.empty() || info.serial.empty() || recorded.device_serial == info.serial) return;
  throw Error(
      "{}: was recorded with {} (serial number {}), this is {} ({}); go on with that camera, or begin a new "
      "light field with this one",
      dir, recorded.device_model.empty() ? "another camera" : recorded.device_model, recorded.device_serial,
      info.model, info.serial);
}

// False when a signal came before the first frame: then nothing has been written.
bool Prepare(const CaptureArgs& args, CaptureOptions* options, Prepared& prepared) {
  if (args.resume) {
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Resume(args.dir));
    TakeOver(args, prepared.writer->Contents(), options);
    if (!options->subject) options->subject = prepared.writer->Contents().subject;
  }
  if (args.poses.AreGiven() && !options->subject) {
    if (args.poses.ComeWithFrames()) options->subject = SubjectOfReplay(args.uri);
    if (!options->subject)
      throw UsageError(
          "--poses {}: there are no tracked points to find the subject by; give --subject x,y,z,r",
          args.poses.Text());
  }
  const bool own_world = args.poses.HaveAWorld() && !args.poses.ComeWithFrames();
  if (args.resume && own_world && prepared.writer->Contents().units != "metres")
    throw UsageError(
        "{}: its unit is arbitrary, the world of --poses {} is in metres; begin a new light field", args.dir,
        args.poses.Text());
  if (args.resume && args.poses.WorldIsChosenAnew())
    throw UsageError(
        "{}: of several markers the first that is seen is the world, and now it could be another one; go on "
        "with --poses features, or name the marker that was the first (the end of that session said which): "
        "--poses {}:NUMBER",
        args.dir, args.poses.Text());
  if (args.person.empty()) {
    prepared.device = OpenDevice(WithReplaySpeed(args.uri, args.speed));
  } else {
    const DeviceUri uri = DeviceUri::Parse(args.uri);
    prepared.person = OperatorBefore(uri, args.person);
    prepared.device = OpenSimulatedDevice(uri, prepared.person);
  }
  prepared.device->Start();
  if (!TakeFirstFrames(*prepared.device, args.uri, StopOnSignal::Asked, prepared.first)) return false;
  const Frame& first = prepared.first.back();

  CaptureHeader header;
  const bool stills = prepared.device->TakesStills();
  const auto use = [&header](const ResolvedCalibration& calibration) {
    for (const std::string& warning : calibration.warnings) spdlog::warn("{}", warning);
    header.calibration_source = calibration.source;
    header.flat_field = calibration.flat_field;
    return calibration.camera;
  };
  RecordingHeader& recording = prepared.recording = RecordingHeader::Of(*prepared.device);
  if (args.resume) {
    RequireSameCamera(args.dir, prepared.writer->Contents(), prepared.device->Info());
    header.flat_field = FlatFieldOfResumed(prepared.writer->Contents());
  }
  if (args.resume && !stills)
    prepared.camera = CameraOfResumed(prepared.writer->Contents(), first);
  else
    prepared.camera =
        use(ResolveCalibration(*prepared.device, args.intrinsics, first.image.width(), first.image.height()));
  options->calibration_source =
      args.resume && !stills ? prepared.writer->Contents().calibration_source : header.calibration_source;
  if (!options->calibration_source.empty())
    options->calibrated = options->calibration_source != kFocalLengthGiven;
  recording.camera = prepared.camera;
  recording.flat_field = header.flat_field;
  if (stills) {
    options->still_camera = args.resume ? prepared.writer->Contents().cameras.at(0)
                                        : use(ResolveStillCamera(*prepared.device, args.intrinsics));
    recording.still_camera = options->still_camera;
    recording.still_flat_field =
        args.resume ? FlatFieldOfResumed(prepared.writer->Contents()) : header.flat_field;
  }
  const DeviceInfo info = prepared.device->Info();
  if (args.poses.ComeWithFrames() && !first.known_cam_from_world)
    throw UsageError("--poses known: {} does not know its poses; leave it out to have them tracked",
                     info.uri);
  prepared.poses = args.poses.Open(prepared.camera,
                                   {.tracker = {.deterministic = args.deterministic,
                                                .wait_for_mapper = !prepared.device->IsLive(),
                                                .readout_s = args.readout.readout_s,
                                                .compensate_found_readout = args.readout.compensate_found},
                                    .subject = options->subject,
                                    .metric = info.bus == "simulated",
                                    .stop = StopOnSignal::Asked});
  if (args.poses.UseFeatures() && args.resume && !prepared.writer->Contents().views.empty())
    RestoreOrSeedMap(prepared.writer->Contents(), prepared.camera, *prepared.poses);
  if (!prepared.writer) {
    header.camera = options->still_camera.value_or(prepared.camera);
    header.device_uri = info.uri;
    header.device_serial = info.serial;
    header.device_maker = info.maker;
    header.device_model = info.model;
    if (!stills) header.window = prepared.device->Window();
    header.units = prepared.poses->IsMetric() ? "metres" : "arbitrary";
    header.threshold_px = options->threshold_px;
    header.coverage_width_px = options->coverage_width_px;
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Create(args.dir, header));
  }
  prepared.writer->KeepMosaics(args.raw);
  if (args.raw && first.image.mosaic == Mosaic::kNone)
    spdlog::warn("--raw: the frames of {} are no mosaic, their masters are written as without it", args.uri);
  return true;
}

// What the camera gave before it came to a capture is kept.
bool PrepareOrKeep(const CaptureArgs& args, CaptureOptions* options, Prepared& prepared) {
  bool ready = false;
  const auto keep = [&] {
    if (prepared.device) KeepPhotographs(*prepared.device, prepared.first, prepared.writer.get(), args.dir);
  };
  try {
    ready = Prepare(args, options, prepared);
  } catch (...) {
    keep();
    throw;
  }
  if (!ready) keep();
  return ready;
}

void WritePicture(const std::string& path, const cv::Mat& picture) {
  bool written = false;
  try {
    written = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {
  }
  if (!written) throw Error("{}: the picture cannot be written; give a path ending in .png or .jpg", path);
}

void WritePictures(const CaptureArgs& args, const CameraModel& camera, const CaptureSummary& summary,
                   const LightFieldReport& report) {
  if (args.overlay.empty() && args.map.empty()) return;
  if (!summary.map || summary.map->views().empty() || !summary.last_recorded) {
    fmt::print(stderr, "nothing was recorded: no pictures are drawn\n");
    return;
  }
  const Rigid3& cam_from_world = summary.last_recorded->cam_from_world;
  const CoverageMap map = RefinedForPictures(*summary.map);
  if (!args.overlay.empty()) {
    // Lines and dots want pixels: small images are drawn on at twice their size.
    constexpr int kWideEnough = 1000;
    const int factor = camera.width < kWideEnough ? 2 : 1;
    const CameraModel large = camera.ScaledTo(factor * camera.width, factor * camera.height);
    cv::Mat live;
    cv::resize(Srgb8(summary.last_recorded->frame.image), live, {large.width, large.height}, 0, 0,
               cv::INTER_CUBIC);
    WritePicture(args.overlay, DrawOverlay(live, large, cam_from_world, map));
  }
  if (args.map.empty()) return;
  std::string caption = fmt::format("{}, within {:g} px", Counted(report.views, "view"), report.threshold_px);
  if (report.covered) caption = fmt::format("{:.1f} % covered, ", 100 * *report.covered) + caption;
  WritePicture(args.map, DrawCoverageMap(map, {.cam_from_world = cam_from_world, .caption = caption}));
}

void PrintResult(const CaptureArgs& args, const CaptureSummary& summary, const LightFieldReport& report,
                 std::size_t tracked, const std::optional<PoseErrors>& errors) {
  if (args.json) {
    nlohmann::json json = ToJson(report);
    AddTo(json, summary, tracked);
    if (errors) AddTo(json, *errors);
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print("{}{}{}", ToText(report), ToText(summary, tracked), errors ? ToText(*errors) : "");
  }
  std::fflush(stdout);
}

// The larger share of what the capture may end by; the device's own where nothing was asked for.
double ShareDone(const CaptureArgs& args, const CaptureOptions& options, const CaptureState& now,
                 double first_time_s, const Device& device) {
  double share = 0;
  if (now.covered) share = *now.covered / options.until_share;
  if (args.frames > 0)
    share = std::max(share, static_cast<double>(now.frames) / static_cast<double>(args.frames));
  if (args.max_seconds > 0) share = std::max(share, (now.device_time_s - first_time_s) / args.max_seconds);
  if (!now.covered && args.frames == 0 && args.max_seconds == 0) share = device.ShareDone().value_or(0);
  return std::min(0.99, share);
}

std::string ProgressLine(const CaptureState& now) {
  const std::string covered = now.covered ? fmt::format(", {:.1f} % covered", 100 * *now.covered) : "";
  std::string what = InWords(now.decision.reason);
  if (!now.waiting_for.empty())
    what = "waiting for " + now.waiting_for;
  else if (!now.tracking_words.empty())
    what = now.tracking_words;
  return fmt::format("{}, {} recorded{}; {}", Counted(now.frames, "frame"), now.view_ids.size(), covered,
                     what);
}

// Before anything else is read or written there.
void SayWhatTheDiskRefused(const CaptureSummary& summary) {
  if (summary.stopped_because != StoppedBecause::kDisk) return;
  fmt::print(stderr, "ulf: {}\nulf: what was written before is whole; go on with --resume\n",
             summary.problem);
  for (const auto& [folder, count] : summary.set_aside)
    fmt::print(stderr, "ulf: {} taken by then: kept in {}\n", Counted(count, "frame"), folder.string());
  if (summary.unwritten > 0)
    fmt::print(stderr, "ulf: {} taken by then could not be written anywhere\n",
               Counted(summary.unwritten, "frame"));
}

int RunCaptureCommand(const CaptureArgs& args) {
  CaptureOptions options = OptionsFrom(args);
  if (!args.marker.empty()) MarkerSpec::Parse(args.marker);
  for (const std::string& picture : {args.overlay, args.map})
    if (!picture.empty()) RequireWritablePicture(picture);
  if (!args.keep_frames.empty()) RequireNewRecording(args.keep_frames);
  const StopOnSignal signals;
  Prepared prepared;
  if (!PrepareOrKeep(args, &options, prepared)) {
    fmt::print(stderr, "stopped before the first frame: no light field was written\n");
    return kOk;
  }

  CaptureSummary summary;
  FrameRecorderSummary kept;
  std::vector<TimedPose> live;
  {
    Progress progress("capture");
    const double first_time_s = prepared.first.back().device_time_s;
    double shown_share = 0;  // a pose that is corrected may open the cap again, but the bar goes one way
    CaptureHooks hooks;
    hooks.say = [&](const std::string& line) { progress.Say(line); };
    hooks.stop_requested = [] { return StopOnSignal::Asked(); };
    CaptureRequests requests;
    std::optional<RequestLines> request_lines;
    if (!args.requests.empty()) request_lines.emplace(args.requests);
    hooks.requests = &requests;
    const auto read_requests = [&] {
      if (request_lines) request_lines->Take(requests, hooks.say);
    };
    CaptureFeed feed;
    hooks.while_waiting = [&](const SharedCaptureState& now) {
      read_requests();
      feed.Publish(now);
      if (!now->waiting_for.empty()) progress.Show(shown_share, ProgressLine(*now));
    };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      read_requests();
      feed.Publish(now);
      if (prepared.person) prepared.person->See(now);
      if (now->cam_from_world) live.push_back({now->device_time_s, *now->cam_from_world});
      shown_share = std::max(shown_share, ShareDone(args, options, *now, first_time_s, *prepared.device));
      progress.Show(shown_share, ProgressLine(*now));
    };
    std::unique_ptr<FrameRecorder> recorder;
    if (!args.keep_frames.empty()) {
      recorder = std::make_unique<FrameRecorder>(args.keep_frames, prepared.recording);
      hooks.keep_frame = [&](const Frame& frame) { recorder->TryAdd(frame); };
      hooks.say = [&](const std::string& line) {
        progress.Say(line);
        recorder->Note(line);
      };
    }
    const auto capture = [&] {
      summary = RunCapture(*prepared.device, prepared.camera, *prepared.poses, std::move(*prepared.writer),
                           options, hooks, std::move(prepared.first));
    };
    RunWithDisplay(
        args.headless ? DisplayDoor{} : [] { return OpenWindow("ulf capture", {1280, 720}); },
        {.marker = args.marker}, feed, requests, capture);
    if (recorder) kept = recorder->Finish();
  }
  if (kept.left_out > 0)
    fmt::print(stderr, "{}: {} of {} frames are not in the recording: {}\n", args.keep_frames, kept.left_out,
               kept.left_out + kept.written, kept.problem);
  SayWhatTheDiskRefused(summary);
  const LightField light_field = ReadLightField(args.dir);
  if (summary.stopped_because != StoppedBecause::kDisk && !light_field.views.empty())
    SaveMapCache(light_field, prepared.camera, *prepared.poses);
  const LightFieldReport report =
      Describe(light_field, {.cap = options.cap, .threshold_px = options.threshold_px});
  std::optional<PoseErrors> errors;
  if (!args.truth.empty()) errors = CompareWithTruth(args.truth, live, light_field);
  PrintResult(args, summary, report, live.size(), errors);
  WritePictures(args, options.still_camera.value_or(prepared.camera), summary, report);
  if (summary.stopped_because == StoppedBecause::kCovered && report.covered < options.until_share)
    fmt::print(
        stderr,
        "the last adjustment of the poses opened some of the cap again; go on with --resume to fill it\n");
  if (summary.stopped_because == StoppedBecause::kDisk) return kFailed;
  if (summary.stopped_because == StoppedBecause::kDeviceLost) {
    fmt::print(stderr,
               "ulf: {}: the device no longer answers; the light field is closed, go on with --resume\n",
               args.uri);
    return kFailed;
  }
  const bool was_asked_to_end = summary.stopped_because == StoppedBecause::kSignal ||
                                summary.stopped_because == StoppedBecause::kClosed;
  if (report.views == 0 && !was_asked_to_end) {
    fmt::print(stderr, "ulf: {}\n", NothingRecorded(summary, live.size()));
    return kFailed;
  }
  return kOk;
}

}  // namespace

void AddCaptureCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<CaptureArgs>();
  CLI::App* command =
      app.add_subcommand("capture", "Captures a light field: records every view that is missing");
  command->add_option("URI", args->uri, "Device (see 'ulf devices'); none: the first real camera");
  command->add_option("-o,--output", args->dir, "Folder of the light field")->required();
  command->add_option("--subject", args->subject, "auto, or x,y,z,radius in world units")
      ->capture_default_str();
  command->add_option("--subject-size", args->subject_size, "auto: the sphere's share of the image's width")
      ->capture_default_str();
  command->add_option("--until-covered", args->until_covered,
                      "Stop when this cap is covered, degrees: 60x40, 60x40:95% (98 % if not said)");
  command->add_option("--quality", args->quality, "high: 7 px (as without), fast: 12 px")
      ->check(CLI::IsMember({"high", "fast"}));
  command->add_option("--threshold-px", args->threshold_px, "Reprojection error allowed");
  command->add_option("--coverage-width", args->coverage_width_px,
                      "Width of the image that the threshold refers to (640)");
  AddIntrinsicsOptions(*command, args->intrinsics);
  command->add_option("--poses", args->poses_text, kPosesHelp)->capture_default_str();
  AddReadoutOption(*command, args->readout);
  command->add_option("--frames", args->frames, "Stop after so many frames")->check(Positive());
  command->add_option("--max-seconds", args->max_seconds, "Stop after so long, by the device's clock")
      ->check(Positive());
  command
      ->add_option("--speed", args->speed,
                   "Of a recording: 1 in time, N faster; none or 0: as fast as it goes")
      ->check(NonNegative());
  command->add_option("--keep-frames", args->keep_frames,
                      "New folder for every frame: the session can be run again, replay:FOLDER");
  command->add_option(
      "--requests", args->requests,
      "Lines to be answered while it runs, from this file or fifo (-: standard input): take-back "
      "[COUNT], take-back views ID..., subject [x,y,z,r], subject [depth D] [size SHARE], pause, "
      "record, finish");
  command->add_option(
      "--operator", args->person,
      "Of a simulated scene: who holds the camera, in place of a hand that scans by a plan: guided, "
      "unguided, novice or unguided-novice, with a seed if wanted, novice:7 (docs/guidance.md)");
  command->add_flag("--headless", args->headless, "Without the operator display");
  command->add_option(
      "--marker", args->marker,
      "Held before the camera to look round in the display's review: marker:80:DICT_4X4_50:0");
  command->add_flag("--deterministic", args->deterministic,
                    "One thread; the same frames give the same bytes");
  command->add_flag("--resume", args->resume, "Go on with the light field in the folder");
  command->add_flag("--raw", args->raw,
                    "A mosaic camera's masters are the mosaics themselves, not their 16-bit colours");
  command->add_option("--overlay", args->overlay, "Picture: the last recorded frame with the painted sphere");
  command->add_option("--map", args->map, "Picture: the coverage map");
  command
      ->add_option("--truth", args->truth,
                   "True poses (TUM, device times), read at the end: prints the tracker's error")
      ->check(CLI::ExistingFile);
  command->add_flag("--json", args->json, "One JSON object");
  command->footer(
      "Example: ulf capture sim:studio -o studio --headless --until-covered 60x40 --quality fast");
  command->callback([args, &chosen] {
    chosen = [args] {
      args->poses = PosesSpec::Parse(args->poses_text);
      return RunCaptureCommand(*args);
    };
  });
}

}  // namespace ulf
