#include "core/light_field/folder/light_field_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/folder/derived_files.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/folder/writer_state.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {

namespace fs = std::filesystem;

namespace {

// Copies a frame's metadata.
void NoteFrame(const Frame& frame, View& view) {
  view.f_number = frame.f_number;
  view.focal_mm = frame.focal_mm;
  view.lens = frame.lens;
  view.device_time_s = frame.device_time_s;
  view.host_time_s = frame.host_time_s;
  view.exposure_s = frame.exposure_s;
  view.gain = frame.gain;
  view.black_level = frame.black_level;
  view.frame_id = frame.told_id;
  view.line_status = frame.line_status;
  view.on_shared_clock = frame.on_shared_clock;
}

}  // namespace

LightFieldWriter LightFieldWriter::Create(const fs::path& dir, const CaptureHeader& header) {
  return LightFieldWriter(WriterState::Created(dir, header));
}

LightFieldWriter LightFieldWriter::Resume(const fs::path& dir) {
  return LightFieldWriter(WriterState::Resumed(dir));
}

LightFieldWriter::LightFieldWriter(std::unique_ptr<WriterState> state) : state_(std::move(state)) {}
LightFieldWriter::LightFieldWriter(LightFieldWriter&&) noexcept = default;
LightFieldWriter& LightFieldWriter::operator=(LightFieldWriter&&) noexcept = default;
LightFieldWriter::~LightFieldWriter() = default;
const LightField& LightFieldWriter::Contents() const { return state_->light_field; }

int LightFieldWriter::NextViewId() const { return state_->next_view_id; }

int LightFieldWriter::ReserveViewId() { return state_->next_view_id++; }

void LightFieldWriter::UseCamera(int index) { state_->camera = index; }

int LightFieldWriter::CameraInUse() const { return state_->camera; }

const CameraModel& LightFieldWriter::CameraAsNoted() const {
  return state_->recorded_cameras.at(static_cast<std::size_t>(state_->camera));
}

int LightFieldWriter::AddCamera(const NewCamera& camera) {
  LightField& light_field = state_->light_field;
  const CameraModel& now = light_field.cameras.at(static_cast<std::size_t>(state_->camera));
  camera.camera.Validate("the camera for " + light_field.root.string());
  if (camera.camera.width != now.width || camera.camera.height != now.height)
    throw Error("{}: its pictures have {}x{} pixels, the other camera's {}x{}; begin a new light field",
                light_field.root.string(), now.width, now.height, camera.camera.width, camera.camera.height);
  state_->journal.AddCamera(static_cast<int>(light_field.cameras.size()), camera);
  state_->recorded_cameras.push_back(camera.camera);
  return state_->camera = light_field.AddCamera(camera);
}

void LightFieldWriter::KeepMosaics(bool keep) { state_->keep_mosaics = keep; }

ViewFiles LightFieldWriter::Files(const Frame& frame, MakePictures pictures) const {
  return MakeViewFiles(frame, state_->keep_mosaics, pictures, &state_->white_balance);
}

View LightFieldWriter::AddView(const Frame& frame, View view) {
  view.id = ReserveViewId();
  const NewView added{frame, std::move(view), Files(frame, MakePictures::kNow)};
  return AddViews({&added, 1}).front();
}

std::vector<View> LightFieldWriter::AddViews(std::span<const NewView> added) {
  const fs::path& root = state_->light_field.root;
  std::vector<View> views;
  int last_id = state_->light_field.views.empty() ? 0 : state_->light_field.views.back().id;
  for (const NewView& add : added) {
    View& view = views.emplace_back(add.view);
    view.camera = state_->camera;
    if (view.id == 0) view.id = ReserveViewId();
    state_->RequireReserved(view.id, last_id);
    last_id = view.id;
    const std::string name = fmt::format("{:06}", view.id);
    view.image_path = "images/" + name + add.files.image_extension;
    view.master_path = add.files.master ? "masters/" + name + add.files.master->extension : "";
    view.master_transfer = add.files.master_transfer;
    view.master_mosaic = add.files.master_mosaic;
    if (add.files.raw) view.raw_white_balance = state_->white_balance.WhiteBalanceFor(*add.files.raw);
    NoteFrame(add.frame, view);
  }
  state_->folder.RequireInPlace();
  FileBatch batch(FileBatch::Existing::kKeep);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (added[i].files.master) {
      state_->MakeFolder("masters");
      batch.Write(root / views[i].master_path, added[i].files.master->content);
    }
    if (added[i].files.image) batch.Write(root / views[i].image_path, added[i].files.image->content);
  }
  batch.Commit([&] { state_->journal.AddViews(views); });
  state_->light_field.views.insert(state_->light_field.views.end(), views.begin(), views.end());
  return views;
}

