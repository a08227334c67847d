#include "commands/capture/capture_report.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "commands/reports/device_report.h"
#include "commands/reports/lens_report.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "render/proxy/mesh_file.h"

namespace ulf::commands {
namespace {

const char* InWords(coverage::StoppedBecause why) {
  constexpr std::array kWords{"the cap is covered",
                              "--frames is reached",
                              "--max-seconds is reached",
                              "the device has no more frames",
                              "asked to",
                              "the device is lost",
                              "the disk",
                              "finished by request"};
  return kWords[static_cast<std::size_t>(why)];
}

// Says what prevented views and, for a hand-held camera, what to do the next time; advice about options is
// given for finished pictures, too.
std::string WayOut(coverage::Reason reason, FrameSource source) {
  using enum coverage::Reason;
  struct Words {
    std::string finding, in_hand, taken;
  };
  const auto words = [&]() -> Words {
    switch (reason) {
      case kTracking:
        return {"the pose was too uncertain, or there were too few frames to place the subject",
                "move slowly sideways, with the subject in view",
                "give frames that follow each other more closely, or poses that are known (--poses)"};
      case kCovered:
        return {"every frame showed what recorded views show already", "", ""};
      case kBehind:
        return {"the subject lies behind the camera",
                "turn round, or correct --subject (x to the right, y down, z forward from where the world "
                "begins)",
                "correct --subject (x to the right, y down, z forward from where the world begins)"};
      case kOutsideRectangle:
      case kInsideSphere:
        return {
            "the subject was not wholly in view",
            "aim at it, step back, or make its sphere smaller (--subject-size, or the radius of --subject)",
            "make its sphere smaller (--subject-size, or the radius of --subject)"};
      case kBlur:
        return {"every frame was blurred", "move slower, or expose shorter", ""};
      case kExposure:
        return {"the subject was clipped or black", fmt::format("set the exposure ({})", WhereToSet(source)),
                ""};
      case kUnsettled:
        return {"the exposure never came to rest",
                fmt::format("switch the camera's automatics off ({}), or keep the light steady",
                            WhereToSet(source)),
                ""};
      case kSpeed:
        return {"the camera moved too fast for its exposure time", "move slower, or expose shorter", ""};
      case kSpool:
        return {"the disk did not keep up", "write to a faster one",
                "write to a faster one, or play it more slowly (--speed 0.5)"};
      case kDisk:
        return {"the disk was full", "free some space, or write to another one",
                "free some space, or write to another one"};
      case kPaused:
        return {"recording was paused by request and never resumed (record)", "", ""};
      case kZoomed:
        return {"the zoom was moved while capturing, or another lens is mounted",
                "fix the zoom (tape), calibrate at that focal length, and begin anew",
                "capture the part before it, with that lens's calibration"};
      case kBracket:
        return {"other exposures of views were taken all the time", "bracket fewer, or expose shorter",
                "bracket fewer"};
      case kStill:
        return {"photographs were asked for and none was recorded", "see what the camera said above",
                "the recording holds none at the places that need one"};
      case kRecorded:
        break;
    }
    return {};
  }();
  const std::string& to_do = IsTaken(source) ? words.taken : words.in_hand;
  return to_do.empty() ? words.finding : words.finding + "; " + to_do;
}

// Returns "the reason was 'blurred': every frame was blurred; move slower, or expose shorter", or the mistake
// behind it.
std::string ReasonAndWayOut(coverage::Reason reason, const coverage::CaptureSummary& summary) {
  const coverage::NoticedMistake* mistake = MistakeForReason(reason, summary.mistakes);
  if (!mistake)
    return fmt::format("the reason was '{}': {}", InWords(reason), WayOut(reason, summary.source));
  return fmt::format("the reason was '{}': {}. {}", Name(mistake->mistake), mistake->finding, mistake->cure);
}

// Says what the tracker needs, if the user can still provide it.
const char* ToBeTracked(FrameSource source) {
  switch (source) {
    case FrameSource::kRecording:
      return "it is found where a camera moves and not only turns, so that near and far things shift against "
             "each other; give a part of the recording where it does, or poses that are known (--poses)";
    case FrameSource::kPhotographs:
      return "pictures are followed from one to the next: give them in order, from places that differ a "
             "little and show mostly the same; or have them posed in any order (ulf import FOLDER --pose -o "
             "DIR)";
    case FrameSource::kSettableCamera:
    case FrameSource::kCamera:
      break;
  }
  return "move it slowly sideways, so that near and far things shift against each other";
}

std::string GeometryLines(const coverage::FinishedGeometry& geometry, const std::string& dir) {
  if (!geometry.mesh)
    return fmt::format("geometry       no mesh: the views agree on no surface yet ({})\n",
                       Counted(geometry.maps, "depth map"));
  std::string text = fmt::format("geometry       {} of {}, {:.1f} s after the last frame: proxy.ply",
                                 Counted(geometry.mesh->mesh->triangles.size(), "triangle"),
                                 Counted(geometry.maps, "depth map"), geometry.seconds);
  text += geometry.written_maps > 0 ? fmt::format(", {} in depth/\n", geometry.written_maps) : "\n";
  if (geometry.missing_maps > 0)
    text += fmt::format("               there was no time for {}; '{}' makes them all\n",
                        Counted(geometry.missing_maps, "more depth map"), render::ProxyCommand(dir));
  return text;
}

}  // namespace

std::string ToText(const coverage::CaptureSummary& summary, std::size_t tracked, const std::string& dir) {
  std::string text = fmt::format("device         {}\n", ToText(summary.device));
  if (summary.pauses > 0)
    text += fmt::format("disk           recording paused {}, {:.1f} s in all\n",
                        Counted(summary.pauses, "time"), summary.paused_s);
  text += fmt::format("this session   {}, {} tracked, {} recorded\n", Counted(summary.frames, "frame"),
                      tracked, summary.recorded);
  if (summary.taken_back > 0)
    text += fmt::format("taken back     {}, kept in unposed/\n", Counted(summary.taken_back, "view"));
  if (summary.kept_apart > 0)
    text += fmt::format(
        "apart          {} of a place that the map did not reach, in unposed/; 'ulf refine {} --unposed' "
        "looks for where they were taken\n",
        Counted(summary.kept_apart, "picture"), ShellWord(dir));
  text +=
      fmt::format("time           tracking {:.1f} ms, decision {:.3f} ms{} a frame (medians)\n",
                  summary.ms_track_median, summary.ms_decide_median,
                  summary.measured ? fmt::format(", measuring {:.0f} ms", summary.measured->ms_median) : "");
  if (summary.stills.asked + summary.stills.arrived > 0)
    text += fmt::format(
        "photographs    {} asked for, {} arrived, {} recorded; kept in unposed/: {} not needed by then, {} "
        "without a pose\n",
        summary.stills.asked, summary.stills.arrived, summary.stills.recorded, summary.stills.not_needed,
        summary.stills.without_pose);
  if (summary.stills.lag_s)
    text += fmt::format("shutter lag    {:.0f} ms (median of {}, by where the photographs were taken)\n",
                        1e3 * *summary.stills.lag_s, summary.stills.lags);
  if (summary.brackets.views > 0)
    text += fmt::format(
        "brackets       {} of {}, {} with a pose between those of other frames{}\n",
        Counted(summary.brackets.exposures, "other exposure"), Counted(summary.brackets.views, "view"),
        summary.brackets.between,
        summary.brackets.incomplete > 0
            ? fmt::format("; {} without all of theirs", Counted(summary.brackets.incomplete, "view"))
            : "");
  if (summary.geometry && (summary.geometry->mesh || summary.recorded > 0))
    text += GeometryLines(*summary.geometry, dir);
  if (summary.refined_lens)
    text += fmt::format("lens           {}, found from the images\n               {}\n",
                        summary.refined_lens->Text(), LensSigmaWords(summary.source));
  if (summary.calibration && summary.calibration->Wrong())
    text += fmt::format("calibration    {}\n", summary.calibration->Advice(summary.source));
  for (const coverage::NoticedMistake& noticed : summary.mistakes) {
    using enum coverage::Mistake;
    const bool has_a_line =
        noticed.mistake == kRollingShutter || (noticed.mistake == kWrongLens && summary.calibration);
    if (!has_a_line)
      text += fmt::format("mistake        {} (from {:.0f} s on)\n", noticed.InWords(), noticed.first_s);
  }
  if (summary.rolling_shutter) text += fmt::format("shutter        {}\n", summary.rolling_shutter->InWords());
  return text + fmt::format("ended          {}\n", InWords(summary.stopped_because));
}

void AddTo(nlohmann::json& json, const coverage::CaptureSummary& summary, std::size_t tracked) {
  json["frames"] = summary.frames;
  json["recorded"] = summary.recorded;
  json["taken_back"] = summary.taken_back;
  json["kept_apart"] = summary.kept_apart;
  json["tracked"] = tracked;
  if (summary.stills.asked + summary.stills.arrived > 0)
    json["photographs"] = {
        {"asked", summary.stills.asked},
        {"arrived", summary.stills.arrived},
        {"recorded", summary.stills.recorded},
        {"not_needed", summary.stills.not_needed},
        {"without_pose", summary.stills.without_pose},
        {"shutter_lags", summary.stills.lags},
        {"shutter_lag_ms", summary.stills.lag_s ? nlohmann::json(1e3 * *summary.stills.lag_s) : nullptr}};
  if (summary.brackets.views > 0)
    json["brackets"] = {{"views", summary.brackets.views},
                        {"incomplete", summary.brackets.incomplete},
                        {"exposures", summary.brackets.exposures},
                        {"poses_between", summary.brackets.between}};
  json["ms_track_median"] = summary.ms_track_median;
  json["ms_decide_median"] = summary.ms_decide_median;
  json["stopped_because"] = Name(summary.stopped_because);
  json["device"] = ToJson(summary.device);
  json["events"] = summary.events;
  json["pauses"] = summary.pauses;
  json["paused_s"] = summary.paused_s;
  json["unwritten"] = summary.unwritten;
  json["geometry"] = nullptr;
  if (summary.geometry)
    json["geometry"] = {
        {"maps", summary.geometry->maps},
        {"missing_maps", summary.geometry->missing_maps},
        {"written_maps", summary.geometry->written_maps},
        {"triangles", summary.geometry->mesh ? summary.geometry->mesh->mesh->triangles.size() : 0},
        {"seconds", summary.geometry->seconds}};
  json["ms_measure_median"] = summary.measured ? nlohmann::json(summary.measured->ms_median) : nullptr;
  json["calibration"] = ToJson(summary.calibration);
  json["refined_lens"] = ToJson(summary.refined_lens);
  json["mistakes"] = nlohmann::json::array();
  for (const coverage::NoticedMistake& noticed : summary.mistakes)
    json["mistakes"].push_back({{"name", Name(noticed.mistake)},
                                {"finding", noticed.finding},
                                {"cure", noticed.cure},
                                {"first_s", noticed.first_s},
                                {"last_s", noticed.last_s}});
  json["rolling_shutter"] = ToJson(summary.rolling_shutter);
  json["set_aside"] = nlohmann::json::object();
  for (const auto& [folder, count] : summary.set_aside) json["set_aside"][folder.string()] = count;
}

std::string NothingRecorded(const coverage::CaptureSummary& summary, std::size_t tracked) {
  if (summary.frames == 0) return "nothing was recorded: no complete frame came";
  if (tracked == 0) {
    std::string text = fmt::format("nothing was recorded: the camera's position was found in none of {}; {}",
                                   Counted(summary.frames, "frame"), ToBeTracked(summary.source));
    const auto commonest =
        std::ranges::max_element(summary.start_obstacles, {}, [](const auto& each) { return each.second; });
    if (commonest != summary.start_obstacles.end())
      text += fmt::format(" (in {} of them: {})", commonest->second,
                          tracking::Advice(commonest->first, summary.source));
    return text;
  }
  const auto commonest = std::ranges::max_element(summary.reasons);
  const auto reason = static_cast<coverage::Reason>(commonest - summary.reasons.begin());
  return fmt::format("nothing was recorded: for {} of {} {}", *commonest, Counted(summary.frames, "frame"),
                     ReasonAndWayOut(reason, summary));
}

std::string FewRecordedReason(const coverage::CaptureSummary& summary) {
  using enum coverage::Reason;
  constexpr double kFew = 0.2, kMost = 0.5;  // shares of the frames; guessed
  if (summary.stopped_because == coverage::StoppedBecause::kCovered) return {};
  const auto count = [&](coverage::Reason reason) {
    return summary.reasons[static_cast<std::size_t>(reason)];
  };
  const auto aims_elsewhere = [](coverage::Reason reason) {
    return reason == kOutsideRectangle || reason == kInsideSphere || reason == kBehind;
  };
  std::uint64_t refused = 0, elsewhere = 0;
  coverage::Reason commonest = kRecorded;
  std::string words_elsewhere;
  for (const coverage::Reason reason : coverage::kReasons) {
    const bool is_refusal =
        reason != kRecorded && reason != kCovered && reason != kStill && reason != kPaused;
    if (!is_refusal || count(reason) == 0) continue;
    refused += count(reason);
    if (aims_elsewhere(reason)) {
      elsewhere += count(reason);
      words_elsewhere += fmt::format("{}'{}'", words_elsewhere.empty() ? "" : " or ", InWords(reason));
    } else if (commonest == kRecorded || count(reason) > count(commonest)) {
      commonest = reason;
    }
  }
  const auto not_covered = static_cast<double>(summary.frames - count(kCovered));
  if (static_cast<double>(summary.recorded) >= kFew * not_covered ||
      static_cast<double>(refused) < kMost * static_cast<double>(summary.frames))
    return {};
  const std::string frames = Counted(summary.frames, "frame");
  const std::string few = summary.recorded == 0
                              ? fmt::format("nothing was recorded of {}: for", frames)
                              : fmt::format("only {} of {} recorded: for", summary.recorded, frames);
  if (elsewhere == 0 || (commonest != kRecorded && count(commonest) > elsewhere))
    return fmt::format("{} {} {}", few, count(commonest), ReasonAndWayOut(commonest, summary));
  return fmt::format(
      "{} {} the reason was {}: the camera did not go round the subject{}. If that is not what you want to "
      "capture, say where it is: ulf track URI -o poses.txt, then --poses tum:poses.txt --subject "
      "x,y,z,radius; for posed photographs of a walk give --no-subject",
      few, elsewhere, words_elsewhere,
      summary.subject_was_found ? ", which was placed by itself in the middle of the first pictures" : "");
}

PoseErrors CompareWithTruth(const std::vector<TimedPose>& truth, const std::vector<TimedPose>& live,
                            const LightField& light_field) {
  constexpr double kSameFrame_s = 0.002;  // both use the device's clock
  std::vector<TimedPose> views;
  for (const View& view : light_field.views) views.push_back({view.device_time_s, view.cam_from_world});
  PoseErrors errors{CompareTrajectories(live, truth, kSameFrame_s),
                    CompareTrajectories(views, truth, kSameFrame_s)};
  if (errors.views && light_field.subject)
    errors.subject_distance =
        errors.views->scale *
        Median(DistancesTo(*light_field.subject, light_field.views, &View::CenterInWorld));
  return errors;
}

void AddTo(nlohmann::json& json, const PoseErrors& errors) {
  json["ate_live_rmse"] = errors.live ? nlohmann::json(errors.live->ate_rmse) : nullptr;
  json["ate_views_rmse"] = errors.views ? nlohmann::json(errors.views->ate_rmse) : nullptr;
  json["truth_subject_distance"] = errors.subject_distance;
}

std::string ToText(const PoseErrors& errors) {
  if (!errors.live || !errors.views || errors.subject_distance <= 0)
    return "against truth  too few poses have a true one at their time to compare\n";
  const double share = 100 / errors.subject_distance;
  return fmt::format(
      "against truth  camera centres off by {:.3f} % of the subject distance live ({}), {:.3f} % in the "
      "light field ({}), RMS\n",
      share * errors.live->ate_rmse, Counted(errors.live->matched, "frame"), share * errors.views->ate_rmse,
      Counted(errors.views->matched, "view"));
}

}  // namespace ulf::commands
