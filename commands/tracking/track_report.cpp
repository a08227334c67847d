#include "commands/tracking/track_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "commands/reports/lens_report.h"
#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "tracking/map/pose_error.h"

namespace ulf::commands {
namespace {

using Json = nlohmann::ordered_json;

struct Stage {
  const char* name;
  double StageTimes::*cpu_s;
};
constexpr std::array kStages{Stage{"pyramid", &StageTimes::pyramid_s},
                             Stage{"features", &StageTimes::features_s},
                             Stage{"matching", &StageTimes::matching_s},
                             Stage{"alignment", &StageTimes::alignment_s},
                             Stage{"refinement", &StageTimes::refinement_s},
                             Stage{"initialisation", &StageTimes::initialization_s},
                             Stage{"relocalisation", &StageTimes::relocalization_s},
                             Stage{"keyframes", &StageTimes::keyframe_s}};

// Returns the last map that gave live poses.
std::optional<int> LastMap(const TrackRun& run) {
  const auto last = std::ranges::find_if(run.frames.rbegin(), run.frames.rend(), &TrackedFrame::HasPose);
  return last == run.frames.rend() ? std::nullopt : std::optional(last->track.map_id);
}

struct Counts {
  int frames = 0, tracked = 0, lost = 0, found_again = 0;
  int turned = 0;  // frames without a pose but with a rotation
  int zoomed = 0;  // frames with a moved zoom
  std::optional<double> zoomed_from_s;
  double focal_ratio = 1;     // of these, the farthest from 1
  int apart = 0, joined = 0;  // tracked without a live pose; of these, those in the last map after the run
  std::optional<int> first_tracked;
  std::vector<double> predicted;  // errors of the live poses, shares of the distance
  int unsure = 0;                 // of these, above a hundredth
  std::vector<double> wall_ms, cpu_ms;
  std::array<double, kStages.size()> stage_ms{};  // CPU, mean over the frames
  double longest_ms = 0;
  int longest_frame = -1;