void LightFieldWriter::AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view,
                                   bool pose_is_between) {
  View* const view = state_->light_field.FindView(view_id);
  if (!view) return KeepUnposed(frame, "it is another exposure of a view that was taken back");
  const fs::path& root = state_->light_field.root;
  const ViewFiles files = Files(frame, MakePictures::kLater);
  const std::string name = ExposureName(view_id, view->exposures.size() + 1);
  View taken;
  NoteFrame(frame, taken);
  ViewExposure exposure{taken, exposure_from_view, pose_is_between};
  if (files.image) exposure.image_path = name + files.image_extension;
  if (files.master) exposure.master_path = name + ".master" + files.master->extension;
  exposure.master_transfer = files.master_transfer;
  exposure.master_mosaic = files.master_mosaic;
  if (files.raw) exposure.raw_white_balance = state_->white_balance.WhiteBalanceFor(*files.raw);
  state_->MakeFolder(kExposuresFolder);
  FileBatch batch(FileBatch::Existing::kKeep);
  if (files.image) batch.Write(root / exposure.image_path, files.image->content);
  if (files.master) batch.Write(root / exposure.master_path, files.master->content);
  batch.Commit([&] { state_->journal.AddExposure(view_id, exposure); });
  view->exposures.push_back(std::move(exposure));
}

void LightFieldWriter::SetMerged(int view_id, const std::string& exr, int exposures, double ghost_share) {
  View* const view = state_->light_field.FindView(view_id);
  if (!view) throw Error("{}: there is no view {}", state_->light_field.root.string(), view_id);
  const MergedExposures merged{MergedPath(view_id), exposures, ghost_share};
  state_->MakeFolder(kMergedFolder);
  WriteFileAtomically(state_->light_field.root / merged.path, exr);
  state_->journal.NoteMerged(view_id, merged);
  view->merged = merged;
}

void LightFieldWriter::UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                                   const std::map<int, CorrectedLens>& cameras) {
  if (cam_from_world_by_view.empty() && cameras.empty()) return;
  state_->journal.UpdatePoses(cam_from_world_by_view, cameras);
  for (const auto& [index, lens] : cameras) {
    state_->light_field.cameras[static_cast<std::size_t>(index)] = lens.camera;
    if (!lens.calibration_source.empty())
      state_->light_field.calibration_sources[index] = lens.calibration_source;
  }
  for (View& view : state_->light_field.views)
    if (const auto found = cam_from_world_by_view.find(view.id); found != cam_from_world_by_view.end())
      view.cam_from_world = found->second;
  for (const View& view : state_->light_field.views)
    if (cam_from_world_by_view.contains(view.id) || cameras.contains(view.camera))
      state_->moved_since_points.insert(view.id);
}

void LightFieldWriter::SetSubject(const Subject& subject) {
  state_->journal.SetSubject(subject);
  PlaceSubject(subject, state_->light_field);
}

void LightFieldWriter::SetUp(const Eigen::Vector3d& up_in_world) {
  state_->journal.SetUp(up_in_world);
  state_->light_field.up_in_world = up_in_world.normalized();
}

void LightFieldWriter::SetGoal(const CoverageGoal& goal) {
  if (state_->light_field.goal == goal) return;
  state_->journal.SetGoal(goal);
  state_->light_field.goal = goal;
}

void LightFieldWriter::SetReadout(const ShutterReadout& readout) {
  if (state_->light_field.readout == readout) return;
  state_->journal.SetReadout(readout);
  state_->light_field.readout = readout;
}

void LightFieldWriter::SetTurntable(const Turntable& turntable) {
  if (state_->light_field.turntable == turntable) return;
  state_->journal.SetTurntable(turntable);
  state_->light_field.turntable = turntable;
}

void LightFieldWriter::SetMasks(const std::map<int, cv::Mat>& masks) {
  const fs::path& root = state_->light_field.root;
  state_->MakeFolder("masks");
  FileBatch batch(FileBatch::Existing::kKeep);
  std::map<int, std::string> paths;
  std::vector<std::string> contents, replaced;
  contents.reserve(masks.size());
  for (const View& view : state_->light_field.views) {
    const auto mask = masks.find(view.id);
    if (mask == masks.end()) continue;
    std::string path = fmt::format("masks/{:06}.png", view.id);
    for (int i = 2; fs::exists(root / path); ++i) path = fmt::format("masks/{:06}-{}.png", view.id, i);
    batch.Write(root / path, ContentOf(contents.emplace_back(PngBytes(mask->second))));
    paths[view.id] = path;
    if (!view.mask_path.empty()) replaced.push_back(view.mask_path);
  }
  if (paths.empty()) return;
  batch.Commit([&] { state_->journal.SetMasks(paths); });
  for (View& view : state_->light_field.views)
    if (const auto path = paths.find(view.id); path != paths.end()) view.mask_path = path->second;
  for (const std::string& path : replaced) {
    state_->MakeFolder(fs::path("kept") / FolderOf(path));
    MoveToKept(root, path, path);
  }
}

