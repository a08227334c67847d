#include "coverage/session/preflight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/counted.h"
#include "core/base/error.h"

namespace ulf::coverage {
namespace {

// Names of items that Check() treats apart.
constexpr double kUselessClippedShare = 0.9;  // more of the subject clipped holds the start. Guessed.
constexpr double kLeastViews = 10;            // room on disk for fewer holds the start. Guessed.
constexpr const char *kCalibration = "calibration", *kTracking = "tracking";

// Returns what is the matter and, where a camera is in the hand, what to do.
std::string AndToDo(FrameSource source, const std::string& finding, const std::string& to_do) {
  return IsTaken(source) ? finding : finding + to_do;
}

// A warning: pictures that an automatic has changed are matched afterwards, and not every camera can be
// without.
PreflightItem Automatic(FrameSource source, const char* name, const std::optional<bool>& held) {
  if (!held)
    return {name,
            {},
            IsTaken(source) ? "not known of pictures that are taken already"
                            : "the camera does not report it; set it by hand before the capture"};
  return {.name = name,
          .in_order = held,
          .words = *held ? "held"
                         : AndToDo(source, "changes by itself between pictures",
                                   fmt::format(": switch its automatic off ({})", WhereToSet(source))),
          .holds_start = false};
}

// Returns what the pictures show of a mistake; none: nothing.
std::optional<PreflightItem> Noticed(const PreflightInput& input, Mistake mistake, const char* name) {
  const auto noticed = std::ranges::find(input.mistakes, mistake, &NoticedMistake::mistake);
  if (noticed == input.mistakes.end()) return std::nullopt;
  return PreflightItem{.name = name,
                       .in_order = false,
                       .words = noticed->finding + ". " + noticed->cure,
                       .holds_start = false};
}

PreflightItem Exposure(const PreflightInput& input) {
  PreflightItem item = Automatic(input.source, "exposure", input.held.exposure);
  if (item.in_order == false) return item;
  return Noticed(input, Mistake::kAutoExposure, "exposure").value_or(std::move(item));
}

// Holds the start where the pictures are worth nothing for certain; a black thing, or one before white, is
// not.
PreflightItem Light(const PreflightInput& input) {
  if (!input.picture.light) return {"light", {}, "not measured yet"};
  const SubjectLight& light = *input.picture.light;
  const bool is_of_subject = input.picture.is_of_subject;
  const char* where = is_of_subject ? "the subject's circle" : "the middle of the picture";
  // By Decide(), which looks at the same circle. To begin is allowed: where the subject is bright in other
  // views they are recorded.
  const char* consequence = is_of_subject ? "; no view is recorded while it is so" : "";
  const auto too_dark = [&](const char* most_of, double begins, bool holds) -> PreflightItem {
    return {"light", false,
            AndToDo(input.source,
                    fmt::format("too dark: {} of {} are below {:.0f} % of full scale", most_of, where,
                                100 * begins),
                    "; add light, open the aperture, or expose longer") +
                consequence,
            holds};
  };
  if (light.brightest_hundredth < kLeastBrightest)
    return too_dark("99 hundredths", light.brightest_hundredth, true);
  if (light.brightest_tenth < kLeastBrightest) return too_dark("nine tenths", light.brightest_tenth, false);
  const bool is_white = light.clipped_share > kUselessClippedShare;
  if (light.clipped_share > kMostClippedShare)
    return {"light", false,
            AndToDo(input.source,
                    fmt::format("too bright: {:.0f} % of {} are clipped", 100 * light.clipped_share, where),
                    "; expose less") +
                consequence,
            is_white};
  return {"light", true, fmt::format("the brightest tenth is above {:.0f} %", 100 * light.brightest_tenth)};
}

PreflightItem Focus(const PreflightInput& input) {
  const std::optional<double>& detail = input.picture.fine_detail;
  if (detail && *detail < kLeastFineDetail)
    return {"focus", false,
            AndToDo(input.source,
                    fmt::format("blurred: fine detail is {:.2f} of the coarser, {:g} are needed", *detail,
                                kLeastFineDetail),
                    "; focus on the subject, and move slowly")};
  PreflightItem item = Automatic(input.source, "focus", input.held.focus);
  if (item.in_order != false)
    if (auto hunts = Noticed(input, Mistake::kFocusHunts, "focus")) return *hunts;
  if (detail && !item.in_order) item.words = "sharp now; " + item.words;
  return item;
}

// A warning at most: ulf refine --intrinsics finds the lens of what was recorded.
PreflightItem Calibration(const PreflightInput& input) {
  PreflightItem item{.name = kCalibration, .in_order = input.calibrated, .words = {}, .holds_start = false};
  if (input.lens_found) {
    item.in_order = true;
    item.words = "found from the images: " + input.lens_found->Text();
  } else if (input.lens_is_sought && input.calibrated != true) {
    item.words =
        fmt::format("{}: the lens is found {}; what is recorded before follows", input.calibration_source,
                    IsTaken(input.source) ? "as pictures from other places come"
                                          : "while the camera moves sideways, up and down");
  } else if (input.lens_contradicted && !input.lens_is_sought) {
    item.in_order = false;
    item.words = fmt::format(
        "contradicted: {}; {}, or begin again with {} refine", input.lens_contradicted->Text(),
        IsTaken(input.source) ? "give their camera's calibration" : "calibrate", Parameter("intrinsics"));
  } else if (!input.calibrated) {
    item.words = "not known";
  } else {
    item.words =
        *input.calibrated
            ? input.calibration_source
            : fmt::format(
                  "only a focal length, the lens's distortion is not known: {}",
                  IsTaken(input.source)
                      ? fmt::format("give their camera's calibration ({}), or have it found ({} refine)",
                                    Parameter("calibration"), Parameter("intrinsics"))
                      : "calibrate the camera (ulf board, ulf calibrate)");
  }
  return item;
}

PreflightItem Disk(const PreflightInput& input) {
  constexpr char kWayOut[] = ": free some space, or write to another disk";
  constexpr double kLeastSaid_gb = 0.1;
  if (!input.disk_left_bytes) return {"disk", {}, "the free space is not known"};
  const double left_gb = 1e-9 * static_cast<double>(*input.disk_left_bytes);
  const double view_gb = 1e-9 * static_cast<double>(input.bytes_per_view);
  if (!input.prediction || !input.prediction->views) {
    if (!(view_gb > 0)) return {"disk", {}, fmt::format("{:.1f} GB free", left_gb)};
    const double views = std::floor(left_gb / view_gb);
    const bool is_full = views < kLeastViews;
    return {"disk", is_full ? std::optional(false) : std::nullopt,
            fmt::format("{:.1f} GB free, room for at least {}{}", left_gb,
                        Counted(std::lround(views), "view"), is_full ? kWayOut : "")};
  }
  const double needed_gb = input.prediction->views->most * view_gb;
  return {"disk", needed_gb <= left_gb,
          fmt::format("{:.1f} GB free, {} take up to {:.1f} GB{}", left_gb, InWords(*input.prediction->views),
                      std::max(needed_gb, kLeastSaid_gb), needed_gb <= left_gb ? "" : kWayOut)};
}

// Warnings: a frame that is lost is no view, and the hand passes there again.
void AddLink(const std::vector<acquisition::LinkFact>& facts, std::vector<PreflightItem>& items) {
  if (facts.empty()) return;
  const std::size_t before = items.size();
  for (const acquisition::LinkFact& fact : facts)
    if (!fact.in_order)
      items.push_back({.name = fact.name,
                       .in_order = false,
                       .words = fmt::format("{}: {}", fact.value, fact.advice),
                       .holds_start = false});
  if (items.size() > before) return;
  const auto rate =
      std::ranges::find_if(facts, [](const auto& fact) { return fact.name == acquisition::kRateFact; });
  items.push_back({"link", true, rate == facts.end() ? facts.front().value : rate->value});
}

}  // namespace

std::vector<PreflightItem> Preflight(const PreflightInput& input) {
  std::vector<PreflightItem> items{Calibration(input)};
  items.push_back(Light(input));
  items.push_back(Exposure(input));
  items.push_back(Automatic(input.source, "white balance", input.held.white_balance));
  items.push_back(Focus(input));
  for (const Mistake mistake : {Mistake::kFlicker, Mistake::kUnsteadyLight})
    if (auto lamps = Noticed(input, mistake, "lamps")) items.push_back(std::move(*lamps));
  if (auto dust = Noticed(input, Mistake::kDust, "lens")) items.push_back(std::move(*dust));
  items.push_back(Disk(input));
  AddLink(input.link, items);
  if (input.prediction)
    if (const auto doubt = ThresholdWarning(*input.prediction, input.cap, input.source))
      items.push_back({.name = "views", .in_order = false, .words = *doubt, .holds_start = false});
  if (!input.has_pose) {
    items.push_back({kTracking, false,
                     "the camera's pose is not known" +
                         (input.tracking_words.empty() ? "" : ": " + input.tracking_words)});
    return items;
  }
  if (!input.pose_error_px) {
    items.push_back({kTracking, true, input.prediction ? "poses are given" : "the camera's pose is known"});
    return items;
  }
  const bool healthy = *input.pose_error_px <= kMostPoseErrorPx;
  items.push_back({kTracking, healthy,
                   AndToDo(input.source,
                           fmt::format("pose error moves the subject by {:.2g} px (limit {:g} px)",
                                       *input.pose_error_px, kMostPoseErrorPx),
                           healthy ? "" : ": move slowly, sideways, with more texture in view")});
  return items;
}

std::string HoldsInWords(const std::vector<PreflightItem>& items) {
  std::string words;
  for (const PreflightItem& item : items)
    if (item.in_order == false && item.holds_start)
      words += fmt::format("{}{}: {}", words.empty() ? "" : "; ", item.name, item.words);
  return words;
}

void PreflightReporter::Expect(const CriterionSetup& setup, const std::optional<Cap>& cap, double until_share,
                               bool metric, FrameSource source) {
  prediction_ = Predict(setup, cap, until_share);
  until_share_ = until_share;
  if (prediction_) say_(InWords(*prediction_, setup.threshold_px, metric, source));
}

void PreflightReporter::Check(PreflightInput input) {
  constexpr int kPatience_checks = 30;  // frames, in which every camera is still to be found; guessed
  input.prediction = prediction_;
  preflight_ = Preflight(input);
  checks_without_pose_ = input.has_pose ? 0 : checks_without_pose_ + 1;
  const bool may_be_tracked =
      prediction_ || (input.without_subject && checks_without_pose_ >= kPatience_checks);
  for (const PreflightItem& item : preflight_) {
    const bool said_elsewhere =
        (item.name == kTracking && !may_be_tracked) || (item.name == kCalibration && input.lens_contradicted);
    if (item.in_order != false || said_elsewhere) continue;
    if (said_.insert(item.name).second)
      say_(
          fmt::format("before the first {}view: {}: {}", input.resumed ? "new " : "", item.name, item.words));
  }
}

std::optional<double> PreflightReporter::ViewsExpected(std::size_t recorded, const CoverageMap* map) const {
  if (!prediction_ || !prediction_->views || !map) return std::nullopt;
  return static_cast<double>(recorded) +
         std::max(0.0, 1 - map->CoveredShare() / until_share_) * prediction_->views->usual;
}

}  // namespace ulf::coverage
