#include "coverage/session/prepared_capture.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "acquisition/device/repeated_events.h"
#include "acquisition/opening/open_device.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/geometry/angles.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/unused_folder.h"
#include "coverage/session/record/kept_photographs.h"
#include "coverage/session/record/map_cache.h"
#include "coverage/session/session_lenses.h"

namespace ulf::coverage {
namespace fs = std::filesystem;

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
    const auto folder = SavePhotograph(writer, dir, photograph, problem);
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

// Takes frames from a started device up to its first complete live frame, which is the last of `taken`;
// photographs that are released on the body meanwhile come before it. Returns false when a stop was asked for
// first. Throws Error when no live frame comes; `taken` then holds the photographs.
bool TakeFirstFrames(acquisition::Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken) {
  constexpr std::chrono::seconds kPatience(10);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  acquisition::RepeatedEvents repeated;
  while (std::chrono::steady_clock::now() < until && !stop()) {
    auto frame = device.Next(std::chrono::milliseconds(200));
    for (const std::string& line : repeated.Update(device.TakeEvents(), EpochSeconds()))
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

// Known poses come without tracked points, by which a capture finds its subject; a replayed light field has
// one.
std::optional<Subject> SubjectOfReplay(const std::string& uri) {
  const DeviceUri parsed = DeviceUri::Parse(uri);
  const fs::path dir = parsed.path;
  if (parsed.scheme != "replay" ||
      !(fs::exists(dir / "journal.jsonl") || fs::exists(dir / "transforms.json")))
    return std::nullopt;
  const LightField light_field = ReadLightField(dir);
  return light_field.subject ? light_field.subject : SubjectFromAxes(light_field);
}

// Takes from the light field the options that the caller leaves open.
void ResumeOptions(const SessionArgs& args, const LightField& light_field, CaptureOptions* options) {
  if (options->without_subject) return;
  if (!light_field.subject && !light_field.views.empty() && !options->subject)
    spdlog::info("{}: has no subject yet, this session looks for one ({}: goes on without)", args.dir,
                 Parameter("no_subject"));
  if (!args.threshold_is_given && light_field.threshold_px) options->threshold_px = *light_field.threshold_px;
  options->coverage_width_px = light_field.coverage_width_px;
  if (!args.goal_is_given && light_field.goal) {
    options->cap = Cap::FromDegrees(light_field.goal->cap_deg);
    options->until_share = light_field.goal->share;
    spdlog::info("{}: goes on until {:g} % of {:g} x {:g} degrees are covered ({} none: until stopped)",
                 args.dir, 100 * light_field.goal->share, light_field.goal->cap_deg.x(),
                 light_field.goal->cap_deg.y(), Parameter("until_covered"));
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
tracking::ReadoutArgs ReadoutOf(const SessionArgs& args, const LightField* resumed) {
  tracking::ReadoutArgs readout = args.readout;
  if (!resumed || !resumed->readout) return readout;
  const ShutterReadout& known = *resumed->readout;
  const double known_ms = 1000 * known.readout_s;
  if (readout.readout_s) {
    // The limit is what the tracker takes for a change, or five deviations of the measured readout.
    const double apart_s = std::abs(*readout.readout_s - known.readout_s);
    if (apart_s >
        std::max(tracking::kSettledReadoutShare * std::abs(known.readout_s), 5 * known.sigma_s.value_or(0)))
      spdlog::warn("{} {:g}: the sessions before {} {:.1f} ms; {:g} is used", Parameter("readout_ms"),
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
    throw Refusal(
        Parameter("bracket"), bracket.Text(),
        fmt::format("{} cannot be asked for exposures: a recording, a camera without an exposure time that "
                    "can be set, or one whose automatic exposure is on (auto_exposure=off)",
                    uri),
        fmt::format("leave out {}", Parameter("bracket")));
  if (!stills && first.exposure_s <= 0)
    throw Refusal(
        Parameter("bracket"), bracket.Text(),
        fmt::format("{} does not tell its exposure time, without which exposures cannot be merged", uri),
        fmt::format("set it in the URI (exposure_us=5000), or leave out {}", Parameter("bracket")));
}

bool Prepare(const SessionArgs& args, CaptureOptions* options, PreparedCapture& prepared) {
  args.poses.RequireFor(args.lens);
  if (!args.resume) RequireForNewLightField(args.dir);  // before the device starts
  if (args.resume) {
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Resume(args.dir));
    ResumeOptions(args, prepared.writer->Contents(), options);
    if (!options->subject) options->subject = prepared.writer->Contents().subject;
  }
  const LightField* resumed = args.resume ? &prepared.writer->Contents() : nullptr;
  if (args.poses.AreGiven() && !options->subject) {
    if (args.poses.ComeWithFrames()) options->subject = SubjectOfReplay(args.uri);
    if (!options->subject)
      throw Refusal(Parameter("poses"), args.poses.Text(),
                    "there are no tracked points to find the subject by",
                    fmt::format("give {} x,y,z,r", Parameter("subject")));
  }
  options->lens = args.lens;
  prepared.device = args.open ? args.open() : acquisition::OpenDevice(args.uri);
  // A recording would run out while it waits.
  if (DeviceUri::Parse(args.uri).scheme == "replay") options->begins_on_request = false;
  prepared.device->Start();
  if (!TakeFirstFrames(*prepared.device, args.uri, args.stop, prepared.first)) return false;
  const Frame& first = prepared.first.back();

  const bool stills = prepared.device->TakesStills();
  acquisition::IntrinsicsArgs intrinsics = args.intrinsics;
  const bool may_seek_lens = args.seeks_unknown_lens && args.lens == tracking::LensUse::kCheck && !resumed &&
                             !stills && IsTaken(prepared.device->Source()) && args.poses.FindLens();
  if (may_seek_lens || args.lens == tracking::LensUse::kRefine)
    intrinsics.guessed_focal_px = acquisition::GuessFocalPx(first);
  if (stills && args.lens == tracking::LensUse::kRefine) {
    const std::string uri = prepared.device->Info().uri;
    const std::string track = fmt::format("ulf track {} --intrinsics refine --calibration-out FILE", uri);
    throw Refusal(Parameter("intrinsics"), "refine",
                  fmt::format("{} records photographs, and live view does not tell their lens", uri),
                  fmt::format("find the lens of live view with {}, then capture with {} FILE", track,
                              Parameter("calibration")));
  }
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
  options->lens_origin = lenses.live_origin;
  if (may_seek_lens && lenses.live_origin == acquisition::LensOrigin::kGuessed)
    options->lens = tracking::LensUse::kRefine;
  if (!options->calibration_source.empty())
    options->calibrated = options->lens_origin == acquisition::LensOrigin::kMeasured;
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
  if (options->without_subject && stills)
    throw Refusal(
        Parameter("no_subject"), "",
        fmt::format("{} takes photographs where the coverage of a subject needs them", info.uri),
        fmt::format("leave out {}, or take the photographs by hand and track a video of the same place",
                    Parameter("no_subject")));
  if (options->keep_apart && stills)
    throw Refusal(Parameter("keep_apart"), "",
                  fmt::format("{} takes photographs, and keeps those without a pose anyway", info.uri),
                  fmt::format("live frames are not of their size: leave out {}", Parameter("keep_apart")));
  if (options->bracket) RequireExposures(*prepared.device, *options->bracket, first, stills);
  if (args.poses.ComeWithFrames() && !first.known_cam_from_world)
    throw Refusal(Parameter("poses"), "known", fmt::format("{} does not know its poses", info.uri),
                  "leave it out to have them tracked");
  prepared.poses =
      args.poses.Open(prepared.camera, {.tracker = {.deterministic = options->deterministic,
                                                    .max_side_px = args.tracking_side_px,
                                                    .wait_for_mapper = !prepared.device->IsLive(),
                                                    .readout = ReadoutOf(args, resumed),
                                                    .lens = options->lens,
                                                    .lens_is_guess = options->calibrated == false},
                                        .subject = options->subject,
                                        .metric = info.bus == "simulated",
                                        .stop = args.stop});
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
    if (!options->without_subject) header.threshold_px = options->threshold_px;
    header.coverage_width_px = options->coverage_width_px;
    prepared.writer = std::make_unique<LightFieldWriter>(LightFieldWriter::Create(args.dir, header));
  }
  if (lenses.is_new) AddCameraInUse(lenses.recorded, *prepared.writer);
  if (options->turntable) {
    prepared.writer->SetTurntable({options->turntable->kind == tracking::MarkerSpec::Kind::kBoard
                                       ? options->turntable->board.Text()
                                       : std::string()});
    if (!prepared.writer->Contents().up_in_world) prepared.writer->SetUp(-Eigen::Vector3d::UnitZ());
  } else if (prepared.writer->Contents().turntable && !args.poses.ComeWithFrames()) {
    throw Refusal(args.dir, "", "its subject turned",
                  fmt::format("go on with {} {}", Parameter("turntable"),
                              prepared.writer->Contents().turntable->board));
  }
  if (options->cap) prepared.writer->SetGoal({options->cap->Degrees(), options->until_share});
  // A photograph's shutter is another than live view's, which is tracked.
  if (args.readout.readout_s && !stills) prepared.writer->SetReadout({*args.readout.readout_s, {}});
  prepared.writer->KeepMosaics(args.raw);
  if (args.raw && first.image.mosaic == Mosaic::kNone)
    spdlog::warn("{0}: the frames of {1} are not a mosaic; {0} changes nothing", Parameter("raw"), args.uri);
  return true;
}

}  // namespace

bool PrepareCapture(const SessionArgs& args, CaptureOptions* options, PreparedCapture& prepared) {
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
