#include "coverage/operator/scripted_surface.h"

#include <fmt/core.h>

#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "acquisition/output_path.h"
#include "render/display/key_names.h"

namespace ulf {
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

bool DisplayScript::Take(const std::string& line) {
  std::optional<Step> step;
  if (const auto keys = After("press", line)) {
    step = KeysFromNames(*keys);
  } else if (const auto file = After("look", line)) {
    RequireWritablePicture(*file);
    step = Look(*file);
  }
  if (!step) return false;
  const std::lock_guard lock(mutex_);
  steps_.push_back(std::move(*step));
  return true;
}

std::optional<DisplayScript::Step> DisplayScript::Next() {
  const std::lock_guard lock(mutex_);
  if (steps_.empty()) return std::nullopt;
  Step step = std::move(steps_.front());
  steps_.pop_front();
  return step;
}

ScriptedSurface::ScriptedSurface(cv::Size size, std::shared_ptr<DisplayScript> script)
    : OffscreenSurface(size), script_(std::move(script)) {}

ScriptedSurface::~ScriptedSurface() {
  if (look_) Write(*look_);
  while (const auto step = script_->Next())
    if (const auto* file = std::get_if<DisplayScript::Look>(&*step)) Write(*file);
}

std::vector<InputEvent> ScriptedSurface::TakeEvents(double patience_s) {
  if (++frames_ > kFramesBetween && !look_) {
    if (auto step = script_->Next()) {
      frames_ = 0;
      if (auto* keys = std::get_if<DisplayScript::Keys>(&*step))
        for (const InputEvent& key : *keys) Push(key);
      else
        look_ = std::get<DisplayScript::Look>(*step);
    }
  }
  return OffscreenSurface::TakeEvents(patience_s);
}

void ScriptedSurface::Present() {
  OffscreenSurface::Present();
  if (look_) Write(*std::exchange(look_, std::nullopt));
}

void ScriptedSurface::Write(const std::filesystem::path& file) {
  bool written = false;
  try {
    Bind();
    written = cv::imwrite(file.string(), Read());
  } catch (const std::exception&) {
  }
  fmt::print(stderr, "look {}: {}\n", file.string(), written ? "written" : "cannot be written");
}

}  // namespace ulf