  double TrackedShare() const { return frames > 0 ? static_cast<double>(tracked) / frames : 0; }
  double TrackedShareFromThere() const {
    return first_tracked ? static_cast<double>(tracked) / (frames - *first_tracked) : 0;
  }
};

Counts Count(const TrackRun& run) {
  Counts counts;
  counts.frames = static_cast<int>(run.frames.size());
  tracking::TrackState before = tracking::TrackState::kInitializing;
  const std::optional<int> last_map = LastMap(run);
  for (int i = 0; i < counts.frames; ++i) {
    const TrackedFrame& frame = run.frames[At(i)];
    const tracking::Track& track = frame.track;
    counts.tracked += track.cam_from_world.has_value();
    if (track.cam_from_world && track.center_sigma) {
      counts.predicted.push_back(tracking::ErrorShareOf(track.quality));
      counts.unsure += track.quality < 0.5;
    }
    counts.found_again += track.relocalized;
    counts.turned += track.turn && track.state != tracking::TrackState::kApart;
    if (track.focal_ratio) {
      ++counts.zoomed;
      if (!counts.zoomed_from_s) counts.zoomed_from_s = frame.time_s - run.frames.front().time_s;
      if (std::abs(std::log(*track.focal_ratio)) > std::abs(std::log(counts.focal_ratio)))
        counts.focal_ratio = *track.focal_ratio;
    }
    if (track.state == tracking::TrackState::kApart) {
      ++counts.apart;
      counts.joined += frame.final_cam_from_world && frame.final_map == last_map;
    }
    // A camera that was relocalised in the frame that lost it counts as lost, too.
    counts.lost += before == tracking::TrackState::kTracking &&
                   (track.state != tracking::TrackState::kTracking || track.relocalized);
    if (!counts.first_tracked && track.cam_from_world) counts.first_tracked = i;
    before = track.state;
    if (track.skipped) continue;
    counts.wall_ms.push_back(frame.wall_ms);
    counts.cpu_ms.push_back(1000 * track.cpu_s);
    for (std::size_t k = 0; k < kStages.size(); ++k)
      counts.stage_ms[k] += 1000 * track.stages.*kStages[k].cpu_s;
    if (frame.wall_ms > counts.longest_ms) {
      counts.longest_ms = frame.wall_ms;
      counts.longest_frame = i;
    }
  }
  for (double& stage_ms : counts.stage_ms) stage_ms /= std::max<double>(1, counts.cpu_ms.size());
  return counts;
}

void AddError(Json& report, const std::string& which, const std::optional<TrajectoryError>& error) {
  const auto number = [&](double TrajectoryError::*value, bool known = true) {
    return error && known ? Json((*error).*value) : Json(nullptr);
  };
  const bool stepped = error && error->steps > 0;
  report["ate_" + which + "_rmse"] = number(&TrajectoryError::ate_rmse);
  report["ate_" + which + "_median"] = number(&TrajectoryError::ate_median);
  report["ate_" + which + "_max"] = number(&TrajectoryError::ate_max);
  report["rpe_" + which + "_rmse"] = number(&TrajectoryError::rpe_rmse, stepped);
  report["rpe_" + which + "_rotation_rmse_deg"] = number(&TrajectoryError::rpe_rotation_rmse_deg, stepped);
  report["drift_" + which] = number(&TrajectoryError::drift, stepped);
  report["rotation_" + which + "_rmse_deg"] = number(&TrajectoryError::rotation_rmse_deg);
}

// Selects the pose of the picture, or the camera's own when the middle row was read.
enum class PoseOfWhat { kPicture, kMiddleRow };

std::map<int, GivenPoses> PosesByMap(const TrackRun& run, PoseOfWhat what) {
  std::map<int, GivenPoses> by_map;
  for (const TrackedFrame& frame : run.frames) {
    const Rigid3 asked =
        what == PoseOfWhat::kMiddleRow ? frame.track.middle_row_from_picture.value_or(Rigid3{}) : Rigid3{};
    if (frame.track.cam_from_world)
      by_map[frame.track.map_id].live.push_back({frame.time_s, asked * *frame.track.cam_from_world});
    if (frame.final_cam_from_world)
      by_map[frame.final_map].final.push_back({frame.time_s, asked * *frame.final_cam_from_world});
  }
  return by_map;
}

GivenPoses LastMapPoses(const TrackRun& run, PoseOfWhat what) {
  const std::optional<int> last = LastMap(run);
  return last ? PosesByMap(run, what)[*last] : GivenPoses();
}

WrongPoses CountWrong(const TrackRun& run, const TrajectoryError& live) {
  constexpr double kWrongShare = 0.03, kWrongTurnDeg = 2, kSaidQuality = 0.5;
  WrongPoses counts;
  auto frame = run.frames.begin();
  for (const TrajectoryError::AtTime& error : live.errors) {
    frame = std::find_if(frame, run.frames.end(),
                         [&](const TrackedFrame& one) { return one.time_s == error.time_s; });
    if (frame == run.frames.end()) break;
    if (frame->seen_distance <= 0) continue;
    ++counts.compared;
    if (error.distance <= kWrongShare * live.scale * frame->seen_distance && error.turn_deg <= kWrongTurnDeg)
      continue;
    ++counts.wrong;
    counts.unsaid += frame->track.quality >= kSaidQuality;
  }
  return counts;
}

bool IsReduced(const tracking::TrackedSize& size) {
  return size.width != size.original_width || size.height != size.original_height;
}

std::string SizeLine(const tracking::TrackedSize& size) {
  if (!IsReduced(size)) return {};
  return fmt::format("pictures of {}x{} tracked at {}x{}; poses and pixels are those of the pictures\n",
                     size.original_width, size.original_height, size.width, size.height);
}

std::string MapLine(const tracking::TrackerStatistics& map, FrameSource source) {
  std::string text =
      fmt::format("map: {}, {}", Counted(map.keyframes, "keyframe"), Counted(map.map_points, "point"));
  if (map.loops > 0) text += fmt::format("; {} closed", Counted(map.loops, "loop"));
  if (map.parts_joined > 0)
    text += fmt::format("; {} that {} begun apart joined to it", Counted(map.parts_joined, "part"),
                        map.parts_joined == 1 ? "was" : "were");
  if (map.parts > 1)
    text += fmt::format("; {} not joined to the rest: no picture shows how they lie to each other",
                        Counted(map.parts - 1, "part"));
  if (map.keyframes_left_out > 0)
    text += fmt::format("; {} left out because the mapper was behind",
                        Counted(map.keyframes_left_out, "keyframe"));
  text += "\n";
  if (map.rolling_shutter) text += map.rolling_shutter->InWords() + "\n";
  if (map.refined_lens)
    text += fmt::format("lens: {}, found from the images\n  {}\n", map.refined_lens->Text(),
                        LensSigmaWords(source));
  if (map.calibration && map.calibration->Wrong()) text += map.calibration->Advice(source) + "\n";
  return text;
}

// Returns the most frequent obstacle to initialisation; empty if the source makes no map.
std::string MostFrequentObstacle(const TrackRun& run) {
  std::map<tracking::StartObstacle, int> frames;
  for (const TrackedFrame& frame : run.frames)
    if (frame.track.start) ++frames[frame.track.start->obstacle];
  if (frames.empty()) return {};
  if (frames.size() > 1) frames.erase(tracking::StartObstacle::kFirstView);
  const auto most = std::ranges::max_element(frames, {}, [](const auto& each) { return each.second; });
  return fmt::format("{} (in {} of {})", tracking::Advice(most->first, run.source), most->second,
                     Counted(run.frames.size(), "frame"));
}

std::string StagesLine(const Counts& counts) {
  std::string text;
  for (std::size_t k = 0; k < kStages.size(); ++k)
    if (counts.stage_ms[k] > 0)
      text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", kStages[k].name, counts.stage_ms[k]);
  return text.empty() ? text : "CPU by stage, ms a frame on average: " + text + "\n";
}

std::string OutsideLine(const TrackRun& run) {
  std::string text;
  for (const auto& [name, count] : run.from_outside) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", words, count);
  }
  return text.empty() ? text : "from outside: " + text + "\n";
}

std::string Length(double metres) {
  return std::abs(metres) < 0.1 ? fmt::format("{:.3g} mm", 1000 * metres) : fmt::format("{:.3g} m", metres);
}

std::string ErrorLine(const std::string& which, const TrajectoryError& error) {
  std::string line = fmt::format("  {:<6} RMS {}, median {}, largest {}; ", which, Length(error.ate_rmse),
                                 Length(error.ate_median), Length(error.ate_max));
  if (error.steps == 0)
    return line + fmt::format("no two poses of the truth lie {:g} s apart\n", kRelativeErrorStep_s);
  return line + fmt::format("per second {} and {:.3f} degrees (RMS), {:.2g} % of the way (median)\n",
                            Length(error.rpe_rmse), error.rpe_rotation_rmse_deg, 100 * error.drift);
}

std::string ToText(const TrackErrors& errors) {
  if (!errors.live || !errors.final)
    return fmt::format(
        "error against {}: not known; fewer than three of its poses belong to frames that have one in the "
        "run's last map, or they lie on a line\n",
        errors.truth_name);
  std::string text =
      fmt::format("error against {} ({}, its unit taken as metres; scaled by {:.4g}):\n", errors.truth_name,
                  Counted(errors.live->matched, "pose"), errors.final->scale);
  text += ErrorLine("live", *errors.live) + ErrorLine("after", *errors.final);
  if (errors.wrong.compared > 0)
    text += fmt::format(
        "  wrong live, by 3 % of the distance or 2 degrees: {} of {}; {} of them with a quality of 0.5 or "
        "more\n",
        errors.wrong.wrong, Counted(errors.wrong.compared, "pose"), errors.wrong.unsaid);
  if (errors.middle_row_live && errors.middle_row_final)
    text += "  these are poses of the pictures; the camera's own when the middle row was read:\n" +
            ErrorLine("live", *errors.middle_row_live) + ErrorLine("after", *errors.middle_row_final);
  if (errors.earlier_maps > 0)
    text += fmt::format("  not compared: {} of other maps, which were discarded or are apart\n",
                        Counted(errors.earlier_maps, "live pose"));
  return text;
}

}  // namespace

