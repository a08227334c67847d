#include "commands/capture/capture_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "commands/camera/device_report.h"
#include "core/base/counted.h"

namespace ulf::commands {
namespace {

const char* InWords(coverage::StoppedBecause why) {
  switch (why) {
    case coverage::StoppedBecause::kCovered:
      return "the cap is covered";
    case coverage::StoppedBecause::kFrames:
      return "--frames is reached";
    case coverage::StoppedBecause::kSeconds:
      return "--max-seconds is reached";
    case coverage::StoppedBecause::kEnded:
      return "the device has no more frames";
    case coverage::StoppedBecause::kSignal:
      return "asked to";
    case coverage::StoppedBecause::kDeviceLost:
      return "the device is lost";
    case coverage::StoppedBecause::kDisk:
      return "the disk";
    case coverage::StoppedBecause::kClosed:
      return "finished by request";
  }
  return "";
}

const char* WayOut(coverage::Reason reason) {
  switch (reason) {
    case coverage::Reason::kTracking:
      return "the pose was too uncertain, or there were too few frames to place the subject; move slowly "
             "sideways, with the subject in view";
    case coverage::Reason::kCovered:
      return "every frame showed what recorded views show already";
    case coverage::Reason::kBehind:
      return "the subject lies behind the camera: turn round, or correct --subject (x to the right, y down, "
             "z forward from where the world begins)";
    case coverage::Reason::kOutsideRectangle:
    case coverage::Reason::kInsideSphere:
      return "the subject was not wholly in view; aim at it, step back, or make its sphere smaller "
             "(--subject-size, or the radius of --subject)";
    case coverage::Reason::kBlur:
      return "every frame was blurred; move slower, or expose shorter";
    case coverage::Reason::kExposure:
      return "the subject was clipped or black; set the exposure (ulf features)";
    case coverage::Reason::kUnsettled:
      return "the exposure never came to rest; switch the camera's automatics off (ulf features), or keep "
             "the light steady";
    case coverage::Reason::kSpeed:
      return "the camera moved too fast for its exposure time; move slower, or expose shorter";
    case coverage::Reason::kSpool:
      return "the disk did not keep up; write to a faster one";
    case coverage::Reason::kDisk:
      return "the disk was full; free some space, or write to another one";
    case coverage::Reason::kPaused:
      return "recording was paused by request and never asked for again (record)";
    case coverage::Reason::kStill:
      return "photographs were asked for and none was recorded; see what the camera said above";
    case coverage::Reason::kRecorded:
      break;
  }
  return "";
}

}  // namespace

std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked) {
  std::string text = fmt::format("device         {}\n", ToText(summary.device));
  if (summary.pauses > 0)
    text += fmt::format("disk           recording paused {}, {:.1f} s in all\n",
                        Counted(summary.pauses, "time"), summary.paused_s);
  text += fmt::format("this session   {}, {} tracked, {} recorded\n", Counted(summary.frames, "frame"),
                      tracked, summary.recorded);
  if (summary.taken_back > 0)
    text += fmt::format("taken back     {}, kept in unposed/\n", Counted(summary.taken_back, "view"));
  text += fmt::format("time           tracking {:.1f} ms, decision {:.3f} ms a frame (medians)\n",
                      summary.ms_track_median, summary.ms_decide_median);
  if (summary.stills.asked + summary.stills.arrived > 0)
    text += fmt::format(
        "photographs    {} asked for, {} arrived, {} recorded; kept in unposed/: {} not needed by then, {} "
        "without a pose\n",
        summary.stills.asked, summary.stills.arrived, summary.stills.recorded, summary.stills.not_needed,
        summary.stills.without_pose);
  if (summary.stills.lag_s)
    text += fmt::format("shutter lag    {:.0f} ms (median of {}, by where the photographs were taken)\n",
                        1e3 * *summary.stills.lag_s, summary.stills.lags);
  if (summary.calibration && summary.calibration->wrong)
    text += fmt::format("calibration    {}\n", summary.calibration->Advice());
  if (summary.rolling_shutter) text += fmt::format("shutter        {}\n", summary.rolling_shutter->InWords());
  return text + fmt::format("ended          {}\n", InWords(summary.stopped_because));
}

