// `ulf review` shows a light field from where the user holds a marker.
#include <spdlog/spdlog.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/device/repeated_events.h"
#include "acquisition/device/replay_device.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/options/tracking_options.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/stop_signal.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/operator/marker_mouse.h"
#include "render/display/live_texture.h"
#include "render/output/video.h"
#include "render/quality/nearest_view.h"
#include "tracking/sources/marker_locator.h"

namespace ulf::commands {
namespace {

struct ReviewArgs {
  std::string dir;
  std::string uri;
  std::string markers;
  std::string out;
  std::string subject;
  acquisition::IntrinsicsArgs intrinsics;
  int width = 640, height = 480;
  int frames = 0;
  double fps = 30;
  std::optional<double> speed;
  bool json = false;
};

// Shows pictures in a window until `q`, Escape or its close button, or writes them to a file or folder.
class Picture {
 public:
  Picture(const std::string& out, double fps) {
    if (!out.empty()) {
      sink_ = render::OpenPictureSink(out, fps);
      return;
    }
    try {
      window_ = std::make_unique<render::PictureWindow>("ulf review");
    } catch (const Error& error) {
      throw UsageError("review: {}; give -o OUT.mp4, or a folder for pictures", error.what());
    }
  }
  // Returns false once the user closes the window.
  bool Show(const cv::Mat& srgb8) {
    if (window_) return window_->Show(srgb8);
    sink_->Add(srgb8);
    return true;
  }
  void Close() {
    if (sink_) sink_->Close();
  }

