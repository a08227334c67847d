#include "acquisition/gphoto2/camera_bracket.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;
using Lookup = std::function<std::optional<CameraFeature>(const std::string&)>;

constexpr double kSameStep = 0.05;  // stops: cameras write 0.3 and 1/3 for the same
// Between two tries to write a setting; doubled each time. Guessed, as the tries before the thread ends.
constexpr std::chrono::milliseconds kFirstPause(25), kLongestPause(800);
constexpr int kLastTries = 6;
constexpr int kCanonExposures =
    3;  // a custom function of the camera, which the driver does not show, may say otherwise

bool IsNear(double a, double b) { return std::abs(a - b) < kSameStep; }

// "2 EV", "2/3 EV", "+/- 1 1/3", "1.0 Steps"; none: no number of stops.
std::optional<double> StopsIn(const std::string& text) {
  std::size_t at = text.find_first_of("0123456789");
  if (at == std::string::npos || Lowercase(text).starts_with("unknown")) return std::nullopt;
  double stops = 0;
  while (at != std::string::npos) {
    char* end = nullptr;
    double number = std::strtod(text.c_str() + at, &end);
    if (*end == '/') {
      const double below = std::strtod(end + 1, &end);
      if (!(below > 0)) return std::nullopt;
      number /= below;
    }
    stops += number;
    const auto next = static_cast<std::size_t>(end - text.c_str());
    at = *end == ' ' && next + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[next + 1]))
             ? next + 1
             : std::string::npos;
  }
  return stops;
}

// Returns the step of a symmetric bracket with equal steps; none for any other.
std::optional<double> StepOf(std::vector<double> stops) {
  stops.push_back(0);
  std::ranges::sort(stops);
  const std::size_t middle = stops.size() / 2;
  if (stops.size() < 3 || stops.size() % 2 == 0) return std::nullopt;
  const double step = stops[middle + 1] - stops[middle];
  for (std::size_t i = 0; i < stops.size(); ++i)
    if (!IsNear(stops[i], (static_cast<double>(i) - static_cast<double>(middle)) * step)) return std::nullopt;
  return step;
}

// Adds a value that a setting is to have. False: the camera does not have it, or does not let it be written.
class Plan {
 public:
  explicit Plan(const Lookup& lookup) : lookup_(lookup) {}

  bool Choose(const std::string& name, const std::function<bool(const std::string&)>& fits) {
    const auto setting = lookup_(name);
    if (!setting) return false;
    if (fits(setting->value)) return true;
    const auto choice = std::ranges::find_if(setting->choices, fits);
    if (choice == setting->choices.end() || !setting->writable) return false;
    values_.emplace_back(name, *choice);
    return true;
  }
  bool Count(const std::string& name, int count) {
    const auto setting = lookup_(name);
    if (!setting || setting->type != FeatureType::kFloat) return false;
    if (std::atof(setting->value.c_str()) == count) return true;
    if (!setting->writable || count < *setting->min || count > *setting->max) return false;
    values_.emplace_back(name, fmt::format("{}", count));
    return true;
  }
  // The driver shows it and does not write it.
  bool IsCount(const std::string& name, int count) const {
    const auto setting = lookup_(name);
    return setting && std::atof(setting->value.c_str()) == count;
  }
  bool Has(const std::string& name) const { return lookup_(name).has_value(); }
  std::vector<NamedValue> Take() { return std::move(values_); }
  std::size_t Size() const { return values_.size(); }
  void CutTo(std::size_t size) { values_.resize(size); }

 private:
  const Lookup& lookup_;
  std::vector<NamedValue> values_;
};

// "5 images (normal, 2 unders and 2 overs)", and not those that go to one side only.
bool IsEvenPattern(const std::string& text, int exposures) {
  return text.starts_with(Counted(exposures, "image")) && text.find("under") != std::string::npos &&
         text.find("over") != std::string::npos;
}

}  // namespace

std::optional<CameraBracketPlan> PlanCameraBracket(const std::vector<double>& stops, const Lookup& setting) {
  const std::optional<double> step = StepOf(stops);
  if (!step) return std::nullopt;
  const int exposures = static_cast<int>(stops.size()) + 1;
  const auto is_step = [&](const std::string& text) {
    const std::optional<double> of_text = StopsIn(text);
    return of_text && IsNear(*of_text, *step);
  };
  const auto is = [](const char* word) {
    return [word](const std::string& text) { return Lowercase(text) == word; };
  };
  Plan plan(setting);
  if (plan.Has("aeb")) {
    if (exposures != kCanonExposures || !plan.Choose("aeb", is_step)) return std::nullopt;
    if (plan.Has("drivemode") && !plan.Choose("drivemode", is("single"))) return std::nullopt;
    return CameraBracketPlan{plan.Take(), exposures, false};
  }
  if (plan.Has("bracketset") && !plan.Choose("bracketset", is("ae only"))) return std::nullopt;
  const auto is_pattern = [&](const std::string& text) { return IsEvenPattern(text, exposures); };
  if (!plan.Choose("aebracketingstep", is_step) ||
      !(plan.Choose("aebracketingpattern", is_pattern) || plan.IsCount("aebracketingcount", exposures)))
    return std::nullopt;
  const std::size_t of_single = plan.Size();
  const bool one_release = plan.Count("burstnumber", exposures) && plan.Choose("capturemode", is("burst"));
  if (!one_release) plan.CutTo(of_single);
  // Last, so that nothing is bracketed by half of the settings.
  if (!plan.Choose("bracketing", is("on"))) return std::nullopt;
  return CameraBracketPlan{plan.Take(), exposures, one_release};
}

