// Runs the operator display without a window, for remote use and for programs: keys come as lines of text,
// and pictures of the display go to files (`ulf capture` calls that offscreen). The same code runs as in a
// window.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/mutex.h"
#include "coverage/session/capture_request.h"
#include "render/display/surface.h"

namespace ulf::coverage {

// Hands lines from the thread that reads them to the display's, in order: keys, pictures, and requests to the
// capture.
class DisplayScript {
 public:
  using Keys = std::vector<render::InputEvent>;
  using Look = std::filesystem::path;
  using Step = std::variant<Keys, Look, CaptureRequest>;
  explicit DisplayScript(CaptureRequests& requests) : requests_(requests) {}

  // Takes "press s,Up,Enter" (key_names.h), "look FILE.png" or a capture's request. Throws Refusal for any
  // other line. Once there is no display, requests go to the capture at once; for the others an error is
  // printed.
  void Take(const std::string& line);
  std::optional<Step> Next();  // the oldest, which is then gone; none: there is none
  void Push(const CaptureRequest& request) { requests_.Push(request); }
  // Call it when there is no display, or no longer.
  void End();

 private:
  void WithoutDisplay(const Step& step);
  CaptureRequests& requests_;
  Mutex mutex_;
  std::deque<Step> steps_ ULF_GUARDED_BY(mutex_);
  bool ended_ ULF_GUARDED_BY(mutex_) = false;
};

// Executes one line after the other, kFramesBetween pictures of the display apart (0.6 s at 30 a second). So
// the effect of a line is on the screen before a picture is written, and longer than a view must be marked
// before a key takes it back. Pictures that are still to be written when the display ends show its last one.
class ScriptedSurface : public render::OffscreenSurface {
 public:
  static constexpr int kFramesBetween = 18;
  ScriptedSurface(cv::Size size, std::shared_ptr<DisplayScript> script);
  ~ScriptedSurface() override;
  std::vector<render::InputEvent> TakeEvents(double patience_s) override;
  void Present() override;

 private:
  void Write(const std::filesystem::path& file, const char* when);

  std::shared_ptr<DisplayScript> script_;
  int frames_ = 0;  // since the last line
  std::optional<std::filesystem::path> look_;
};

}  // namespace ulf::coverage
