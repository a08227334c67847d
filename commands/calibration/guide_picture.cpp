#include "commands/calibration/guide_picture.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>

#include "acquisition/calibration/calibration_picture.h"
#include "commands/options/command_line.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/output_path.h"
#include "core/image/files/png_picture.h"
#include "render/display/live_texture.h"

namespace ulf::commands {
namespace {

// The window or file that shows the picture.
class GuidePicture {
 public:
  GuidePicture(std::string file, std::unique_ptr<render::PictureWindow> window)
      : file_(std::move(file)), window_(std::move(window)) {}
  void Show(const cv::Mat& gray, const acquisition::CalibrationGuide& guide,
            acquisition::ViewVerdict verdict) {
    if (window_) {
      closed_ = closed_ || !window_->Show(acquisition::DrawGuide(gray, guide, verdict));
      return;
    }
    // Every recorded view is shown, whatever the period.
    constexpr double kPeriodS = 1;
    if (written_ && SecondsSince(*written_) < kPeriodS && verdict != acquisition::ViewVerdict::kTaken) return;
    written_ = std::chrono::steady_clock::now();
    try {
      WriteFileAtomically(file_, PngBytes(acquisition::DrawGuide(gray, guide, verdict)));
    } catch (const Error& error) {
      if (!said_) spdlog::warn("--preview: {}; the calibration goes on", error.what());
      said_ = true;
    }
  }
  bool closed() const { return closed_; }

 private:
  std::string file_;
  std::unique_ptr<render::PictureWindow> window_;
  std::optional<std::chrono::steady_clock::time_point> written_;
  bool said_ = false, closed_ = false;
};

std::unique_ptr<GuidePicture> OpenGuidePicture(const CalibrateArgs& args) {
  if (!args.preview.empty()) return std::make_unique<GuidePicture>(args.preview, nullptr);
  // If the lines are not read on a terminal, nobody watches.
  if (args.json || isatty(STDERR_FILENO) == 0) return nullptr;
  try {
    return std::make_unique<GuidePicture>("", std::make_unique<render::PictureWindow>("ulf calibrate"));
  } catch (const Error&) {
    return nullptr;  // without a display the lines must suffice
  }
}

// Returns whether a line has come on standard input. A background job must not read from its terminal.
bool EnterWasPressed() {
  static bool ended = false;
  if (ended || (isatty(STDIN_FILENO) != 0 && tcgetpgrp(STDIN_FILENO) != getpgrp())) return false;
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  while (poll(&input, 1, 0) > 0) {
    char character = 0;
    if (read(STDIN_FILENO, &character, 1) <= 0) {
      ended = true;
      return false;
    }
    if (character == '\n') return true;
  }
  return false;
}

}  // namespace

void ShowGuide(const CalibrateArgs& args, bool is_device, Progress& progress,
               acquisition::CalibrationCaptureOptions& options) {
  if (!args.preview.empty()) {
    if (!is_device) throw UsageError("--preview shows the live picture of a device; these are files");
    if (std::filesystem::path(args.preview).extension() != ".png")
      throw UsageError("--preview {}: is written as PNG; name it so", args.preview);
    RequireWritable(args.preview);
  }
  if (!is_device) return;
  options.say = [&progress](const std::string& line) { progress.Say(line); };
  options.release = EnterWasPressed;
  const std::shared_ptr<GuidePicture> picture = OpenGuidePicture(args);
  if (!picture) return;
  options.show_picture = [picture](const cv::Mat& gray, const acquisition::CalibrationGuide& guide,
                                   acquisition::ViewVerdict verdict) { picture->Show(gray, guide, verdict); };
  options.stop = [picture, stop = options.stop] { return stop() || picture->closed(); };
}

}  // namespace ulf::commands