int LivePoses(const TrackRun& run) {
  return static_cast<int>(std::ranges::count_if(run.frames, &TrackedFrame::HasPose));
}

std::vector<GivenPoses> PosesOfMaps(const TrackRun& run) {
  const std::optional<int> last = LastMap(run);
  std::vector<GivenPoses> in_order;
  std::map<int, GivenPoses> by_map = PosesByMap(run, PoseOfWhat::kPicture);
  for (auto& [id, poses] : by_map)
    if (id != last) in_order.push_back(std::move(poses));
  if (last) in_order.push_back(std::move(by_map[*last]));
  return in_order;
}

GivenPoses LastMapPoses(const TrackRun& run) { return LastMapPoses(run, PoseOfWhat::kPicture); }

TrackErrors CompareWithTruth(const TrackRun& run, std::vector<TimedPose> truth, std::string truth_name) {
  TrackErrors errors{.truth_name = std::move(truth_name), .truth = std::move(truth)};
  if (run.frames.empty()) return errors;
  constexpr double kMostApart_s = 0.02;  // a hand moves some millimetres meanwhile. Guessed
  double tolerance_s = 1.0 / 60;         // of a single frame: half a frame at 30 Hz
  if (run.frames.size() > 1) {
    const double span_s = run.frames.back().time_s - run.frames.front().time_s;
    tolerance_s = std::min(kMostApart_s, 0.5 * span_s / static_cast<double>(run.frames.size() - 1));
  }
  const auto error = [&](const std::vector<TimedPose>& poses) {
    return CompareTrajectories(poses, errors.truth, tolerance_s, kRelativeErrorStep_s);
  };
  const GivenPoses poses = LastMapPoses(run);
  errors.earlier_maps = LivePoses(run) - static_cast<int>(poses.live.size());
  errors.live = error(poses.live);
  if (errors.live) errors.wrong = CountWrong(run, *errors.live);
  errors.final = error(poses.final);
  if (std::none_of(run.frames.begin(), run.frames.end(),
                   [](const TrackedFrame& frame) { return frame.track.middle_row_from_picture; }))
    return errors;
  const GivenPoses middle_row = LastMapPoses(run, PoseOfWhat::kMiddleRow);
  errors.middle_row_live = error(middle_row.live);
  errors.middle_row_final = error(middle_row.final);
  return errors;
}

