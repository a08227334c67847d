#include "coverage/session/record/capture_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <utility>

#include "core/base/counted.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/mesh_file.h"

namespace ulf::coverage {
namespace {

// A correction that moves no view by more than this, radians as seen from the subject, is not worth painting
// the map and writing the journal for; it is about a tenth of a pixel of the coverage image. Guessed.
constexpr double kWorthPaintingAnew = 2e-4;
// A correction that reopens at least this share of the cap is reported; the next view fills a smaller one.
// Guessed.
constexpr double kWorthTelling = 0.005;

bool Same(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

// Returns "3 views (15, 16, 17)".
std::string ViewsInWords(const std::vector<int>& ids) {
  std::string text;
  for (const int id : ids) text += fmt::format("{}{}", text.empty() ? "" : ", ", id);
  return fmt::format("{} ({})", Counted(ids.size(), "view"), text);
}

// A map that was made anew from the recorded views lacks their observations: then all points of the earlier
// session stay, with the map's points that views of this session show. A restored map has both.
std::vector<ScenePoint> WithEarlier(const std::vector<ScenePoint>& earlier, std::vector<ScenePoint> now,
                                    int first_new_id) {
  const auto is_tracked = [](const ScenePoint& point) { return point.track.size() > 1; };
  const auto shown_earlier = [&](const ScenePoint& point) {
    return std::ranges::any_of(point.track,
                               [&](const ViewObservation& seen) { return seen.view_id < first_new_id; });
  };
  if (std::ranges::none_of(earlier, is_tracked) || std::ranges::any_of(now, shown_earlier)) return now;
  std::erase_if(now, [&](const ScenePoint& point) { return !is_tracked(point); });
  now.insert(now.end(), earlier.begin(), earlier.end());
  return now;
}

}  // namespace

CaptureRecord::CaptureRecord(LightFieldWriter writer, const CaptureLens& lens, const CaptureOptions& options,
                             std::function<void(const std::string&)> say, FrameSource source)
    : lens_(lens),
      options_(options),
      say_(std::move(say)),
      source_(source),
      first_new_id_(writer.NextViewId()),
      camera_index_(writer.CameraInUse()),
      earlier_s_(writer.Contents().capture_s),
      earlier_reasons_(writer.Contents().reasons),
      resumed_subject_(writer.Contents().subject),
      views_(writer.Contents()),
      geometry_(writer.Contents(), lens, options, say_),
      painter_(views_, lens, options, writer.Contents().up_in_world),
      spool_(std::move(writer), options.spool_views, !options.deterministic) {
  views_.Subscribe(geometry_);
}

void CaptureRecord::SetSubject(const Subject& subject) {
  subject_ = subject;
  const bool goes_on = resumed_subject_ == subject;
  geometry_.SetSubject(subject, goes_on);
  if (!goes_on) spool_.SetSubject(subject);
  resumed_subject_.reset();
  painter_.PaintAnew(subject, errors().get());
  painter_.ForgetReopened();
}

std::string CaptureRecord::ReopenedInWords(double share) const {
  return fmt::format("{:.1f} % of {} {}", 100 * share, options_.cap ? "the cap" : "what was covered",
                     IsTaken(source_) ? "is open again" : "must be taken again");
}

std::optional<int> CaptureRecord::Add(const Frame& frame, const tracking::Track& track,
                                      std::optional<double> bound_px, tracking::PoseSource& poses) {
  View view;
  view.cam_from_world = *track.cam_from_world;
  view.tracking_quality = track.quality;
  if (track.twist) Eigen::Map<tracking::Twist>(view.twist.emplace().data()) = *track.twist;
  view.bound_px = bound_px;
  const std::optional<int> id =
      frame.kind == FrameKind::kStill ? spool_.AddView(frame, view) : spool_.TryAddView(frame, view);
  if (!id) return std::nullopt;
  poses.NoteView(*id, track);
  if (track.seen) spool_.ExpectSeenPoints(track.seen->size());
  views_.Add({*id, track.anchor, view.cam_from_world,
              options_.LensMayChange() ? std::make_shared<const tracking::Track>(track) : nullptr},
             frame.image);
  painter_.AddNewest();
  return id;
}

double CaptureRecord::Change(const std::function<void()>& change) {
  const auto state = [this] { return std::pair(views_.revision(), subject_); };
  const auto before = state();
  change();
  return subject_ && state() != before ? painter_.Repaint(*subject_, errors().get()) : 0;
}

std::size_t CaptureRecord::TakeBack(const std::vector<int>& ids) {
  std::vector<int> taken;
  const double reopened = Change([&] {
    for (const int id : ids) {
      if (views_.Remove(id)) {
        taken.push_back(id);
      } else if (std::ranges::find(taken, id) == taken.end()) {
        say_(fmt::format("there is no view {} to take back", id));
      }
    }
    if (!taken.empty()) spool_.RemoveViews({taken.begin(), taken.end()});
  });
  if (taken.empty()) {
    if (ids.empty()) say_("there is no view to take back");
    return 0;
  }
  std::ranges::sort(taken);
  say_(fmt::format("taken back, kept in unposed/: {}{}", ViewsInWords(taken),
                   map() ? "; " + ReopenedInWords(reopened) : ""));
  return taken.size();
}

// Moves them if any view moves enough. Returns false when the disk is behind.
bool CaptureRecord::MoveViews(const tracking::PoseSource& poses, bool last) {
  if (views_.empty()) return true;
  const std::map<int, Rigid3> now = views_.PosesNow(poses);
  const double largest_move = views_.LargestMove(now, map() ? &map()->subject() : nullptr);
  if (largest_move <= 0 || (!last && largest_move < kWorthPaintingAnew)) return true;
  if (!last && !spool_.TryUpdatePoses(now)) return false;
  views_.SetPoses(now);
  return true;
}

bool CaptureRecord::CorrectPoses(const tracking::PoseSource& poses, bool last,
                                 const std::optional<Subject>& subject) {
  bool has_room = true;
  const double reopened = Change([&] {
    has_room = MoveViews(poses, last);
    if (has_room && subject) MoveSubject(*subject);
  });
  if (reopened >= kWorthTelling) say_("poses were corrected: " + ReopenedInWords(reopened));
  return has_room;
}

void CaptureRecord::MoveSubject(const Subject& subject) {
  subject_ = subject;
  geometry_.MoveSubject(subject);
  spool_.SetSubject(subject);
}

void CaptureRecord::ReplaceLens(const CameraModel& before, const tracking::PoseSource& poses, bool last,
                                const std::optional<Subject>& subject) {
  const int side = std::max(before.width, before.height);
  views_.ReestimatePoses(
      poses, LargestShiftPx(before, lens_.recorded(), side) / (0.5 * std::hypot(before.width, before.height)),
      subject ? &*subject : nullptr);
  const std::map<int, Rigid3> now = views_.PosesNow(poses);
  if (!last) spool_.UpdateLens(lens_.recorded(), lens_.FoundSource(), now);
  Change([&] {
    if (subject) MoveSubject(*subject);
    views_.SetPoses(now);
  });
}

std::optional<MeasuredFrame> CaptureRecord::Measure(const Frame& frame, const CameraModel& camera,
                                                    const tracking::Track& track) {
  const MeasuredGeometry::Measurement measured = geometry_.Measure(frame, camera, track);
  if (measured.attempt == MeasuredGeometry::Attempt::kFailed && map())
    painter_.PaintAnew(*subject_, nullptr);  // the bound decides alone
  // Often enough for a hand that moves, and seldom enough for a map of thousands of cells. Guessed.
  constexpr double kFollowEvery_s = 1;
  if (measured.attempt == MeasuredGeometry::Attempt::kMade && options_.cover.by != CoverBy::kBound && map() &&
      std::abs(frame.device_time_s - followed_s_) >= kFollowEvery_s) {
    followed_s_ = frame.device_time_s;
    painter_.AdaptToErrors(*errors());
  }
  return measured.frame;
}

bool CaptureRecord::IsCapCovered(double share, const tracking::PoseSource& poses) {
  if (!options_.cap || !map() || map()->CoveredShare() < share) return false;
  if (!CorrectPoses(poses, false)) return false;
  if (!painter_.IsPaintedAnew()) painter_.PaintAnew(*subject_, errors().get());  // follows the errors, too
  return map()->CoveredShare() >= share;
}

ClosedRecord CaptureRecord::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
                                  std::vector<ScenePoint> points,
                                  const std::optional<tracking::Readout>& rolling_shutter,
                                  const std::function<void(const std::string&)>& closing) {
  ClosedRecord closed;
  closing("the last views to the disk");
  LightFieldWriter writer = spool_.Finish();
  closed.unwritten = spool_.Unwritten();
  closed.set_aside = spool_.SetAside();
  for (const View& view : writer.Contents().views) closed.recorded += view.id >= first_new_id_;
  if (const auto failure = spool_.Failure()) {
    closed.problem = *failure;
    return closed;
  }
  std::map<int, Rigid3> final_poses = views_.Poses();
  for (const View& view : writer.Contents().views)
    if (const auto found = final_poses.find(view.id);
        found != final_poses.end() && Same(view.cam_from_world, found->second))
      final_poses.erase(found);
  std::map<std::string, std::uint64_t> all_reasons = earlier_reasons_;
  for (const auto& [name, count] : reasons) all_reasons[name] += count;
  std::map<int, CorrectedLens> final_lens;
  if (lens_.found() &&
      writer.Contents().cameras.at(static_cast<std::size_t>(camera_index_)) != lens_.recorded())
    final_lens[camera_index_] = {lens_.recorded(), lens_.FoundSource()};
  closing("poses, points and the files for other programs");
  try {
    writer.UpdatePoses(final_poses, final_lens);
    // One that was given stands in the journal since the session began.
    if (rolling_shutter && rolling_shutter->sigma_s)
      writer.SetReadout({rolling_shutter->readout_s, rolling_shutter->sigma_s});
    points = WithEarlier(writer.Contents().points, std::move(points), first_new_id_);
    if (!points.empty()) writer.SetPoints(std::move(points));
    const std::filesystem::path root = writer.Contents().root;
    if (const auto measured = geometry_.ForLightField()) writer.SetMeasured(*measured);
    writer.Close(earlier_s_ + capture_s, all_reasons);
    if (geometry_.IsMade())
      closed.geometry = geometry_.Finish(
          spool_.Folder(), root,
          std::ranges::any_of(views_.views(), [this](const auto& view) { return view.id >= first_new_id_; }),
          closing);
    else if (closed.recorded > 0 && std::filesystem::exists(root / render::kMeshProxyFile))
      say_(fmt::format("{} was made without {} of this session; '{}' makes it anew", render::kMeshProxyFile,
                       Counted(closed.recorded, "view"), render::ProxyCommand(root)));
    spool_.Folder().RequireInPlace();
  } catch (const std::exception& error) {
    closed.problem = spool_.Folder().WhyNotInPlace().value_or(error.what());
    closed.geometry.reset();
  }
  return closed;
}

}  // namespace ulf::coverage
