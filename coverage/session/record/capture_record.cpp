#include "coverage/session/record/capture_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/measured/threshold_by_errors.h"
#include "coverage/session/record/geometry_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"

namespace ulf::coverage {
namespace {

bool Same(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

// "3 views (15, 16, 17)"
std::string ViewsInWords(const std::vector<int>& ids) {
  std::string text;
  for (const int id : ids) text += fmt::format("{}{}", text.empty() ? "" : ", ", id);
  return fmt::format("{} ({})", Counted(ids.size(), "view"), text);
}

// Coverage is measured as `ulf info` measures it: with the light field's own up.
CaptureRecord::Options WithUpOf(const LightField& light_field, CaptureRecord::Options options) {
  options.map.up_in_world = light_field.up_in_world;
  return options;
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

ErrorMeter::Options MeterOptions(const CaptureRecord::Options& options) {
  ErrorMeter::Options meter;
  // What only is shown may cost less than what decides. Guessed.
  constexpr double kOnlyShown = 0.1;
  if (options.cover.by == CoverBy::kBound) meter.processor_share = kOnlyShown;
  meter.every_frame = options.deterministic;
  meter.good_db = options.cover.db;
  return meter;
}

// By how much two lenses show the same ray apart, at most, in pixels of a picture with this longer side.
double LargestShiftPx(const CameraModel& a, const CameraModel& b, int longer_side_px) {
  const double scale = static_cast<double>(longer_side_px) / std::max(a.width, a.height);
  double largest = 0;
  constexpr int kPlaces = 4;  // along each side; lenses differ smoothly
  for (int row = 0; row <= kPlaces; ++row)
    for (int column = 0; column <= kPlaces; ++column) {
      const Eigen::Vector2d img(a.width * column / kPlaces, a.height * row / kPlaces);
      const auto ray = a.RayFromImg(img);
      const auto there = ray ? b.ImgFromCam(*ray) : std::nullopt;
      if (there) largest = std::max(largest, scale * (*there - img).norm());
    }
  return largest;
}

constexpr int kSmallSide = render::GrowingGeometryOptions{}.size_px;

std::unique_ptr<LiveGeometry> MakeGeometry(std::optional<LiveGeometry::Options> options,
                                           const std::filesystem::path& light_field) {
  if (!options) return nullptr;
  options->light_field = light_field;
  return std::make_unique<LiveGeometry>(*options);
}

}  // namespace

CaptureRecord::CaptureRecord(LightFieldWriter writer, const CaptureLens& lens, const Options& options,
                             std::function<void(const std::string&)> say)
    : lens_(lens),
      options_(WithUpOf(writer.Contents(), options)),
      say_(std::move(say)),
      first_new_id_(writer.NextViewId()),
      camera_index_(writer.CameraInUse()),
      earlier_s_(writer.Contents().capture_s),
      earlier_reasons_(writer.Contents().reasons),
      earlier_measured_(StandingErrors(writer.Contents()).value_or(MeasuredErrors{})),
      frames_measured_(earlier_measured_.frames),
      resumed_subject_(writer.Contents().subject),
      views_(writer.Contents()),
      geometry_(MakeGeometry(options.geometry, writer.Contents().root)),
      geometry_lens_(lens.recorded()),
      meter_(geometry_ ? std::make_unique<ErrorMeter>(MeterOptions(options)) : nullptr),
      errors_(meter_ ? std::make_shared<const ErrorMap>() : nullptr),
      spool_(AfterEarlierViews(std::move(writer)), options.spool_views, !options.deterministic) {}

LightFieldWriter CaptureRecord::AfterEarlierViews(LightFieldWriter writer) {
  if (geometry_) AddEarlierViews(writer.Contents());
  return writer;
}

void CaptureRecord::AddEarlierViews(const LightField& light_field) {
  const auto earlier = std::make_shared<const LightField>(light_field);
  for (const View& view : earlier->views) {
    const auto read = [earlier, &view] { return Srgb8(ReadRecordedImage(*earlier, view)); };
    geometry_->AddView(view.id, read, earlier->CameraOf(view), view.cam_from_world);
    meter_->AddEarlierView(view.id, read, earlier->CameraOf(view), view.cam_from_world);
  }
  geometry_->AddMaps([earlier] { return ReadKnownMaps(*earlier); });
}

void CaptureRecord::SayGeometryProblem() {
  if (const auto problem = geometry_->TakeProblem()) say_(*problem);
}

// Says of a mesh that is there that it stays, and what is wrong with it. The session before may have ended without a mesh of
// its views.
static std::string ThatItStays(const std::filesystem::path& root, bool is_corrected) {
  std::optional<render::GeometryState> state;
  try {
    state = render::GeometryStateOf(ReadLightField(root));
  } catch (const Error&) {
  }
  const std::string command = render::ProxyCommand(root);
  if (state && state->triangles == 0)
    return fmt::format(
        "no view was added: no new mesh is made, and the one that is there cannot be used: {}; "
        "'{}' makes it again",
        state->problem, command);
  if (is_corrected || (state && state->mesh_fits == false))
    return fmt::format(
        "no view was added: the mesh that is there stays, though it is not of the views as they "
        "are now; '{}' makes it and the depth maps anew",
        command);
  return "no view was added, moved or taken back: the mesh that is there stays";
}

// The mesh that was there may be of another program, or a finer one: without new views it stays where it is, with its
// depth maps, and with them until the new one is at least as good.
std::optional<FinishedGeometry> CaptureRecord::FinishGeometry(
    const std::filesystem::path& root, const std::function<void(const std::string&)>& closing) {
  const bool has_new_views =
      std::ranges::any_of(views_.views(), [this](const auto& view) { return view.id >= first_new_id_; });
  if (!has_new_views && std::filesystem::exists(root / render::kMeshProxyFile)) {
    say_(ThatItStays(root, geometry_->IsCorrected()));
    return std::nullopt;
  }
  closing("depth maps and the mesh");
  FinishedGeometry finished = geometry_->Finish();
  spool_.Folder().RequireInPlace();
  Stopwatch writing;
  SayGeometryProblem();
  if (!finished.views_left_out.empty())
    say_(fmt::format("geometry: there was no time to look at {}; '{}' makes a mesh of all",
                     Counted(finished.views_left_out.size(), "view"), render::ProxyCommand(root)));
  if (finished.mesh) {
    if (const std::string why = WhyThatStays(root, finished); !why.empty()) {
      say_(fmt::format(
          "views were added: the mesh that is there stays, because a new one would not be as good everywhere "
          "({}); '{}' makes one of all views",
          why, render::ProxyCommand(root)));
      return std::nullopt;
    }
    closing("depth maps and the mesh to the disk");
    WriteGeometry(root, finished, say_);
  }
  finished.seconds += writing.LapSeconds();
  return finished;
}

void CaptureRecord::SetSubject(const Subject& subject) {
  subject_ = subject;
  if (geometry_) geometry_->SetSubject(subject);
  const bool goes_on = resumed_subject_ == subject;
  if (!goes_on) spool_.SetSubject(subject);
  // Directions are from another point now.
  map_.reset();
  measured_over_.reset();
  if (meter_)
    errors_ = std::make_shared<const ErrorMap>(goes_on ? ErrorMapOf(earlier_measured_) : ErrorMap());
  resumed_subject_.reset();
  PaintAnew();
  reopened_.clear();
}

void CaptureRecord::PaintAnew() {
  auto map = std::make_shared<CoverageMap>(*subject_, ForErrors(options_.map, options_.cover),
                                           views_.ForCriterion(lens_.recorded(), options_.coverage_width_px));
  if (errors_) FollowErrors(*errors_, options_.cover, *map);
  map_ = std::move(map);
  painted_anew_ = true;
}

double CaptureRecord::Repaint() {
  if (!map_) return 0;
  const std::shared_ptr<const CoverageMap> before = map_;
  PaintAnew();
  DropCoveredAgain();
  double open_sr = 0, covered_sr = 0;
  std::vector<Reopened> reopened;
  before->ForEachCell([&](const CoverageMap::CellView& cell) {
    if (cell.covering.index < 0) return;
    covered_sr += cell.solid_angle_sr;
    // The cap lies around its first view and moves with it: directions that it leaves are not missing.
    const auto at = map_->views().empty() ? CoveringView{} : map_->At(cell.direction);
    if (!at || at->index >= 0) return;
    open_sr += cell.solid_angle_sr;
    reopened.push_back({cell.direction, cell.solid_angle_sr});
  });
  const double whole_sr = before->options().cap ? before->extent().SolidAngle() : covered_sr;
  for (const Reopened& cell : reopened) reopened_.push_back({cell.direction, cell.share / whole_sr});
  return whole_sr > 0 ? open_sr / whole_sr : 0;
}

std::string CaptureRecord::ReopenedInWords(double share) const {
  return fmt::format("{:.1f} % of {} {}", 100 * share, options_.map.cap ? "the cap" : "what was covered",
                     IsTaken(options_.source) ? "is open again" : "must be taken again");
}

void CaptureRecord::DropCoveredAgain() {
  std::erase_if(reopened_, [&](const Reopened& cell) {
    if (map_->views().empty()) return false;
    const auto at = map_->At(cell.direction);
    return !at || at->index >= 0;
  });
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
              options_.lens_may_change ? std::make_shared<const tracking::Track>(track) : nullptr});
  if (geometry_) {
    SayGeometryProblem();
    geometry_->AddView(
        *id, [image = frame.image] { return Srgb8(image); }, lens_.recorded(), view.cam_from_world,
        LiveGeometry::Picture::kIsHeld);
    if (options_.deterministic && options_.cover.by != CoverBy::kBound) geometry_->WorkNow();
  }
  if (meter_) meter_->AddView(*id, frame.image, lens_.recorded(), view.cam_from_world);
  if (geometry_ && options_.lens_may_change) KeepSmall(*id, frame.image);
  if (errors_ && subject_) {
    auto errors = std::make_shared<ErrorMap>(*errors_);
    errors->AddView(view.cam_from_world.OriginInSource() - subject_->center_in_world);
    errors_ = std::move(errors);
  }
  if (!map_) return id;
  auto map = std::make_shared<CoverageMap>(*map_);
  map->Add(CriterionView::From(lens_.recorded(), view.cam_from_world, options_.coverage_width_px));
  map_ = std::move(map);
  painted_anew_ = false;
  DropCoveredAgain();
  return id;
}

// What was measured with the view's help.
void CaptureRecord::ForgetMeasuredAround(const Rigid3& cam_from_world) {
  if (!errors_ || !subject_) return;
  auto errors = std::make_shared<ErrorMap>(*errors_);
  errors->RemoveView(cam_from_world.OriginInSource() - subject_->center_in_world,
                     ErrorMeter::Options{}.view_reach);
  errors_ = std::move(errors);
}

std::size_t CaptureRecord::TakeBack(const std::vector<int>& ids) {
  std::vector<int> taken;
  for (const int id : ids) {
    const auto view = std::ranges::find(views_.views(), id, &RecordedViews::Entry::id);
    if (view != views_.views().end()) {
      const Rigid3 cam_from_world = view->cam_from_world;
      views_.Remove(id);
      if (geometry_) geometry_->RemoveView(id);
      if (meter_) meter_->RemoveView(id, cam_from_world);
      small_.erase(id);
      ForgetMeasuredAround(cam_from_world);
      taken.push_back(id);
    } else if (std::ranges::find(taken, id) == taken.end()) {
      say_(fmt::format("there is no view {} to take back", id));
    }
  }
  if (taken.empty()) {
    if (ids.empty()) say_("there is no view to take back");
    return 0;
  }
  std::ranges::sort(taken);
  spool_.RemoveViews({taken.begin(), taken.end()});
  const double reopened = Repaint();
  say_(fmt::format("taken back, kept in unposed/: {}{}", ViewsInWords(taken),
                   map_ ? "; " + ReopenedInWords(reopened) : ""));
  return taken.size();
}

// Returns false when the disk is behind. `moved`: whether any view moved enough.
bool CaptureRecord::MoveViews(const tracking::PoseSource& poses, bool last, bool& moved) {
  moved = false;
  if (views_.empty()) return true;
  const std::map<int, Rigid3> now = views_.PosesNow(poses);
  const double largest_move = views_.LargestMove(now, map_ ? &map_->subject() : nullptr);
  if (largest_move <= 0 || (!last && largest_move < options_.worth_painting_anew)) return true;
  if (!last && !spool_.TryUpdatePoses(now)) return false;
  views_.MoveTo(now);
  if (geometry_) geometry_->MoveViews(now);
  if (meter_) meter_->MoveViews(now);
  moved = true;
  return true;
}

bool CaptureRecord::CorrectPoses(const tracking::PoseSource& poses, bool last,
                                 const std::optional<Subject>& subject) {
  bool views_moved = false;
  if (!MoveViews(poses, last, views_moved)) return false;
  if (!views_moved && !subject) return true;
  if (subject) MoveSubject(*subject);
  const double reopened = Repaint();
  if (reopened >= options_.worth_telling) say_("poses were corrected: " + ReopenedInWords(reopened));
  return true;
}

void CaptureRecord::MoveSubject(const Subject& subject) {
  subject_ = subject;
  if (geometry_) geometry_->SetSubject(subject);
  measured_over_.reset();  // the meter gets the subject with the mesh
  spool_.SetSubject(subject);
}

void CaptureRecord::KeepSmall(int id, const Image& image) {
  cv::Mat small = SmallSrgb8(image, kSmallSide), grey;
  const double scale = static_cast<double>(kSmallSide) / std::max(small.cols, small.rows);
  if (scale < 1) cv::resize(small, small, {}, scale, scale, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  small_[id] = grey;
}

void CaptureRecord::GoOverToLens(const CameraModel& before, const tracking::PoseSource& poses, bool last,
                                 const std::optional<Subject>& subject) {
  const int side = std::max(before.width, before.height);
  views_.FindAnew(
      poses, LargestShiftPx(before, lens_.recorded(), side) / (0.5 * std::hypot(before.width, before.height)),
      subject ? &*subject : nullptr);
  const std::map<int, Rigid3> now = views_.PosesNow(poses);
  if (!last) spool_.UpdateLens(lens_.recorded(), lens_.FoundSource(), now);
  views_.MoveTo(now);
  if (subject) MoveSubject(*subject);
  if (LargestShiftPx(geometry_lens_, lens_.recorded(), kSmallSide) > options_.same_pictures_px) {
    StartGeometryAgain();
  } else {
    if (geometry_) geometry_->MoveViews(now);
    if (meter_) meter_->MoveViews(now);
  }
  Repaint();
}

void CaptureRecord::StartGeometryAgain() {
  geometry_lens_ = lens_.recorded();
  measured_over_.reset();
  if (geometry_) geometry_->StartAgain();
  if (meter_) meter_->StartAgain();
  if (errors_) errors_ = std::make_shared<const ErrorMap>();
  for (const RecordedViews::Entry& view : views_.views()) {
    const auto small = small_.find(view.id);
    if (small == small_.end()) continue;
    const auto read = [grey = small->second] { return Srgb8({.pixels = grey}); };
    if (geometry_) geometry_->AddView(view.id, read, geometry_lens_, view.cam_from_world);
    if (meter_) meter_->AddView(view.id, {.pixels = small->second}, geometry_lens_, view.cam_from_world);
  }
}

std::optional<MeasuredFrame> CaptureRecord::Measure(const Frame& frame, const CameraModel& camera,
                                                    const tracking::Track& track) {
  if (!meter_ || !subject_ || !track.cam_from_world) return std::nullopt;
  const std::shared_ptr<const LiveMesh> newest = mesh();
  if (!newest) return std::nullopt;
  if (newest != measured_over_) {
    meter_->SetGeometry(*subject_, newest->mesh);
    measured_over_ = newest;
  }
  std::optional<MeasuredFrame> measured, again;
  try {
    measured = meter_->Measure({.image = frame.image,
                                .camera = camera,
                                .cam_from_world = *track.cam_from_world,
                                .center_sigma = track.center_sigma,
                                .time_s = frame.device_time_s});
    again = meter_->MeasureAgain();
  } catch (const std::exception& error) {
    say_(fmt::format("measuring errors: {}; the capture goes on, the bound decides", error.what()));
    meter_.reset();
    errors_.reset();
    if (map_) PaintAnew();
    return std::nullopt;
  }
  frames_measured_ += measured.has_value();
  for (const auto& one : {again, measured})
    if (one) {
      auto errors = std::make_shared<ErrorMap>(*errors_);
      errors->Add(*one);
      errors_ = std::move(errors);
    }
  // Often enough for a hand that moves, and seldom enough for a map of thousands of cells. Guessed.
  constexpr double kFollowEvery_s = 1;
  if (options_.cover.by != CoverBy::kBound && map_ &&
      std::abs(frame.device_time_s - followed_s_) >= kFollowEvery_s) {
    followed_s_ = frame.device_time_s;
    FollowErrorsNow();
  }
  return measured;
}

void CaptureRecord::FollowErrorsNow() {
  auto map = std::make_shared<CoverageMap>(*map_);
  FollowErrors(*errors_, options_.cover, *map);
  map_ = std::move(map);
}

bool CaptureRecord::IsCapCovered(double share, const tracking::PoseSource& poses) {
  if (!options_.map.cap || !map_ || map_->CoveredShare() < share) return false;
  if (!CorrectPoses(poses, false)) return false;
  if (!painted_anew_) PaintAnew();  // follows the errors, too
  return map_->CoveredShare() >= share;
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
  std::map<int, Rigid3> final_poses;
  for (const RecordedViews::Entry& view : views_.views()) final_poses[view.id] = view.cam_from_world;
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
    // Nothing, where everything that was measured has been taken back.
    if (errors_ && (!errors_->empty() || !earlier_measured_.directions.empty()))
      writer.SetMeasured(
          ToMeasuredErrors(*errors_, Name(options_.cover.by), options_.cover.db, frames_measured_));
    writer.Close(earlier_s_ + capture_s, all_reasons);
    if (geometry_)
      closed.geometry = FinishGeometry(root, closing);
    else if (closed.recorded > 0 && std::filesystem::exists(root / render::kMeshProxyFile))
      say_(fmt::format("{} was made without {} of this session; '{}' makes it anew", render::kMeshProxyFile,
                       Counted(closed.recorded, "view"), render::ProxyCommand(root)));
    spool_.Folder().RequireInPlace();
  } catch (const std::exception& error) {
    closed.problem = spool_.Folder().WhyGone().value_or(error.what());
    closed.geometry.reset();
  }
  return closed;
}

void CaptureRecord::Describe(CaptureState& state) const {
  state.subject = subject_;
  state.recorded_camera_index = camera_index_;
  state.coverage = map_;
  state.view_ids = views_.Ids();
  if (options_.map.cap) state.covered = map_ ? map_->CoveredShare() : 0;
  for (const Reopened& cell : reopened_) {
    state.reopened.push_back(cell.direction);
    state.reopened_share += cell.share;
  }
  state.errors = errors_ && !errors_->empty() ? errors_ : nullptr;
  state.cover = options_.cover;
  state.mesh = mesh();
  state.mesh_may_come = geometry_ && !geometry_->HasFailed();
  state.errors_may_come = meter_ && (state.mesh || state.mesh_may_come);
}

}  // namespace ulf::coverage
