#include "coverage/operator/scripted_surface.h"

#include <fmt/core.h>

#include <utility>

#include "core/base/output_path.h"
#include "core/image/files/picture_file.h"
#include "render/display/surface.h"

namespace ulf::coverage {
namespace {

std::optional<std::string> After(const std::string& word, const std::string& line) {
  constexpr char kBlanks[] = " \t\r";
  const std::size_t begin = line.find_first_not_of(kBlanks);
  if (begin == std::string::npos || line.compare(begin, word.size(), word) != 0) return std::nullopt;
  const std::size_t rest = line.find_first_not_of(kBlanks, begin + word.size());
  if (rest == begin + word.size()) return std::nullopt;  // a longer word
  if (rest == std::string::npos) return "";
  return line.substr(rest, line.find_last_not_of(kBlanks) + 1 - rest);
}

}  // namespace

void DisplayScript::Take(const std::string& line) {
  Step step;
  if (const auto keys = After("press", line)) {
    step = render::KeysFromNames(*keys);
    if (std::get<Keys>(step).empty()) throw Refusal("press", "", "no key is named", "write press s,Up,Enter");
  } else if (const auto file = After("look", line)) {
    RequireWritablePicture(*file);
    step = Look(*file);
  } else {
    step = ParseCaptureRequest(line);
  }
  const MutexLock lock(mutex_);
  if (ended_) return WithoutDisplay(step);
  steps_.push_back(std::move(step));
}

std::optional<DisplayScript::Step> DisplayScript::Next() {
  const MutexLock lock(mutex_);
  if (steps_.empty()) return std::nullopt;
  Step step = std::move(steps_.front());
  steps_.pop_front();
  return step;
}

void DisplayScript::WithoutDisplay(const Step& step) {
  if (const auto* request = std::get_if<CaptureRequest>(&step))
    requests_.Push(*request);
  else if (const auto* file = std::get_if<Look>(&step))
    fmt::print(stderr, "look {}: there is no display to look at\n", file->string());
  else
    fmt::print(stderr, "press: there is no display to press keys of\n");
}

void DisplayScript::End() {
  const MutexLock lock(mutex_);
  ended_ = true;
  for (const Step& step : std::exchange(steps_, {})) WithoutDisplay(step);
}

ScriptedSurface::ScriptedSurface(cv::Size size, std::shared_ptr<DisplayScript> script)
    : render::OffscreenSurface(size), script_(std::move(script)) {}

ScriptedSurface::~ScriptedSurface() {
  constexpr char kAtTheEnd[] = " as the display ended";
  if (look_) Write(*look_, kAtTheEnd);
  while (const auto step = script_->Next()) {
    if (const auto* file = std::get_if<DisplayScript::Look>(&*step))
      Write(*file, kAtTheEnd);
    else if (const auto* request = std::get_if<CaptureRequest>(&*step))
      script_->Push(*request);
    else
      fmt::print(stderr, "press: ignored, the display ended before\n");
  }
  script_->End();
}

std::vector<render::InputEvent> ScriptedSurface::TakeEvents(double patience_s) {
  if (++frames_ > kFramesBetween && !look_) {
    if (auto step = script_->Next()) {
      frames_ = 0;
      if (auto* keys = std::get_if<DisplayScript::Keys>(&*step))
        for (const render::InputEvent& key : *keys) Push(key);
      else if (auto* file = std::get_if<DisplayScript::Look>(&*step))
        look_ = *file;
      else
        script_->Push(std::get<CaptureRequest>(*step));
    }
  }
  return render::OffscreenSurface::TakeEvents(patience_s);
}

void ScriptedSurface::Present() {
  render::OffscreenSurface::Present();
  if (look_) Write(*std::exchange(look_, std::nullopt), "");
}

void ScriptedSurface::Write(const std::filesystem::path& file, const char* when) {
  bool written = false;
  try {
    Bind();
    WritePictureFile(file.string(), Read());
    written = true;
  } catch (const std::exception&) {
  }
  fmt::print(stderr, "look {}: {}{}\n", file.string(), written ? "written" : "cannot be written", when);
}

}  // namespace ulf::coverage