bool CameraBracket::Begin(const std::vector<double>& stops) {
  has_refused_ = false;
  middle_s_ = settings_.Number(ShotSetting::kShutter).value_or(0);
  if (is_useless_ || middle_s_ <= 0) return false;
  auto plan = PlanCameraBracket(stops, [this](const std::string& name) { return camera_.Setting(name); });
  if (!plan) return false;
  stops_ = stops;
  stops_.push_back(0);
  to_come_ = plan->exposures;
  one_release_ = plan->one_release;
  before_.clear();
  to_write_.clear();
  for (NamedValue& value : plan->settings) {
    const auto now = camera_.Setting(value.first);
    if (!now) return false;
    before_.emplace_front(value.first, now->value);
    to_write_.push_back(std::move(value));
  }
  is_running_ = true;
  return true;
}

// Returns false when the camera is busy, or refuses.
bool CameraBracket::Write() {
  if (Clock::now() < again_) return false;
  const auto& [name, value] = to_write_.front();
  const GphotoResult result = camera_.Set(name, value);
  if (result.ok()) {
    to_write_.pop_front();
    refused_since_.reset();
    return true;
  }
  if (!refused_since_) {
    refused_since_ = Clock::now();
    pause_ = kFirstPause;
  }
  again_ = Clock::now() + pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
  // The driver reports a busy camera as bad parameters here.
  if (SecondsSince(*refused_since_) < busy_s_) return false;
  refused_since_.reset();
  if (to_come_ > 0) {
    notice_(fmt::format("the camera does not take {}={} ({}): ulf sets the shutter of each exposure itself",
                        name, value, result.text));
    to_come_ = 0;
    is_useless_ = has_refused_ = true;
    to_write_ = std::exchange(before_, {});  // what was not written is as it was
  } else {
    notice_(
        fmt::format("{} could not be put back ({}): set it to {} on the camera", name, result.text, value));
    to_write_.pop_front();
  }
  return false;
}

int CameraBracket::Next() {
  while (!to_write_.empty())
    if (!Write()) return 0;
  if (to_come_ > 0) {
    const int now = one_release_ ? to_come_ : 1;
    to_come_ -= now;
    return now;
  }
  to_write_ = std::exchange(before_, {});
  is_running_ = !to_write_.empty();
  return 0;
}

std::optional<double> CameraBracket::StopsOf(const std::optional<double>& told_s) {
  if (!told_s) {
    if (!std::exchange(is_useless_, true))
      notice_(
          "the camera's photographs do not tell their exposure time: its own bracketing is not used any "
          "more");
    return std::nullopt;
  }
  const double off = std::log2(*told_s / middle_s_);
  const auto nearest =
      std::ranges::min_element(stops_, {}, [&](const double each) { return std::abs(each - off); });
  constexpr double kMostOff = 0.34;  // stops: a third, by which cameras round
  if (std::abs(*nearest - off) < kMostOff) return *nearest;
  notice_(fmt::format(
      "a photograph of {:g} s came in a bracket about {:g} s: it is none of the exposures asked for", *told_s,
      middle_s_));
  return std::nullopt;
}

void CameraBracket::GiveUp(bool camera_is_gone) {
  if (!is_running_) return;
  is_running_ = false;
  std::deque<NamedValue> put_back = before_.empty() ? to_write_ : before_;
  for (int i = 0; i < kLastTries && !camera_is_gone && !put_back.empty(); ++i) {
    while (!put_back.empty() && camera_.Set(put_back.front().first, put_back.front().second).ok())
      put_back.pop_front();
    if (!put_back.empty()) std::this_thread::sleep_for(kFirstPause * (1 << i));
  }
  std::string words;
  for (const auto& [name, value] : put_back)
    words += fmt::format("{}{} to {}", words.empty() ? "" : ", ", name, value);
  if (!words.empty()) notice_(fmt::format("a bracket was not taken to its end: set {} on the camera", words));
}

}  // namespace ulf::acquisition