void LightFieldWriter::SetPoints(std::vector<ScenePoint> points) {
  const LightField& now = state_->light_field;
  if (points.empty() && !now.points.empty()) return;
  state_->folder.RequireInPlace();
  if (!now.points.empty() && StatisticsOf(now.points).tracked == 0)
    for (const char* file : {"points.ply", "points.ulf"})
      LinkToKept(now.root, file);  // until others replace them
  state_->light_field.points = std::move(points);
  state_->moved_since_points.clear();
  MeasurePoints(state_->light_field);
  WritePoints(state_->light_field);
}

void LightFieldWriter::NoteGap(double from_s, double to_s, const std::string& reason) {
  state_->journal.NoteGap(from_s, to_s, reason);
}

void LightFieldWriter::RemoveViews(const std::set<int>& view_ids) {
  state_->TakeOutOfJournal(view_ids);
  for (const int id : view_ids) {
    std::map<std::string, fs::path>& files = state_->to_unposed[id];
    while (!files.empty()) {
      const auto& [from, to] = *files.begin();
      MoveWithoutReplacing(state_->light_field.root / from, to);
      files.erase(files.begin());
    }
  }
  // This comes last: until all of them are moved, the caller may retry all.
  for (const int id : view_ids) state_->to_unposed.erase(id);
}

void LightFieldWriter::KeepUnposed(const Frame& frame, const std::string& problem) {
  state_->MakeFolder("unposed");
  const ViewFiles files = Files(frame, MakePictures::kNow);
  UnposedPhotograph photograph{.view = {}, .problem = problem};
  View& view = photograph.view;
  NoteFrame(frame, view);
  view.camera = state_->camera;
  // Otherwise the raw file exists already.
  const bool has_master = files.master && (!frame.image.empty() || frame.encoded);
  const auto is_taken = [&](const std::string& path) {
    return !path.empty() && fs::exists(state_->light_field.root / path);
  };
  do {
    const std::string name = fmt::format("unposed/unposed_{:06}", state_->next_unposed++);
    view.image_path = name + files.image_extension;
    if (has_master) view.master_path = name + ".master" + files.master->extension;
  } while (is_taken(view.image_path) || is_taken(view.master_path));
  FileBatch batch(FileBatch::Existing::kKeep);
  batch.Write(state_->light_field.root / view.image_path, files.image->content);
  if (has_master) {
    batch.Write(state_->light_field.root / view.master_path, files.master->content);
    view.master_transfer = files.master_transfer;
    view.master_mosaic = files.master_mosaic;
    if (files.raw) view.raw_white_balance = state_->white_balance.WhiteBalanceFor(*files.raw);
  }
  batch.Commit([&] { state_->journal.NoteUnposed(photograph); });
  state_->light_field.unposed.push_back(std::move(photograph));
}

void LightFieldWriter::AddUnposed(std::vector<View> photographs) {
  LightField& light_field = state_->light_field;
  for (View& view : photographs) {
    state_->RequireReserved(view.id, light_field.views.empty() ? 0 : light_field.views.back().id);
    std::vector<fs::path> done;  // paths in unposed/
    FileBatch batch(FileBatch::Existing::kKeep);
    const auto copy = [&](const char* folder, std::string& path) {
      const fs::path from = light_field.root / path;
      path = fmt::format("{}/{:06}{}", folder, view.id, from.extension().string());
      state_->MakeFolder(folder);
      const std::string bytes = ReadWholeFile(from);
      batch.Write(light_field.root / path, ContentOf(bytes));
      done.push_back(from);
    };
    copy("images", view.image_path);
    if (!view.master_path.empty()) copy("masters", view.master_path);
    batch.Commit([&] { state_->journal.AddViews({&view, 1}); });
    std::error_code refused;  // otherwise it remains in both places
    for (const fs::path& file : done) fs::remove(file, refused);
    std::erase_if(light_field.unposed, [&](const UnposedPhotograph& noted) {
      return light_field.root / noted.view.image_path == done.front();
    });
    light_field.views.push_back(std::move(view));
  }
}

void LightFieldWriter::SetMeasured(MeasuredErrors measured) {
  state_->light_field.measured = std::move(measured);
}

void LightFieldWriter::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons) {
  state_->journal.Close(capture_s, reasons, state_->light_field.measured);
  state_->light_field.capture_s = capture_s;
  state_->light_field.reasons = reasons;
  FitPointsOf(state_->moved_since_points, state_->light_field);
  MeasurePoints(state_->light_field);
  state_->folder.RequireInPlace();
  WriteDerivedFiles(state_->light_field);
}

}  // namespace ulf
