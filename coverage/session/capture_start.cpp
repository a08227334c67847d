#include "coverage/session/capture_start.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "acquisition/device/repeated_events.h"
#include "acquisition/device/replay_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/stop_signal.h"
#include "coverage/session/record/kept_photographs.h"
#include "coverage/session/record/map_cache.h"
#include "coverage/session/session_lenses.h"

namespace ulf::coverage {
namespace fs = std::filesystem;
namespace {

// "60x40", "60x40:0.95", "60x40:95%" or "none".
void ParseUntilCovered(const std::string& text, CaptureOptions* options) {
  if (text.empty() || text == "none") return;
  const CapGoal goal = CapGoal::Parse(text);
  options->cap = goal.cap;
  if (goal.share) options->until_share = *goal.share;
}

// Refuses options that need the subject's sphere.
PhotographSpacing SpacingWithoutSubject(const CaptureArgs& args) {
  const CaptureArgs usual;
  const auto refuse = [](bool given, const char* option) {
    if (given)
      throw UsageError("--no-subject and {}: {} needs a subject to go round; leave out one of the two",
                       option, option);
  };
  refuse(!args.until_covered.empty() && args.until_covered != "none", "--until-covered");
  refuse(args.subject != usual.subject, "--subject");
  refuse(args.subject_size != usual.subject_size, "--subject-size");
  refuse(!args.quality.empty(), "--quality");
  refuse(args.threshold_px.has_value(), "--threshold-px");
  refuse(args.coverage_width_px.has_value(), "--coverage-width");
  refuse(!args.person.empty(), "--operator");
  refuse(!args.overlay.empty(), "--overlay");
  refuse(!args.map.empty(), "--map");
  refuse(args.cover != Name(CoverBy::kBound), "--cover");
  refuse(!args.error_map.empty(), "--error-map");
  if (!args.poses.UseFeatures())
    throw UsageError(
        "--no-subject and --poses {}: without a subject, tracked points tell how much a view adds, and these "
        "poses have none; leave out --poses, or give --subject x,y,z,radius in place of --no-subject",
        args.poses.Text());
  PhotographSpacing spacing;
  if (args.parallax_deg) spacing.parallax_deg = *args.parallax_deg;
  return spacing;
}

// What a turntable cannot be captured with.
void RequireForTurntable(const CaptureArgs& args) {
  if (args.turntable.empty()) return;
  if (args.no_subject)
    throw UsageError("--turntable and --no-subject: what turns is the subject; leave out one of the two");
  if (args.cover != Name(CoverBy::kBound) || !args.error_map.empty())
    throw UsageError(
        "--turntable {}: errors are measured while the background is not masked yet; leave out --cover and "
        "--error-map",
        args.turntable);
}

}  // namespace

tracking::PosesSpec PosesFrom(const CaptureArgs& args) {
  if (args.turntable.empty()) return tracking::PosesSpec::Parse(args.poses_text);
  if (const CaptureArgs usual; args.poses_text != usual.poses_text)
    throw UsageError(
        "--turntable {0} and --poses {1}: the poses are the camera's about the board that turns; leave out "
        "--poses",
        args.turntable, args.poses_text);
  tracking::PosesSpec poses = tracking::PosesSpec::Parse("markers:" + args.turntable);
  if (poses.ChoosesWorldAnew())
    throw UsageError(
        "--turntable {}: of several markers the first that is seen would be the world; give a board "
        "(charuco:5x5:54:40:DICT_4X4_50) or one marker's number ({}:0)",
        args.turntable, args.turntable);
  return poses;
}

CaptureOptions OptionsFrom(const CaptureArgs& args) {
  CaptureOptions options;
  RequireForTurntable(args);
  if (!args.turntable.empty()) options.turntable = args.poses.markers();
  if (args.parallax_deg && !args.no_subject)
    throw UsageError(
        "--parallax-deg {:g}: is the spacing of photographs without a subject; give --no-subject, too, or "
        "--quality or --threshold-px in its place",
        *args.parallax_deg);
  if (args.no_subject) options.without_subject = SpacingWithoutSubject(args);
  options.keep_apart = args.keep_apart;
  if (!args.bracket.empty()) options.bracket = ExposureBracket::Parse(args.bracket);
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
  if (!(args.subject_size > 0 && args.subject_size <= options.limits.rectangle_share))
    throw UsageError(
        "--subject-size {}: the sphere's share of the image's width, above 0 and at most {} (the "
        "safety rectangle)",
        args.subject_size, options.limits.rectangle_share);
  options.subject_size = args.subject_size;
  options.deterministic = args.deterministic;
  options.begins_on_request = !args.headless;
  options.checks_hold_start = !args.force_start;
  // Of a turntable it is made when the background is masked.
  options.geometry = !args.no_geometry && args.turntable.empty();
  options.cover = CoverGoal::Parse(args.cover);
  if (options.cover.by != CoverBy::kBound && args.no_geometry)
    throw UsageError("--cover {} and --no-geometry: errors are measured over the geometry; leave one out",
                     args.cover);
  if (!args.error_map.empty() && args.no_geometry)
    throw UsageError("--error-map and --no-geometry: errors are measured over the geometry; leave one out");
  options.max_frames = args.frames;
  options.max_seconds = args.max_seconds;
  if (args.subject != "auto") {
    if (!args.poses.HaveAWorld() && !args.resume)
      throw UsageError(
          "--subject {}: the tracker has no world before it starts; use --subject auto, go on with a light "
          "field (--resume), or take poses whose world is known (--poses known, markers:, tum:, tcp:)",
          args.subject);
    options.subject = ParseSubject(args.subject);
  }
  return options;
}

bool TakeFirstFrames(acquisition::Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken) {
  constexpr std::chrono::seconds kPatience(10);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  acquisition::RepeatedEvents repeated;
  while (std::chrono::steady_clock::now() < until && !stop()) {
    auto frame = device.Next(std::chrono::milliseconds(200));
    for (const std::string& line : repeated.After(device.TakeEvents(), EpochSeconds()))
      fmt::print(stderr, "{}\n", line);
    if (!frame) acquisition::RequireLiveFrames(device);
    if (!frame && acquisition::IsOver(device.State())) break;
    if (!frame) continue;
    const bool live = frame->kind == FrameKind::kLive;
    if (live && frame->status != FrameStatus::kComplete) continue;  // the device counts them
    taken.push_back(std::move(*frame));
    if (live) return true;
  }
  if (stop()) return false;
  if (IsTaken(device.Source())) throw Error("{}: not one picture of it is complete; give another one", uri);
  throw Error("{}: the device gave no complete frame; 'ulf devices' shows what is known about it", uri);
}

void KeepPhotographs(acquisition::Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const fs::path& dir) {
  std::vector<Frame> photographs;
  for (const Frame& frame : taken)
    if (frame.kind == FrameKind::kStill) photographs.push_back(frame);
  try {
    device.Stop();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());  // the photographs that came are kept all the same
  }
  try {
    while (auto frame = device.TakesStills() ? device.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) photographs.push_back(std::move(*frame));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
  if (photographs.empty() || !device.IsLive()) return;  // a recording still has its photographs
  std::map<fs::path, std::size_t> kept_in;
  std::size_t lost = 0;
  std::string problem;
  for (const Frame& photograph : photographs) {
    const auto folder = KeepAnywhere(writer, dir, photograph, problem);
    ++(folder ? kept_in[*folder] : lost);
  }
  for (const auto& [folder, count] : kept_in)
    fmt::print(stderr, "{} taken before the capture began: kept in {}\n", Counted(count, "photograph"),
               folder.string());
  if (lost > 0)
    fmt::print(stderr, "{} taken before the capture began: lost, nothing can be written: {}\n",
               Counted(lost, "photograph"), problem);
}

namespace {

// Known poses come without tracked points, by which a capture finds its subject; a replayed light field has one.
std::optional<Subject> SubjectOfReplay(const std::string& uri) {
  const DeviceUri parsed = DeviceUri::Parse(uri);
  const fs::path dir = parsed.path;
  if (parsed.scheme != "replay" ||
      !(fs::exists(dir / "journal.jsonl") || fs::exists(dir / "transforms.json")))
    return std::nullopt;
  const LightField light_field = ReadLightField(dir);
  return light_field.subject ? light_field.subject : SubjectFromAxes(light_field);
}

// What the light field tells and the command line does not; commands/capture/resume_options.h has compared the two.
void ResumeOptions(const CaptureArgs& args, const LightField& light_field, CaptureOptions* options) {
  if (args.no_subject) return;
  if (!light_field.subject && !light_field.views.empty() && args.subject == "auto")
    spdlog::info("{}: has no subject yet, this session looks for one (--no-subject: goes on without)",
                 args.dir);
  if (!args.threshold_px && args.quality.empty() && light_field.threshold_px)
    options->threshold_px = *light_field.threshold_px;
  options->coverage_width_px = light_field.coverage_width_px;
  if (args.until_covered.empty() && light_field.goal) {
    options->cap = Cap::FromDegrees(light_field.goal->cap_deg);
    options->until_share = light_field.goal->share;
    spdlog::info(
        "{}: goes on until {:g} % of {:g} x {:g} degrees are covered (--until-covered none: until stopped)",
        args.dir, 100 * light_field.goal->share, light_field.goal->cap_deg.x(),
        light_field.goal->cap_deg.y());
  }
}

// Poses of one camera and intrinsics of another make no light field.
void RequireSameCamera(const std::string& dir, const LightField& recorded,
                       const acquisition::DeviceInfo& info) {
  if (recorded.device_serial.empty() || info.serial.empty() || recorded.device_serial == info.serial) return;
  throw Error(
      "{}: was recorded with {} (serial number {}), this is {} ({}); go on with that camera, or begin a new "
      "light field with this one",
      dir, recorded.device_model.empty() ? "another camera" : recorded.device_model, recorded.device_serial,
      info.model, info.serial);
}

// The shutter of the sessions before, unless the user says something else.
tracking::ReadoutArgs ReadoutOf(const CaptureArgs& args, const LightField* resumed) {
  tracking::ReadoutArgs readout = args.readout;
  if (!resumed || !resumed->readout) return readout;
  const ShutterReadout& known = *resumed->readout;
  const double known_ms = 1000 * known.readout_s;
  if (readout.readout_s) {
    // As much as the tracker takes for a change, or five deviations of the measured one.
    const double apart_s = std::abs(*readout.readout_s - known.readout_s);
    if (apart_s >
        std::max(tracking::kSettledReadoutShare * std::abs(known.readout_s), 5 * known.sigma_s.value_or(0)))
      spdlog::warn("--readout-ms {:g}: the sessions before {} {:.1f} ms; {:g} is used",
                   1000 * *readout.readout_s, known.sigma_s ? "measured" : "were given", known_ms,
                   1000 * *readout.readout_s);
  } else if (readout.compensate_found) {
    readout.readout_s = known.readout_s;
    if (known.readout_s != 0)
      spdlog::info(
          "{}: rolling shutter of {:.1f} ms (of the sessions before): compensated from the first frame on",
          args.dir, known_ms);
  }
  return readout;
}

// Without its times exposures cannot be merged.
void RequireExposures(const acquisition::Device& device, const ExposureBracket& bracket, const Frame& first,
                      bool stills) {
  const std::string uri = device.Info().uri;
  if (device.TakesExposures() == acquisition::ExposureRequests::kNone)
    throw UsageError(
        "--bracket {}: {} cannot be asked for exposures: a recording, a camera without an exposure time that "
        "can be "
        "set, or one whose automatic exposure is on (auto_exposure=off); leave out --bracket",
        bracket.Text(), uri);
  if (!stills && first.exposure_s <= 0)
    throw UsageError(
        "--bracket {}: {} does not tell its exposure time, without which exposures cannot be merged; set "
        "it in the URI (exposure_us=5000), or leave out --bracket",
        bracket.Text(), uri);
}

bool Prepare(const CaptureArgs& args, CaptureOptions* options, PreparedCapture& prepared) {
  args.poses.RequireFor(args.lens);
  if (args.resume) {
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Resume(args.dir));
    ResumeOptions(args, prepared.writer->Contents(), options);
    if (!options->subject) options->subject = prepared.writer->Contents().subject;
  }
  const LightField* resumed = args.resume ? &prepared.writer->Contents() : nullptr;
  if (args.poses.AreGiven() && !options->subject) {
    if (args.poses.ComeWithFrames()) options->subject = SubjectOfReplay(args.uri);
    if (!options->subject)
      throw UsageError(
          "--poses {}: there are no tracked points to find the subject by; give --subject x,y,z,r",
          args.poses.Text());
  }
  options->lens = args.lens;
  if (args.person.empty()) {
    prepared.device = acquisition::OpenDevice(acquisition::WithReplaySpeed(args.uri, args.speed));
  } else {
    const DeviceUri uri = DeviceUri::Parse(args.uri);
    prepared.person = OperatorBefore(uri, args.person);
    prepared.device = acquisition::OpenSimulatedDevice(uri, prepared.person);
  }
  // A recording would run out while it waits.
  if (DeviceUri::Parse(args.uri).scheme == "replay") options->begins_on_request = false;
  prepared.device->Start();
  if (!TakeFirstFrames(*prepared.device, args.uri, StopOnSignal::Asked, prepared.first)) return false;
  const Frame& first = prepared.first.back();