Json ToJson(const TrackRun& run, const TrackErrors* errors) {
  const Counts counts = Count(run);
  Json report{{"frames", counts.frames}};
  report["init_frame"] = counts.first_tracked ? Json(*counts.first_tracked) : Json(nullptr);
  report["tracked"] = counts.tracked;
  report["tracked_share"] = counts.TrackedShare();
  report["tracked_share_from_init"] = counts.TrackedShareFromThere();
  report["lost_count"] = counts.lost;
  report["relocalised_count"] = counts.found_again;
  report["turn_only"] = counts.turned;
  report["zoom_moved"] = nullptr;
  if (counts.zoomed > 0)
    report["zoom_moved"] = {
        {"frames", counts.zoomed}, {"from_s", *counts.zoomed_from_s}, {"focal_ratio", counts.focal_ratio}};
  report["predicted_error"] = nullptr;
  if (!counts.predicted.empty())
    report["predicted_error"] = {{"median", Quantile(counts.predicted, 0.5)},
                                 {"p95", Quantile(counts.predicted, 0.95)},
                                 {"above_1_percent", counts.unsure}};
  report["apart"] = counts.apart;
  report["apart_joined"] = counts.joined;
  report["ms_median"] = Quantile(counts.wall_ms, 0.5);
  report["ms_p95"] = Quantile(counts.wall_ms, 0.95);
  report["ms_longest"] = counts.longest_ms;
  report["longest_frame"] = counts.longest_frame;
  report["cpu_ms_median"] = Quantile(counts.cpu_ms, 0.5);
  report["cpu_ms_p95"] = Quantile(counts.cpu_ms, 0.95);
  for (std::size_t k = 0; k < kStages.size(); ++k)
    report["stage_cpu_ms_mean"][kStages[k].name] = counts.stage_ms[k];
  report["tracked_size"] = nullptr;
  if (const tracking::TrackedSize& size = run.map.size; size.width > 0)
    report["tracked_size"] = {{"width", size.width},
                              {"height", size.height},
                              {"original_width", size.original_width},
                              {"original_height", size.original_height}};
  report["map_points"] = run.map.map_points;
  report["keyframes"] = run.map.keyframes;
  report["loops"] = run.map.loops;
  report["parts"] = run.map.parts;
  report["parts_joined"] = run.map.parts_joined;
  report["keyframes_left_out"] = run.map.keyframes_left_out;
  report["longest_wait_for_map_ms"] = 1000 * run.map.longest_wait_s;
  for (const auto& [name, count] : run.from_outside) report["poses_from_outside"][name] = count;
  report["rolling_shutter"] = ToJson(run.map.rolling_shutter);
  report["calibration"] = ToJson(run.map.calibration);
  report["refined_lens"] = ToJson(run.map.refined_lens);
  if (run.wrong_lens_after_s) report["wrong_lens_after_s"] = *run.wrong_lens_after_s;
  if (!run.orb_cpu_ms.empty()) {
    report["orb_cpu_ms_median"] = Quantile(run.orb_cpu_ms, 0.5);
    report["cpu_over_orb"] = Quantile(counts.cpu_ms, 0.5) / Quantile(run.orb_cpu_ms, 0.5);
  }
  if (!errors) return report;
  AddError(report, "live", errors->live);
  AddError(report, "final", errors->final);
  report["middle_row"] = nullptr;
  if (errors->middle_row_live) {
    AddError(report["middle_row"], "live", errors->middle_row_live);
    AddError(report["middle_row"], "final", errors->middle_row_final);
  }
  report["wrong_live"] = {
      {"compared", errors->wrong.compared}, {"wrong", errors->wrong.wrong}, {"unsaid", errors->wrong.unsaid}};
  report["rpe_step_s"] = kRelativeErrorStep_s;
  report["scale"] = errors->final ? Json(errors->final->scale) : Json(nullptr);
  report["compared"] = errors->live ? errors->live->matched : 0;
  return report;
}

