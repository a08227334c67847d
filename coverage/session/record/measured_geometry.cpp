#include "coverage/session/record/measured_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/session/record/geometry_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"

namespace ulf::coverage {
namespace {

ErrorMeter::Options MeterOptions(const CaptureOptions& options) {
  ErrorMeter::Options meter;
  // What only is shown may cost less than what decides. Guessed.
  constexpr double kOnlyShown = 0.1;
  if (options.cover.by == CoverBy::kBound) meter.processor_share = kOnlyShown;
  meter.every_frame = options.deterministic;
  meter.good_db = options.cover.db;
  return meter;
}

constexpr int kSmallSide = render::GrowingGeometryOptions{}.size_px;

std::unique_ptr<LiveGeometry> MakeGeometry(const CaptureOptions& options,
                                           const std::filesystem::path& light_field) {
  if (!options.geometry || options.without_subject) return nullptr;
  LiveGeometry::Options live;
  live.light_field = light_field;
  live.threaded = !options.deterministic;
  return std::make_unique<LiveGeometry>(live);
}

// Says of a mesh that is there that it stays, and what is wrong with it. The session before may have ended
// without a mesh of its views.
std::string ExistingMeshStays(const std::filesystem::path& root, bool is_corrected) {
  std::optional<render::GeometryState> state;
  try {
    state = render::GeometryStateOf(ReadLightField(root));
  } catch (const Error&) {
  }
  const std::string command = render::ProxyCommand(root);
  if (state && state->triangles == 0)
    return fmt::format(
        "no view was added: no new mesh is made, and the one that is there cannot be used: {}; '{}' makes it "
        "again",
        state->problem, command);
  if (is_corrected || (state && state->mesh_fits == false))
    return fmt::format(
        "no view was added: the mesh that is there stays, though it is not of the views as they are now; "
        "'{}' makes it and the depth maps anew",
        command);
  return "no view was added, moved or taken back: the mesh that is there stays";
}

}  // namespace

MeasuredGeometry::MeasuredGeometry(const LightField& earlier, const CaptureLens& lens,
                                   const CaptureOptions& options, std::function<void(const std::string&)> say)
    : lens_(lens),
      options_(options),
      say_(std::move(say)),
      earlier_measured_(ValidErrors(earlier).value_or(MeasuredErrors{})),
      frames_measured_(earlier_measured_.frames),
      geometry_(MakeGeometry(options, earlier.root)),
      geometry_lens_(lens.recorded()),
      meter_(geometry_ ? std::make_unique<ErrorMeter>(MeterOptions(options)) : nullptr),
      errors_(meter_ ? std::make_shared<const ErrorMap>() : nullptr) {
  if (geometry_) AddEarlierViews(earlier);
}

void MeasuredGeometry::AddEarlierViews(const LightField& light_field) {
  const auto earlier = std::make_shared<const LightField>(light_field);
  for (const View& view : earlier->views) {
    const auto read = [earlier, &view] { return Srgb8(ReadRecordedImage(*earlier, view)); };
    geometry_->AddView(view.id, read, earlier->CameraOf(view), view.cam_from_world);
    meter_->AddEarlierView(view.id, read, earlier->CameraOf(view), view.cam_from_world);
  }
  geometry_->AddMaps([earlier] { return ReadKnownMaps(*earlier); });
}

void MeasuredGeometry::SayProblem() {
  if (const auto problem = geometry_->TakeProblem()) say_(*problem);
}

// Snapshots that were handed out stay as they are.
void MeasuredGeometry::Note(const std::function<void(ErrorMap&)>& change) {
  auto errors = std::make_shared<ErrorMap>(*errors_);
  change(*errors);
  errors_ = std::move(errors);
}

void MeasuredGeometry::SetSubject(const Subject& subject, bool goes_on) {
  MoveSubject(subject);
  // Directions are from another point now.
  if (meter_)
    errors_ = std::make_shared<const ErrorMap>(goes_on ? ErrorMapOf(earlier_measured_) : ErrorMap());
}

void MeasuredGeometry::MoveSubject(const Subject& subject) {
  subject_ = subject;
  if (geometry_) geometry_->SetSubject(subject);
  measured_over_.reset();  // the meter gets the subject with the mesh
}

void MeasuredGeometry::Added(const RecordedViews::Entry& view, const Image& image) {
  if (geometry_) {
    SayProblem();
    geometry_->AddView(
        view.id, [image] { return Srgb8(image); }, lens_.recorded(), view.cam_from_world,
        LiveGeometry::Picture::kIsHeld);
    if (options_.deterministic && options_.cover.by != CoverBy::kBound) geometry_->WorkNow();
  }
  if (meter_) meter_->AddView(view.id, image, lens_.recorded(), view.cam_from_world);
  if (geometry_ && options_.LensMayChange()) KeepSmall(view.id, image);
  if (errors_ && subject_)
    Note([&](ErrorMap& errors) {
      errors.AddView(view.cam_from_world.OriginInSource() - subject_->center_in_world);
    });
}

void MeasuredGeometry::Removed(const RecordedViews::Entry& view) {
  if (geometry_) geometry_->RemoveView(view.id);
  if (meter_) meter_->RemoveView(view.id, view.cam_from_world);
  small_.erase(view.id);
  // Errors that were measured with the view are no longer valid.
  if (errors_ && subject_)
    Note([&](ErrorMap& errors) {
      errors.RemoveView(view.cam_from_world.OriginInSource() - subject_->center_in_world,
                        ErrorMeter::kViewReach);
    });
}

void MeasuredGeometry::Moved(const RecordedViews& views) {
  if (!(geometry_lens_ == lens_.recorded()) &&
      LargestShiftPx(geometry_lens_, lens_.recorded(), kSmallSide) > LiveGeometry::kMoved_px)
    return StartAgain(views);
  const std::map<int, Rigid3> poses = views.Poses();
  if (geometry_) geometry_->MoveViews(poses);
  if (meter_) meter_->MoveViews(poses);
}

void MeasuredGeometry::KeepSmall(int id, const Image& image) {
  cv::Mat small = SmallSrgb8(image, kSmallSide), grey;
  const double scale = static_cast<double>(kSmallSide) / std::max(small.cols, small.rows);
  if (scale < 1) cv::resize(small, small, {}, scale, scale, cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  small_[id] = grey;
}

void MeasuredGeometry::StartAgain(const RecordedViews& views) {
  geometry_lens_ = lens_.recorded();
  measured_over_.reset();
  if (geometry_) geometry_->StartAgain();
  if (meter_) meter_->StartAgain();
  if (errors_) errors_ = std::make_shared<const ErrorMap>();
  for (const RecordedViews::Entry& view : views.views()) {
    const auto small = small_.find(view.id);
    if (small == small_.end()) continue;
    const auto read = [grey = small->second] { return Srgb8({.pixels = grey}); };
    if (geometry_) geometry_->AddView(view.id, read, geometry_lens_, view.cam_from_world);
    if (meter_) meter_->AddView(view.id, {.pixels = small->second}, geometry_lens_, view.cam_from_world);
  }
}

MeasuredGeometry::Measurement MeasuredGeometry::Measure(const Frame& frame, const CameraModel& camera,
                                                        const tracking::Track& track) {
  if (!meter_ || !subject_ || !track.cam_from_world) return {};
  const std::shared_ptr<const LiveMesh> newest = mesh();
  if (!newest) return {};
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
    return {Attempt::kFailed, {}};
  }
  frames_measured_ += measured.has_value();
  for (const auto& one : {again, measured})
    if (one) Note([&](ErrorMap& errors) { errors.Add(*one); });
  return {Attempt::kMade, measured};
}

std::optional<MeasuredErrors> MeasuredGeometry::ForLightField() const {
  // Nothing, where everything that was measured has been taken back.
  if (!errors_ || (errors_->empty() && earlier_measured_.directions.empty())) return std::nullopt;
  return ToMeasuredErrors(*errors_, Name(options_.cover.by), options_.cover.db, frames_measured_);
}

// The mesh that was there may be of another program, or a finer one: without new views it stays where it is,
// with its depth maps, and with them until the new one is at least as good.
std::optional<FinishedGeometry> MeasuredGeometry::Finish(
    const OpenedFolder& folder, const std::filesystem::path& root, bool has_new_views,
    const std::function<void(const std::string&)>& closing) {
  if (!has_new_views && std::filesystem::exists(root / render::kMeshProxyFile)) {
    say_(ExistingMeshStays(root, geometry_->IsCorrected()));
    return std::nullopt;
  }
  closing("depth maps and the mesh");
  FinishedGeometry finished = geometry_->Finish();
  folder.RequireInPlace();
  Stopwatch writing;
  SayProblem();
  if (!finished.views_left_out.empty())
    say_(fmt::format("geometry: there was no time to look at {}; '{}' makes a mesh of all",
                     Counted(finished.views_left_out.size(), "view"), render::ProxyCommand(root)));
  if (finished.mesh) {
    if (const std::string why = WhyExistingIsBetter(root, finished); !why.empty()) {
      say_(
          fmt::format("views were added: the mesh that is there stays, because a new one would not be as "
                      "good everywhere ({}); '{}' makes one of all views",
                      why, render::ProxyCommand(root)));
      return std::nullopt;
    }
    closing("depth maps and the mesh to the disk");
    WriteGeometry(root, finished, say_);
  }
  finished.seconds += writing.LapSeconds();
  return finished;
}

}  // namespace ulf::coverage