void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked) {
  json["frames"] = summary.frames;
  json["recorded"] = summary.recorded;
  json["taken_back"] = summary.taken_back;
  json["tracked"] = tracked;
  if (summary.stills.asked + summary.stills.arrived > 0)
    json["photographs"] = {
        {"asked", summary.stills.asked},
        {"arrived", summary.stills.arrived},
        {"recorded", summary.stills.recorded},
        {"not_needed", summary.stills.not_needed},
        {"without_pose", summary.stills.without_pose},
        {"shutter_lags", summary.stills.lags},
        {"shutter_lag_ms",
         summary.stills.lag_s ? nlohmann::json(1e3 * *summary.stills.lag_s) : nlohmann::json(nullptr)}};
  json["ms_track_median"] = summary.ms_track_median;
  json["ms_decide_median"] = summary.ms_decide_median;
  json["stopped_because"] = Name(summary.stopped_because);
  json["device"] = ToJson(summary.device);
  json["events"] = summary.events;
  json["pauses"] = summary.pauses;
  json["paused_s"] = summary.paused_s;
  json["unwritten"] = summary.unwritten;
  json["calibration"] = ToJson(summary.calibration);
  json["rolling_shutter"] = ToJson(summary.rolling_shutter);
  json["set_aside"] = nlohmann::json::object();
  for (const auto& [folder, count] : summary.set_aside) json["set_aside"][folder.string()] = count;
}

std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked) {
  if (summary.frames == 0) return "nothing was recorded: no complete frame came";
  if (tracked == 0)
    return fmt::format(
        "nothing was recorded: the camera's position was found in none of {}; move it slowly sideways, so "
        "that near and far things shift against each other",
        Counted(summary.frames, "frame"));
  const auto commonest = std::max_element(summary.reasons.begin(), summary.reasons.end());
  const auto reason = static_cast<coverage::Reason>(commonest - summary.reasons.begin());
  return fmt::format("nothing was recorded: for {} of {} the reason was '{}': {}", *commonest,
                     Counted(summary.frames, "frame"), InWords(reason), WayOut(reason));
}

std::string FewRecordedReason(const coverage::CaptureSummary& summary) {
  constexpr double kFew = 0.2, kMost = 0.5;
  const bool as_wanted =
      summary.stopped_because == coverage::StoppedBecause::kCovered || summary.recorded == 0;
  if (as_wanted) return {};
  const auto count = [&](coverage::Reason reason) {
    return summary.reasons[static_cast<std::size_t>(reason)];
  };
  const auto is_elsewhere = [](coverage::Reason reason) {
    return reason == coverage::Reason::kOutsideRectangle || reason == coverage::Reason::kInsideSphere ||
           reason == coverage::Reason::kBehind;
  };
  std::uint64_t refused = 0, elsewhere = 0;
  coverage::Reason commonest = coverage::Reason::kRecorded;
  std::string words_elsewhere;
  for (const coverage::Reason reason : coverage::kReasons) {
    const bool stands_in_the_way = reason != coverage::Reason::kRecorded &&
                                   reason != coverage::Reason::kCovered &&
                                   reason != coverage::Reason::kStill && reason != coverage::Reason::kPaused;
    if (!stands_in_the_way || count(reason) == 0) continue;
    refused += count(reason);
    if (is_elsewhere(reason)) {
      elsewhere += count(reason);
      words_elsewhere += fmt::format("{}'{}'", words_elsewhere.empty() ? "" : " or ", InWords(reason));
    } else if (commonest == coverage::Reason::kRecorded || count(reason) > count(commonest)) {
      commonest = reason;
    }
  }
  const auto not_covered = static_cast<double>(summary.frames - count(coverage::Reason::kCovered));
  if (static_cast<double>(summary.recorded) >= kFew * not_covered ||
      static_cast<double>(refused) < kMost * static_cast<double>(summary.frames))
    return {};
  const std::string few =
      fmt::format("only {} of {} recorded: for", summary.recorded, Counted(summary.frames, "frame"));
  if (elsewhere == 0 || (commonest != coverage::Reason::kRecorded && count(commonest) > elsewhere))
    return fmt::format("{} {} the reason was '{}': {}", few, count(commonest), InWords(commonest),
                       WayOut(commonest));
  return fmt::format(
      "{} {} the reason was {}: the camera did not go round the subject{}. If that is not what you want to "
      "capture, say where it is: ulf track URI -o poses.txt, then --poses tum:poses.txt --subject "
      "x,y,z,radius; for posed photographs of a walk give --no-subject",
      few, elsewhere, words_elsewhere,
      summary.subject_was_found ? ", which was placed by itself in the middle of the first pictures" : "");
}

}  // namespace ulf::commands