std::string ToText(const TrackRun& run, const TrackErrors* errors) {
  const Counts counts = Count(run);
  std::string text = fmt::format("{}, {} tracked ({:.1f} %), ", Counted(counts.frames, "frame"),
                                 counts.tracked, 100 * counts.TrackedShare());
  if (counts.first_tracked)
    text += fmt::format("initialised at frame {}, {:.1f} % tracked from there on\n", *counts.first_tracked,
                        100 * counts.TrackedShareFromThere());
  else if (const std::string obstacle = MostFrequentObstacle(run); !obstacle.empty())
    text += "never initialised: " + obstacle + "\n";
  else
    text +=
        "no frame has a pose: check what --poses names (a board's size and dictionary, a file's or sender's "
        "times)\n";
  text += fmt::format("lost {}, found again {}\n", Counted(counts.lost, "time"),
                      Counted(counts.found_again, "time"));
  if (counts.turned > 0)
    text += fmt::format("of {} without a pose the camera's turn is known, not its position\n",
                        Counted(counts.turned, "frame"));
  if (counts.zoomed > 0)
    text += fmt::format(
        "the zoom was moved {:.1f} s after the first frame, to some {:.3f} times the focal length: {} "
        "followed under that, with poses that are unsure\n",
        *counts.zoomed_from_s, counts.focal_ratio, Counted(counts.zoomed, "frame"));
  if (counts.apart > 0)
    text += fmt::format(
        "{} followed apart from the rest of the map, without a live pose; {} of them {} one in its world "
        "after the run\n",
        Counted(counts.apart, "frame"), counts.joined, counts.joined == 1 ? "has" : "have");
  if (run.map.parts > 1)
    text += fmt::format(
        "the map has {} parts that no picture joins; the run's poses are those of the part that was followed "
        "last, and -o writes the others to files of their own\n",
        run.map.parts);
  if (!counts.predicted.empty())
    text += fmt::format(
        "predicted error of the live poses: {:.2g} % of the distance (median; 95 %: {:.2g}), above 1 %: {} "
        "of {}\n",
        100 * Quantile(counts.predicted, 0.5), 100 * Quantile(counts.predicted, 0.95), counts.unsure,
        counts.predicted.size());
  text += SizeLine(run.map.size);
  if (run.map.keyframes > 0) text += MapLine(run.map, run.source);
  if (counts.longest_frame >= 0)
    text += fmt::format(
        "per frame: {:.1f} ms (95 %: {:.1f}; longest {:.1f}, frame {}){}, CPU {:.1f} ms (95 %: {:.1f})\n",
        Quantile(counts.wall_ms, 0.5), Quantile(counts.wall_ms, 0.95), counts.longest_ms,
        counts.longest_frame, run.deterministic ? " with mapping" : "", Quantile(counts.cpu_ms, 0.5),
        Quantile(counts.cpu_ms, 0.95));
  text += StagesLine(counts) + OutsideLine(run);
  if (!run.orb_cpu_ms.empty()) {
    const double orb_ms = Quantile(run.orb_cpu_ms, 0.5);
    text += fmt::format("cv::ORB with 1000 features: {:.1f} ms; tracking costs {:.2f} times that\n", orb_ms,
                        Quantile(counts.cpu_ms, 0.5) / orb_ms);
  }
  if (errors) text += ToText(*errors);
  return text;
}