 private:
  std::unique_ptr<render::PictureSink> sink_;
  std::unique_ptr<render::PictureWindow> window_;
};

struct ReviewRun {
  int frames = 0, with_marker = 0;
  std::vector<double> locate_ms, draw_ms;  // CPU
  std::vector<bool> shown;                 // by view
};

CameraModel VirtualCamera(const render::RenderScene& scene, const ReviewArgs& args) {
  const CameraModel photograph = scene.views.front().camera.WithoutDistortion();
  return CameraModel::Pinhole(args.width, args.height,
                              photograph.MeanFocalPx() * args.width / photograph.width);
}

ReviewRun Review(const ReviewArgs& args, const render::RenderScene& scene, acquisition::Device& device,
                 Picture& picture) {
  const render::NearestViewRenderer renderer = [&] {
    Progress loading("loading", args.json);
    return render::NearestViewRenderer(scene, &loading);
  }();
  const CameraModel camera = VirtualCamera(scene, args);
  const tracking::MarkerSpec spec = tracking::MarkerSpec::Parse(args.markers);
  coverage::MarkerMouse mouse(scene, spec.Middle());
  std::optional<tracking::MarkerLocator> locator;
  ReviewRun run;
  run.shown.resize(scene.views.size());
  cv::Mat drawn(args.height, args.width, CV_8UC3, cv::Scalar::all(0));
  Progress progress("review", args.json);
  acquisition::RepeatedEvents repeated;
  device.Start();
  while (!acquisition::IsOver(device.State()) && !StopOnSignal::Requested()) {
    for (const std::string& line : repeated.Update(device.TakeEvents(), EpochSeconds()))
      spdlog::warn("{}", line);
    const auto frame = device.Next(std::chrono::milliseconds(200));
    if (!frame) acquisition::RequireLiveFrames(device);
    if (!frame || frame->status != FrameStatus::kComplete || frame->kind != FrameKind::kLive) continue;
    if (!locator)
      locator.emplace(acquisition::ResolveIntrinsics(device, args.intrinsics, frame->image.width(),
                                                     frame->image.height()),
                      spec);
    const double start_s = ThreadCpuSeconds();
    const auto pose = locator->Locate(GrayForTracking(frame->image), frame->device_time_s);
    const double located_s = ThreadCpuSeconds();
    if (pose) {
      run.shown[static_cast<std::size_t>(
          renderer.Draw(camera, mouse.CamFromWorld(pose->cam_from_world), drawn))] = true;
      ++run.with_marker;
      run.draw_ms.push_back(1000 * (ThreadCpuSeconds() - located_s));
    }
    run.locate_ms.push_back(1000 * (located_s - start_s));
    ++run.frames;
    progress.Show(
        args.frames > 0 ? static_cast<double>(run.frames) / args.frames : device.ShareDone().value_or(0),
        pose ? fmt::format("frame {}", run.frames) : fmt::format("frame {}: no marker visible", run.frames));
    // Without the marker the last picture is shown again.
    if (!picture.Show(drawn) || (args.frames > 0 && run.frames >= args.frames)) break;
  }
  device.Stop();
  for (const std::string& line : repeated.Finish()) spdlog::warn("{}", line);
  return run;
}

int RunReview(const ReviewArgs& args) {
  const StopOnSignal signals;
  cv::setNumThreads(1);
  tracking::MarkerSpec::Parse(args.markers);
  render::SceneOptions options{.size_limit_px = std::max(args.width, args.height),
                               .form = render::PhotographForm::kEightBits};
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  const auto scene = render::LoadScene(ReadLightField(args.dir), options);
  const auto device = acquisition::OpenDevice(acquisition::WithReplaySpeed(args.uri, args.speed));
  Picture picture(args.out, args.fps);
  const ReviewRun run = Review(args, *scene, *device, picture);
  picture.Close();
  const auto views = std::ranges::count(run.shown, true);
  if (args.json) {
    const nlohmann::ordered_json report{{"frames", run.frames},
                                        {"with_marker", run.with_marker},
                                        {"views_shown", views},
                                        {"locate_cpu_ms_median", Median(run.locate_ms)},
                                        {"locate_cpu_ms_p95", Quantile(run.locate_ms, 0.95)},
                                        {"draw_cpu_ms_median", Median(run.draw_ms)},
                                        {"draw_cpu_ms_p95", Quantile(run.draw_ms, 0.95)}};
    fmt::print("{}\n", JsonText(report, 2));
  } else {
    fmt::print(
        "{}, {} with the marker, {} of the light field shown; CPU per frame: marker {:.1f} ms (95 %: "
        "{:.1f}), picture {:.1f} ms (95 %: {:.1f})\n",
        Counted(run.frames, "frame"), run.with_marker, Counted(views, "view"), Median(run.locate_ms),
        Quantile(run.locate_ms, 0.95), Median(run.draw_ms), Quantile(run.draw_ms, 0.95));
  }
  if (run.with_marker > 0) return kOk;
  fmt::print(stderr, "ulf: {} was never seen; check its size, dictionary and number\n", args.markers);
  return kFailed;
}

}  // namespace

void AddReviewCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "review", "Shows a light field from where a camera sees a marker in the hand", RunReview);
  command->add_option("DIR", args->dir, "The light field")->required();
  command->add_option("URI", args->uri, "Device that sees the marker (see 'ulf devices')")->required();
  command
      ->add_option("--markers", args->markers,
                   "The marker or board in the hand: marker:80:DICT_APRILTAG_36h11:3, or "
                   "charuco:7x5:30:22:DICT_5X5_100")
      ->required();
  command->add_option("-o,--output", args->out, "OUT.mp4 or a folder for pictures (a window)");
  command->add_option("--subject", args->subject,
                      "Centre and radius x,y,z,r of the subject (the light field's)");
  AddIntrinsicsOptions(*command, args->intrinsics);
  command->add_option("--width", args->width, "Width of the picture in pixels")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--height", args->height, "Height of the picture in pixels")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--frames", args->frames, "Stop after this many frames (all)")->check(Positive());
  command->add_option("--fps", args->fps, "Frame rate of a video")->check(Positive())->capture_default_str();
  command
      ->add_option("--speed", args->speed, "Speed of a recording: 1 is real time, 0 as fast as possible (0)")
      ->check(NonNegative());
  command->add_flag("--json", args->json, "One JSON object");
  command->footer(
      "Example: ulf review studio v4l2:/dev/video0 --markers marker:80:DICT_APRILTAG_36h11:3\n"
      "q or Escape closes the window.");
}

}  // namespace ulf::commands