  const bool stills = prepared.device->TakesStills();
  acquisition::IntrinsicsArgs intrinsics = args.intrinsics;
  if (args.lens == tracking::LensUse::kRefine) intrinsics.guessed_focal_px = acquisition::GuessFocalPx(first);
  if (stills && args.lens == tracking::LensUse::kRefine)
    throw UsageError(
        "--intrinsics refine: {0} records photographs, and live view does not tell their lens; find the lens "
        "of live "
        "view with ulf track {0} --intrinsics refine --calibration-out FILE, then capture with --calibration "
        "FILE",
        prepared.device->Info().uri);
  acquisition::RecordingHeader& recording = prepared.recording =
      acquisition::RecordingHeader::Of(*prepared.device);
  if (resumed) RequireSameCamera(args.dir, *resumed, prepared.device->Info());
  const SessionLenses lenses =
      ChooseLenses(*prepared.device, first, args.intrinsics, intrinsics, prepared.writer.get());
  prepared.camera = lenses.live.camera;
  // Views of another lens hold the map, which then says nothing of this one.
  if (resumed && !stills && options->lens == tracking::LensUse::kCheck &&
      std::ranges::any_of(resumed->views,
                          [&](const View& view) { return resumed->CameraOf(view) != prepared.camera; }))
    options->lens = tracking::LensUse::kFixed;
  options->calibration_source = lenses.live.calibration_source;
  if (!options->calibration_source.empty())
    options->calibrated = acquisition::IsCalibration(options->calibration_source);
  recording.camera = prepared.camera;
  recording.flat_field = lenses.live.flat_field;
  recording.color_profile = lenses.live.color_profile;
  if (stills) {
    options->still_camera = lenses.recorded.camera;
    recording.still_camera = lenses.recorded.camera;
    recording.still_flat_field = lenses.recorded.flat_field;
    recording.still_color_profile = lenses.recorded.color_profile;
  }
  const acquisition::DeviceInfo info = prepared.device->Info();
  if (args.no_subject && stills)
    throw UsageError(
        "--no-subject: {} takes photographs where the coverage of a subject needs them; leave out "
        "--no-subject, or take the photographs by hand and track a video of the same place",
        info.uri);
  if (args.keep_apart && stills)
    throw UsageError(
        "--keep-apart: {} takes photographs, and keeps those without a pose anyway; live frames are not of "
        "their size: leave out --keep-apart",
        info.uri);
  if (options->bracket) RequireExposures(*prepared.device, *options->bracket, first, stills);
  if (args.poses.ComeWithFrames() && !first.known_cam_from_world)
    throw UsageError("--poses known: {} does not know its poses; leave it out to have them tracked",
                     info.uri);
  prepared.poses =
      args.poses.Open(prepared.camera, {.tracker = {.deterministic = args.deterministic,
                                                    .max_side_px = args.tracking_side_px,
                                                    .wait_for_mapper = !prepared.device->IsLive(),
                                                    .readout = ReadoutOf(args, resumed),
                                                    .lens = options->lens,
                                                    .lens_is_guess = options->calibrated == false},
                                        .subject = options->subject,
                                        .metric = info.bus == "simulated",
                                        .stop = StopOnSignal::Asked});
  if (args.poses.UseFeatures() && resumed && !resumed->views.empty())
    RestoreOrSeedMap(*resumed, prepared.camera, *prepared.poses);
  if (!prepared.writer) {
    CaptureHeader header;
    header.camera = lenses.recorded.camera;
    header.flat_field = lenses.recorded.flat_field;
    header.color_profile = lenses.recorded.color_profile;
    header.calibration_source = lenses.recorded.calibration_source;
    header.device_uri = info.uri;
    header.device_serial = info.serial;
    header.device_maker = info.maker;
    header.device_model = info.model;
    if (!stills) header.window = prepared.device->Window();
    header.units = prepared.poses->IsMetric() ? "metres" : "arbitrary";
    if (!args.no_subject) header.threshold_px = options->threshold_px;
    header.coverage_width_px = options->coverage_width_px;
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Create(args.dir, header));
  }
  if (lenses.is_new) GoOnUnder(lenses.recorded, *prepared.writer);
  if (options->turntable) {
    prepared.writer->SetTurntable({options->turntable->kind == tracking::MarkerSpec::Kind::kBoard
                                       ? options->turntable->board.Text()
                                       : std::string()});
    if (!prepared.writer->Contents().up_in_world) prepared.writer->SetUp(-Eigen::Vector3d::UnitZ());
  } else if (prepared.writer->Contents().turntable && !args.poses.ComeWithFrames()) {
    throw UsageError("{}: its subject turned; go on with --turntable {}", args.dir,
                     prepared.writer->Contents().turntable->board);
  }
  if (options->cap) prepared.writer->SetGoal({options->cap->Degrees(), options->until_share});
  // A photograph's shutter is another than live view's, which is tracked.
  if (args.readout.readout_s && !stills) prepared.writer->SetReadout({*args.readout.readout_s, {}});
  prepared.writer->KeepMosaics(args.raw);
  if (args.raw && first.image.mosaic == Mosaic::kNone)
    spdlog::warn("--raw: the frames of {} are not a mosaic; --raw changes nothing", args.uri);
  return true;
}

}  // namespace

bool PrepareCapture(const CaptureArgs& args, CaptureOptions* options, PreparedCapture& prepared) {
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

}  // namespace ulf::coverage