std::string ToCsv(const TrackRun& run, const TrackErrors* errors) {
  std::map<double, double> live, final;  // by time
  for (const auto& [of, to] : {std::pair(&TrackErrors::live, &live), {&TrackErrors::final, &final}})
    if (errors && errors->*of)
      for (const TrajectoryError::AtTime& error : (errors->*of)->errors) (*to)[error.time_s] = error.distance;
  const auto at = [](const std::map<double, double>& of, double time_s) {
    const auto found = of.find(time_s);
    return found == of.end() ? std::string() : fmt::format("{:.6g}", found->second);
  };
  std::string table = "time_s,has_pose,quality,map_points_found,error_live,error_final\n";
  for (const TrackedFrame& frame : run.frames)
    table += fmt::format("{:.6f},{:d},{:.4f},{},{},{}\n", frame.time_s,
                         frame.track.cam_from_world.has_value(), frame.track.quality,
                         frame.track.matched_points, at(live, frame.time_s), at(final, frame.time_s));
  return table;
}

std::vector<ModelChoice> Explained(const TrackRun& run) {
  std::vector<ModelChoice> choices;
  if (const auto& start = run.map.start) {
    const tracking::MotionEvidence& seen = start->evidence;
    const auto of_matches = [&](int count) { return fmt::format("{} of {} matches", count, seen.matches); };
    const bool flat = start->model == tracking::RelativePoseModel::kHomography;
    choices.push_back(
        {"model that started the map",
         fmt::format("no map starts where a rotation explains nearly all matches; the scene is flat where a "
                     "homography explains 85 % of what the essential matrix does; the cost of the best other "
                     "motion is higher by {:.0f} variances of the noise ({:.0f} needed)",
                     seen.runner_up, seen.runner_up_needed),
         {{"rotation", of_matches(seen.by_rotation), false},
          {"homography", of_matches(seen.by_homography), flat},
          {"essential matrix", of_matches(seen.by_essential), !flat}}});
  }
  choices.push_back({"keyframes",
                     "a frame becomes a keyframe where it shows few of the last one's points, or the camera "
                     "has moved or turned; a keyframe is removed where others see nearly all of its points",
                     {{"kept", fmt::format("{}", run.map.keyframes), true},
                      {"made", fmt::format("{}", run.map.keyframes_made), false},
                      {"every frame", fmt::format("{}", run.frames.size()), false}}});
  choices.push_back({"map points",
                     "a new point is removed where it is found less often than it should be",
                     {{"kept", fmt::format("{}", run.map.map_points), true},
                      {"made", fmt::format("{}", run.map.points_made), false}}});
  return choices;
}

}  // namespace ulf::commands
