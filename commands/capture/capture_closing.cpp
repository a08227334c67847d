#include "commands/capture/capture_closing.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/calibration/intrinsics.h"
#include "commands/capture/capture_report.h"
#include "commands/options/command_line.h"
#include "commands/reports/check_reports.h"
#include "commands/reports/light_field_report.h"
#include "commands/reports/work_reports.h"
#include "core/base/counted.h"
#include "core/base/device_uri.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/base/waiting.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_check.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/unused_folder.h"
#include "coverage/operator/coverage_drawing.h"
#include "coverage/session/record/map_cache.h"
#include "render/masks/turntable_masks.h"
#include "render/stereo/bracket_merge.h"
#include "render/stereo/proxy_builder.h"
#include "tracking/features/succession.h"

namespace ulf::commands {
namespace {

void WritePictures(const CaptureArgs& args, const LightField& light_field,
                   const coverage::CaptureSummary& summary) {
  if (args.overlay.empty() && args.map.empty() && args.error_map.empty()) return;
  if (!summary.map || summary.map->views().empty() || !summary.last_recorded) {
    fmt::print(stderr, "no view was recorded: --overlay, --map and --error-map write no pictures\n");
    return;
  }
  // Its pose and lens may have been corrected since; a view that was taken back has the recorded ones.
  Rigid3 cam_from_world = summary.last_recorded->cam_from_world;
  CameraModel camera = summary.last_recorded->camera;
  const auto view = std::ranges::find(light_field.views, summary.last_recorded->id, &View::id);
  if (view != light_field.views.end()) {
    cam_from_world = view->cam_from_world;
    camera = light_field.CameraOf(*view);
  }
  if (!args.overlay.empty()) {
    // Small images are drawn at twice their size, so that lines and dots stay clear.
    constexpr int kWideEnough = 1000;
    const int factor = camera.width < kWideEnough ? 2 : 1;
    const CameraModel large = camera.ScaledTo(factor * camera.width, factor * camera.height);
    cv::Mat live;
    cv::resize(Srgb8(summary.last_recorded->frame.image), live, {large.width, large.height}, 0, 0,
               cv::INTER_CUBIC);
    WritePictureFile(args.overlay, coverage::DrawOverlay(live, large, cam_from_world, *summary.map));
  }
  if (!args.map.empty())
    WritePictureFile(args.map, coverage::DrawCoverageMap(*summary.map, {.cam_from_world = cam_from_world}));
  if (args.error_map.empty()) return;
  if (summary.errors && summary.measured)
    WritePictureFile(args.error_map,
                     coverage::DrawErrorMap(*summary.map, *summary.errors, summary.measured->cover.db));
  else
    fmt::print(stderr, "--error-map: no errors were measured; it is not written\n");
}

// Warns if measured errors were requested and missing.
void WarnIfNothingMeasured(const CaptureArgs& args, const coverage::CaptureSummary& summary) {
  const bool decides = coverage::CoverGoal::Parse(args.cover).by != coverage::CoverBy::kBound;
  if (summary.measured || !(decides || !args.error_map.empty())) return;
  const bool mesh_came_late = summary.geometry && summary.geometry->mesh;
  fmt::print(
      stderr, "no errors were measured: {}{}\n",
      mesh_came_late
          ? fmt::format("the first mesh was there only after the last frame. Geometry needs time beside the "
                        "capture: {}",
                        IsTaken(summary.source)
                            ? "play the recording more slowly (--speed 0.3), with fewer programs running"
                            : "move more slowly, or with fewer programs running (a simulated camera goes "
                              "faster than real time where it can)")
          : "there was no mesh of the subject to measure over",
      decides ? "; the bound alone decided what was recorded" : "");
}

// Warns of a guessed lens that nothing replaced: it may still be wrong.
void WarnOfGuessedLens(const coverage::CaptureOptions& options, const coverage::CaptureSummary& summary,
                       const CameraModel& guessed) {
  const bool was_guessed = options.lens_origin == acquisition::LensOrigin::kGuessed;
  const bool is_confirmed = summary.calibration && summary.calibration->determined;
  if (!was_guessed || summary.refined_lens || is_confirmed) return;
  fmt::print(stderr,
             "the focal length of {:.0f} px is still a guess: the images do not tell another one, because "
             "the camera moved too little or in one direction only; ulf refine --intrinsics may tell\n",
             guessed.MeanFocalPx());
}

void PrintResult(const CaptureArgs& args, const coverage::CaptureSummary& summary,
                 const LightFieldReport& report, std::size_t tracked, const std::optional<PoseErrors>& errors,
                 const std::optional<render::BracketReport>& brackets) {
  if (args.json) {
    nlohmann::json json = ToJson(report);
    AddTo(json, summary, tracked);
    if (errors) AddTo(json, *errors);
    if (brackets) json["merged"] = ToJson(*brackets);
    fmt::print("{}\n", JsonText(json));
  } else {
    fmt::print("{}{}{}{}", ToText(report), ToText(summary, tracked, args.dir),
               brackets ? ToText(*brackets) : "", errors ? ToText(*errors) : "");
  }
  std::fflush(stdout);
}

// Checks all recorded views, also of earlier sessions. Reading raw files takes too long for the end of a
// capture.
void WarnIfLampChanged(LightField& light_field) {
  if (std::ranges::any_of(light_field.views, [](const View& view) { return IsRawFile(view.master_path); }))
    return;
  Progress progress("light");
  const LightCheck check = CheckLightOf(light_field, progress);
  if (const std::string advice = LampAdvice(check, SourceOf(light_field)); !advice.empty())
    spdlog::warn("{}", advice);
  if (check.not_compared.empty()) KeepLight(check, light_field);
}

// The exposures are on disk: a merge that fails now can be repeated later.
std::optional<render::BracketReport> Merged(const CaptureArgs& args,
                                            const coverage::CaptureSummary& summary) {
  if (summary.brackets.exposures == 0 || summary.stopped_because == coverage::StoppedBecause::kDisk)
    return std::nullopt;
  try {
    return render::MergeBrackets(args.dir);
  } catch (const Error& error) {
    fmt::print(stderr, "{}\nthe exposures are recorded; ulf merge {} merges them\n", error.what(),
               ShellWord(args.dir));
    return std::nullopt;
  }
}

void ReportUnwrittenFrames(const coverage::CaptureSummary& summary, bool folder_is_there) {
  if (summary.stopped_because != coverage::StoppedBecause::kDisk) return;
  fmt::print(stderr, "ulf: {}\n{}", summary.problem,
             folder_is_there ? "ulf: the views written before are complete; go on with --resume\n" : "");
  for (const auto& [folder, count] : summary.set_aside)
    fmt::print(stderr, "ulf: {} taken by then: kept in {}\n", Counted(count, "frame"), folder.string());
  if (summary.unwritten > 0)
    fmt::print(stderr, "ulf: {} taken by then could not be written anywhere\n",
               Counted(summary.unwritten, "frame"));
}

// Makes masks, and with them the geometry that other captures make while they run. Returns false, with the
// reason logged, if it fails: the views are kept.
bool MaskTurntable(const CaptureArgs& args) {
  if (args.turntable.empty() || ReadLightField(args.dir).views.empty()) return true;
  try {
    fmt::print(stderr, "{}", ToText(render::WriteTurntableMasks(args.dir)));
  } catch (const Error& error) {
    fmt::print(stderr,
               "ulf: {}\nulf: the views are kept, without masks; go on with --resume, or make the masks "
               "anew: ulf mask {}\n",
               error.what(), ShellWord(args.dir));
    return false;
  }
  if (args.no_geometry) return true;
  try {
    render::WriteMeshProxy(args.dir);
  } catch (const Error& error) {
    fmt::print(stderr, "no geometry: {}\n", error.what());
  }
  return true;
}

// Reads a file of true poses again, because a simulator adds to it while the capture runs. A pipe gives its
// poses once.
std::optional<PoseErrors> ErrorsAgainst(const std::string& truth, const CaptureRun& run,
                                        const LightField& light_field) {
  if (truth.empty()) return std::nullopt;
  try {
    const bool is_file = std::filesystem::is_regular_file(truth);
    return CompareWithTruth(is_file ? ReadTum(truth) : run.truth, run.live, light_field);
  } catch (const Error& error) {
    fmt::print(stderr, "not compared with the true poses: {}\n", error.what());
    return std::nullopt;
  }
}

// Returns whether the frames are pictures of a folder whose poses are found here.
bool ArePhotographsOfAFolder(const CaptureArgs& args, const coverage::CaptureSummary& summary,
                             const acquisition::Device& device) {
  return summary.source == FrameSource::kPhotographs && !device.Camera() && args.poses.FindLens() &&
         std::filesystem::is_directory(DeviceUri::Parse(args.uri).path);
}

std::string WayOfPhotographsInAnyOrder(const CaptureArgs& args) {
  return fmt::format("For photographs in any order: ulf import {} --pose -o DIR",
                     ShellWord(DeviceUri::Parse(args.uri).path));
}

// Says that the photographs of a folder do not follow each other, if most have no pose and neighbours show
// other things; empty otherwise. A camera that was lost for a while still shows nearly what it showed before.
std::string WhyPhotographsAreApart(const CaptureArgs& args, const coverage::CaptureSummary& summary,
                                   std::size_t tracked, acquisition::Device& device) {
  constexpr int kLookedAt = 120;  // frames
  if (!ArePhotographsOfAFolder(args, summary, device) || 2 * tracked >= summary.frames) return {};
  tracking::Succession succession;
  device.Start();
  for (int i = 0; i < kLookedAt; ++i) {
    const auto frame = device.Next(std::chrono::milliseconds(200));
    if (!frame) break;
    succession.Add(GrayForTracking(frame->image));
  }
  device.Stop();
  const auto [near, apart] = succession.found();
  if (apart <= near) return {};
  return fmt::format(
      "only {} of {} have a pose, because they do not follow one another as the frames of a moving camera "
      "do: of {} the second shows other things, or the same elsewhere in the picture. {}",
      tracked, Counted(summary.frames, "photograph"),
      fmt::format("{} of {} neighbours", apart, Counted(near + apart, "pair")),
      WayOfPhotographsInAnyOrder(args));
}

// A failed capture leaves what was recorded; views that were taken back lie in unposed/.
void LeaveNothingOf(const CaptureArgs& args) {
  if (!args.resume) RemoveUnused(args.dir);
}

}  // namespace

int CloseCapture(const CaptureArgs& args, const LensUseArgs& lens, const coverage::CaptureOptions& options,
                 PreparedCaptureCommand& hand, CaptureRun& run) {
  coverage::CaptureSummary& summary = run.summary;
  const acquisition::FrameRecorderSummary& kept = run.kept;
  if (kept.left_out > 0)
    fmt::print(stderr, "{}: {} left out of the recording, of {}: {}\n", args.keep_frames,
               Counted(kept.left_out, "frame"), kept.left_out + kept.written, kept.problem);
  const std::optional<std::string> gone = run.folder->WhyNotInPlace();
  if (gone) summary.stopped_because = coverage::StoppedBecause::kDisk, summary.problem = *gone;
  ReportUnwrittenFrames(summary, !gone);
  if (gone) return kFailed;
  const bool masked = MaskTurntable(args);
  std::optional<Waiting> closing;
  closing.emplace("closing", "the map for the next session, and the report");
  LightField light_field = ReadLightField(args.dir);
  if (summary.stopped_because != coverage::StoppedBecause::kDisk && !light_field.views.empty())
    coverage::SaveMapCache(light_field, summary.refined_lens ? summary.refined_lens->camera : hand.camera,
                           *hand.poses);
  const LightFieldReport report =
      commands::Describe(light_field, {.cap = options.cap, .threshold_px = options.threshold_px});
  const std::optional<PoseErrors> errors = ErrorsAgainst(args.truth, run, light_field);
  closing.reset();
  PrintResult(args, summary, report, run.live.size(), errors, Merged(args, summary));
  WarnIfLampChanged(light_field);
  WarnIfNothingMeasured(args, summary);
  WritePictures(args, light_field, summary);
  WriteFoundLens(lens, *hand.device, summary.refined_lens, summary.calibration, "ulf capture");
  WarnOfGuessedLens(options, summary, hand.camera);
  if (summary.stopped_because == coverage::StoppedBecause::kCovered && report.covered < options.until_share)
    fmt::print(stderr, "the last correction of poses opened a part of the cap again{}\n",
               IsTaken(summary.source) ? "" : ", which must be taken again: go on with --resume");
  if (summary.stopped_because == coverage::StoppedBecause::kDisk) return kFailed;
  if (summary.stopped_because == coverage::StoppedBecause::kDeviceLost) {
    fmt::print(stderr,
               "ulf: {}: the device no longer answers; the light field is closed, go on with --resume\n",
               args.uri);
    return kFailed;
  }
  const bool was_asked_to_end = summary.stopped_because == coverage::StoppedBecause::kSignal ||
                                summary.stopped_because == coverage::StoppedBecause::kClosed;
  if (const std::string why_apart =
          was_asked_to_end ? "" : WhyPhotographsAreApart(args, summary, run.live.size(), *hand.device);
      !why_apart.empty()) {
    fmt::print(stderr, "ulf: {}\n", why_apart);
    LeaveNothingOf(args);
    return kFailed;
  }
  if (report.views == 0 && !was_asked_to_end) {
    fmt::print(
        stderr, "ulf: {}{}\n", NothingRecorded(summary, run.live.size()),
        ArePhotographsOfAFolder(args, summary, *hand.device) ? ". " + WayOfPhotographsInAnyOrder(args) : "");
    LeaveNothingOf(args);
    return kFailed;
  }
  const std::string why_few = FewRecordedReason(summary);
  if (!why_few.empty()) fmt::print(stderr, "ulf: {}\n", why_few);
  const bool added_nothing = summary.recorded == 0 && !why_few.empty() && !was_asked_to_end;
  return masked && !added_nothing ? kOk : kFailed;
}

}  // namespace ulf::commands
