// ulf capture, the main command: from a device's URI to a light field on disk.

#include <algorithm>
#include <memory>
#include <set>

#include "acquisition/device/frame_recording.h"
#include "commands/capture/capture_closing.h"
#include "commands/capture/capture_start.h"
#include "commands/capture/crash_handler.h"
#include "commands/capture/resume_options.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/options/tracking_options.h"
#include "core/base/available_memory.h"
#include "core/base/counted.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/base/stop_signal.h"
#include "core/base/waiting.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_check.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/operator/coverage_drawing.h"
#include "coverage/operator/panels.h"
#include "coverage/operator/run_with_display.h"
#include "coverage/operator/scripted_surface.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/capture_session.h"
#include "tracking/sources/marker_spec.h"

namespace ulf::commands {
namespace {

// Returns the largest share of the limits that end the capture; without limits the device's own.
double ShareDone(const CaptureArgs& args, const coverage::CaptureOptions& options,
                 const coverage::CaptureState& now, double first_time_s, const acquisition::Device& device) {
  double share = 0;
  if (now.covered) share = *now.covered / options.until_share;
  if (args.frames > 0)
    share = std::max(share, static_cast<double>(now.frames) / static_cast<double>(args.frames));
  if (args.max_seconds > 0) share = std::max(share, (now.device_time_s - first_time_s) / args.max_seconds);
  if (!now.covered && args.frames == 0 && args.max_seconds == 0) share = device.ShareDone().value_or(0);
  return std::min(0.99, share);
}

std::string ProgressLine(const coverage::CaptureState& now, double until_share) {
  const std::string covered =
      now.covered ? fmt::format(", {:.1f} of {:g} % covered", 100 * *now.covered, 100 * until_share) : "";
  const coverage::NoticedMistake* mistake = MistakeForReason(now.decision.reason, now.mistakes);
  std::string what =
      mistake && mistake->IsSeenAt(now.seconds) ? Name(mistake->mistake) : InWords(now.decision.reason);
  if (now.waits_to_begin) what = "not begun yet: Space in the display, or the request record, begins";
  if (!now.why_waiting.empty())
    what = now.why_waiting;
  else if (!now.tracking_words.empty())
    what = now.tracking_words;
  const std::string way = coverage::WayInWords(now);
  return fmt::format("{}, {} recorded{}; {}{}", Counted(now.frames, "frame"), now.view_ids.size(), covered,
                     what, way.empty() ? "" : "; next: " + way);
}

coverage::SurfaceFactory DoorFor(const CaptureArgs& args,
                                 const std::shared_ptr<coverage::DisplayScript>& script) {
  constexpr int kWidth = 1280, kHeight = 720;
  if (args.headless) return {};
  if (args.offscreen)
    return [script]() -> std::unique_ptr<render::Surface> {
      try {
        return std::make_unique<coverage::ScriptedSurface>(cv::Size(kWidth, kHeight), script);
      } catch (...) {
        script->End();
        throw;
      }
    };
  return [] { return render::OpenWindow("ulf capture", {kWidth, kHeight}); };
}

int RunCaptureCommand(const CaptureArgs& args, const LensUseArgs& lens, const std::set<std::string>& given) {
  ShareHeaps();
  coverage::CaptureOptions options = OptionsFrom(args);
  RequireUsable(lens);
  RequireResumable(args, given);
  if (!args.marker.empty()) tracking::MarkerSpec::Parse(args.marker);
  if (!args.marker.empty() && args.headless)
    throw UsageError(
        "--marker {}: it moves the camera of the display's review, and --headless has no display; leave out "
        "one of the two",
        args.marker);
  if (args.offscreen && (args.headless || args.requests.empty()))
    throw UsageError(
        "--offscreen: a display without a window, for which lines of --requests press keys and write "
        "pictures; {}",
        args.headless ? "leave out --headless, which has no display" : "give --requests, too");
  for (const std::string& picture : {args.overlay, args.map, args.error_map})
    if (!picture.empty()) RequireWritablePicture(picture);
  if (!args.keep_frames.empty()) acquisition::RequireNewRecording(args.keep_frames);
  CaptureRun run;
  if (!args.truth.empty()) run.truth = ReadTum(args.truth);
  std::optional<coverage::RequestLines> request_lines;  // refuses before anything is written
  coverage::CaptureRequests requests;
  const auto script = std::make_shared<coverage::DisplayScript>(requests);
  if (!args.requests.empty()) {
    std::function<void(const std::string&)> take;
    if (args.offscreen)
      take = [script](const std::string& line) { script->Take(line); };
    else
      take = [&requests](const std::string& line) { requests.Push(coverage::ParseCaptureRequest(line)); };
    request_lines.emplace(args.requests, std::move(take));
  }
  const StopOnSignal signals;
  PreparedCaptureCommand prepared;
  if (!PrepareCapture(args, &options, prepared)) {
    fmt::print(stderr, "stopped before the first frame: no light field was written\n");
    return kOk;
  }

  std::optional<Waiting> closing;
  {
    const CrashHandler guard(args.dir);
    run.folder.emplace(args.dir);
    Progress progress("capture");
    const double first_time_s = prepared.first.back().device_time_s;
    double shown_share = 0;  // never falls, although corrected poses may reopen the cap
    coverage::CaptureHooks hooks;
    hooks.say = [&](const std::string& line) { progress.Say(line); };
    hooks.closing = [&](const std::string& step) {
      if (!closing) closing.emplace("closing", step);
      closing->SetStep(step);
    };
    hooks.stop_requested = [] { return StopOnSignal::Requested(); };
    hooks.requests = &requests;
    const auto read_requests = [&] {
      if (request_lines) request_lines->Take(hooks.say);
    };
    coverage::CaptureFeed feed;
    hooks.while_waiting = [&](const coverage::SharedCaptureState& now) {
      read_requests();
      feed.Publish(now);
      if (!now->why_waiting.empty()) progress.Show(shown_share, ProgressLine(*now, options.until_share));
    };
    hooks.after_frame = [&](const coverage::SharedCaptureState& now) {
      read_requests();
      feed.Publish(now);
      if (prepared.person) prepared.person->See(now->device_time_s, *now);
      if (now->cam_from_world) run.live.push_back({now->device_time_s, *now->cam_from_world});
      shown_share = std::max(shown_share, ShareDone(args, options, *now, first_time_s, *prepared.device));
      progress.Show(shown_share, ProgressLine(*now, options.until_share));
    };
    std::unique_ptr<acquisition::FrameRecorder> recorder;
    if (!args.keep_frames.empty()) {
      recorder = std::make_unique<acquisition::FrameRecorder>(args.keep_frames, prepared.recording);
      hooks.keep_frame = [&](const Frame& frame) { recorder->TryAdd(frame); };
      hooks.say = [&](const std::string& line) {
        progress.Say(line);
        recorder->Note(line);
      };
    }
    if (!options.begins_on_request)
      hooks.say(args.headless ? "no display (--headless): recording begins by itself"
                              : "the frames are a recording: recording begins by itself");
    const auto capture = [&] {
      run.summary =
          coverage::RunCapture(*prepared.device, prepared.camera, *prepared.poses,
                               std::move(*prepared.writer), options, hooks, std::move(prepared.first));
    };
    coverage::RunWithDisplay(DoorFor(args, script), {.marker = args.marker}, feed, requests, capture);
    if (recorder) run.kept = recorder->Finish();
  }
  closing.reset();
  return CloseCapture(args, lens, options, prepared, run);
}

}  // namespace

void AddCaptureCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<CaptureArgs>();
  auto lens = std::make_shared<LensUseArgs>();
  CLI::App* command =
      app.add_subcommand("capture", "Capture a light field: records every view that is missing");
  command->add_option("URI", args->uri, "Device, see 'ulf devices' (default: the first real camera)");
  command->add_option("-o,--output", args->dir, "Folder of the light field")->required();
  command->add_option("--subject", args->subject, "Subject: auto, or x,y,z,radius in world units")
      ->capture_default_str();
  command
      ->add_option("--subject-size", args->subject_size,
                   "With --subject auto: width of the sphere's image, share of the image's width")
      ->capture_default_str();
  command->add_flag("--no-subject", args->no_subject,
                    "Capture posed photographs of a place without a subject: by parallax and overlap, the "
                    "sharpest of neighbouring frames (docs/tracking.md)");
  command
      ->add_option(
          "--parallax-deg", args->parallax_deg,
          "With --no-subject: parallax in degrees from which on another view is recorded (default: 1)")
      ->check(Positive());
  command->add_option("--until-covered", args->until_covered,
                      "Stop when this cap is covered, AZIMUTHxELEVATION in degrees such as 60x40 or "
                      "60x40:95% (default: 98 % of it; with --resume as before); none: until stopped");
  command
      ->add_option("--quality", args->quality,
                   fmt::format("Threshold by name: high {:g} px, fast {:g} px (default: high)",
                               coverage::kHighThresholdPx, coverage::kFastThresholdPx))
      ->check(CLI::IsMember({"high", "fast"}));
  command->add_option(
      "--threshold-px", args->threshold_px,
      fmt::format("Largest error of the bound, in pixels of the coverage image (default: {:g})",
                  coverage::kHighThresholdPx));
  command->add_option("--coverage-width", args->coverage_width_px,
                      fmt::format("Width of the image that the threshold refers to (default: {})",
                                  coverage::kCoverageWidthPx));
  command
      ->add_option("--cover", args->cover,
                   fmt::format("What makes a viewpoint covered: bound (the threshold), measured or "
                               "measured:DB (frames are predicted well enough by the recorded views; DB: to "
                               "how many decibels, default {:g}), both or both:DB (docs/capture.md#guidance)",
                               coverage::CoverGoal{}.db))
      ->capture_default_str();
  AddIntrinsicsOptions(*command, args->intrinsics);
  OfferValues(command->add_option("--poses", args->poses_text, tracking::kPosesHelp), tracking::kPosesValues)
      ->capture_default_str();
  command->add_option(
      "--turntable", args->turntable,
      "The camera stands and the subject turns on this printed board, such as charuco:5x5:54:40:DICT_4X4_50: "
      "the board is the world, the background is masked (docs/capture.md#turntable)");
  AddReadoutOption(*command, args->readout);
  AddLensUseOptions(*command, *lens);
  AddTrackingSideOption(*command, args->tracking_side_px);
  command->add_option("--frames", args->frames, "Stop after this number of frames")->check(Positive());
  command->add_option("--max-seconds", args->max_seconds, "Stop after this time, by the device's clock")
      ->check(Positive());
  command
      ->add_option("--speed", args->speed,
                   "Speed of a recording: 1 as recorded, N times as fast, 0 without waiting (default: 0)")
      ->check(NonNegative());
  command->add_option("--bracket", args->bracket,
                      "Exposures of each view, NUMBERxSTOPS such as 3x2EV: the view's own, and shorter and "
                      "longer ones, which are merged at the end (docs/devices.md)");
  command->add_flag("--keep-apart", args->keep_apart,
                    "Keep pictures of a place that the map does not reach yet in DIR/unposed; ulf refine DIR "
                    "--unposed looks for where they were taken");
  command->add_option("--keep-frames", args->keep_frames,
                      "Save every frame in this new folder, to run the session again with replay:FOLDER");
  command->add_option("--requests", args->requests,
                      "Read requests during the capture from this file or fifo (-: standard input): "
                      "take-back [COUNT], take-back views ID..., subject [x,y,z,r], subject [depth D] [size "
                      "SHARE], subject proposed, pause, record [anyway], finish");
  OfferValues(
      command->add_option(
          "--operator", args->person,
          "Simulated person who holds a simulated camera: guided, unguided, novice or unguided-novice, "
          "with a seed such as novice:7 (default: a hand that scans by a plan; docs/capture.md#guidance)"),
      "guided,unguided,novice,unguided-novice");
  command->add_flag("--headless", args->headless, "Capture without the operator display");
  command->add_flag("--offscreen", args->offscreen,
                    "Run the operator display without a window; --requests then also takes press KEYS "
                    "(s,Up,Enter) and look FILE.png");
  command->add_option(
      "--marker", args->marker,
      "Marker that moves the camera of the display's review, such as marker:80:DICT_4X4_50:0");
  command->add_flag("--force-start", args->force_start,
                    "Let recording begin although a check of the list fails (light, focus, disk, pose ...)");
  command->add_flag("--no-geometry", args->no_geometry,
                    "Make no geometry while capturing (default: DIR/proxy.ply, a mesh of the scene, and "
                    "DIR/depth, depth maps of views, are there at the end)");
  command->add_flag("--deterministic", args->deterministic,
                    "Use one thread, so that the same frames give the same bytes");
  command->add_flag("--resume", args->resume, "Continue the light field in the folder");
  command->add_flag("--raw", args->raw,
                    "Save the mosaics of a mosaic camera as masters (default: their 16-bit colours)");
  command->add_option("--overlay", args->overlay,
                      "Write a picture: the last recorded frame with the painted sphere");
  command->add_option("--map", args->map, "Write a picture: the coverage map");
  command->add_option("--error-map", args->error_map,
                      "Write a picture: the errors that were measured at frames");
  command
      ->add_option("--truth", args->truth,
                   "True poses (TUM, device times): print the tracker's error at the end")
      ->check(CLI::ExistingFile);
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf capture sim:studio -o studio --headless --until-covered 60x40 --quality fast\n\n"
      "Keys of the display (docs/capture.md):" +
      KeyLines(coverage::kKeysAlways) + "\nWhile the subject is placed:" +
      KeyLines(coverage::kKeysInSubject) + "\nIn the review:" + KeyLines(coverage::kKeysInReview));
  command->callback([args, lens, command, &chosen] {
    chosen = [args, lens, given = GivenOptions(*command)] {
      args->poses = PosesFrom(*args);
      args->lens = lens->use;
      args->lens_is_asked = lens->is_asked;
      return RunCaptureCommand(*args, *lens, given);
    };
  });
}

}  // namespace ulf::commands
