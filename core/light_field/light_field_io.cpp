#include "core/light_field/light_field_io.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <regex>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/shell_word.h"
#include "core/image/raw_file.h"
#include "core/light_field/derived_files.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/transforms_json.h"
#include "core/light_field/folder_check.h"
#include "core/light_field/journal.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"
#include "core/light_field/view_exposures.h"
#include "core/light_field/view_files.h"
#include "core/light_field/view_numbers.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

bool IsBeingWritten(const fs::path& journal) {
  const int descriptor = open(journal.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return locked;
}

void RequireImages(const LightField& light_field, const FolderCheck& check) {
  if (check.missing_images.empty()) return;
  const int id = *check.missing_images.begin();
  const auto view = std::ranges::find_if(light_field.views, [id](const View& each) { return each.id == id; });
  throw Error(
      "{0}: the image '{1}' of view {2} is missing{3}; restore it, or take such views out: ulf repair {4}",
      light_field.root.string(), view->image_path, id,
      check.missing_images.size() > 1 ? fmt::format(" (and {} more)", check.missing_images.size() - 1) : "",
      ShellWord(light_field.root.string()));
}

// NAME.PID-NUMBER.part, as FileBatch calls them.
bool IsOurTemporary(const fs::directory_entry& entry) {
  static const std::regex kName(R"(.+\.[0-9]+-[0-9]+\.part)");
  return entry.is_regular_file() && std::regex_match(entry.path().filename().string(), kName);
}

void RemoveLeftovers(const fs::path& dir) {
  for (const char* folder :
       {".", "images", "masters", "masks", "unposed", "sparse/0", kExposuresFolder, kMergedFolder}) {
    if (!fs::is_directory(dir / folder)) continue;
    for (const auto& entry : fs::directory_iterator(dir / folder))
      if (IsOurTemporary(entry)) fs::remove(entry.path());
  }
}

// The name in unposed/: of a master beside the photograph's, which may have the same ending.
fs::path UnposedName(const fs::path& file) {
  const fs::path folder = file.parent_path();
  const bool is_master = folder == "masters" || folder == kMergedFolder;
  return is_master ? fs::path(file.stem().string() + ".master" + file.extension().string()) : file.filename();
}

// Files of views that a killed writer had removed from the journal but not yet moved.
void MoveRemoved(const fs::path& dir, const JournalContents& journal) {
  std::set<std::string> named;
  for (const View& view : journal.light_field.views) named.merge(FilesOf(view));
  for (const std::string& file : journal.removed_files) {
    if (file.empty() || named.contains(file) || !fs::is_regular_file(dir / file)) continue;
    MakeFolder(dir / "unposed");
    MoveWithoutReplacing(dir / file, dir / "unposed" / UnposedName(file));
  }
}

// Cuts off damaged lines at the journal's end; keeps them where they are more than one partial line.
void CutEnd(const fs::path& dir, const JournalContents& contents, Journal& journal) {
  const std::string bytes = ReadWholeFile(dir / kJournalFile);
  const std::string end = bytes.substr(std::min(contents.whole_bytes, bytes.size()));
  if (end.find('\n') != std::string::npos) {
    MakeFolder(dir / "kept");
    const fs::path copy = dir / "kept" / fmt::format("journal-end.{}.part", getpid());
    WriteFileAtomically(copy, end);
    const fs::path kept = MoveWithoutReplacing(copy, dir / "kept" / "journal-end.jsonl");
    spdlog::warn("{}: its last lines are damaged and cut off; they are kept as {}",
                 (dir / kJournalFile).string(), kept.string());
  }
  journal.CutAt(contents.whole_bytes);
}

// Logged once per process, because some commands read a light field several times.
void WarnOnce(const std::vector<std::string>& words) {
  static Mutex mutex;
  static std::set<std::string> logged ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  for (const std::string& each : words)
    if (logged.insert(each).second) spdlog::warn("{}", each);
}

// Refuses a folder whose other files contain more than its journal, before anything is written.
void RequireWholeJournal(const fs::path& dir, const FolderCheck& check) {
  if (!check.KnowsMoreThanJournal()) return;
  std::string words;
  for (const std::string& each : check.words) words += each + "; ";
  throw Error("{}nothing was written; put it back with 'ulf repair {} --write', then go on", words,
              ShellWord(dir.string()));
}

void RequireMatchingPictures(const LightField& light_field) {
  const PictureCheck check = CheckPictures(light_field);
  if (!check.damaged.empty())
    spdlog::warn("{}: the photographs of {} cannot be read; 'ulf repair {}' shows the remedy",
                 light_field.root.string(), ViewNumbers(check.damaged), ShellWord(light_field.root.string()));
  if (check.others.empty()) return;
  throw Error(
      "{0}: the photographs in images/ of {1} differ from their masters, are damaged, or have another size "
      "than "
      "their camera; nothing was written; 'ulf repair {2}' shows the remedy",
      light_field.root.string(), ViewNumbers(check.others), ShellWord(light_field.root.string()));
}

LightField ReadForeignSet(const fs::path& transforms) {
  LightField light_field = ReadTransformsJson(transforms);
  WarnOnce(light_field.doubts);
  return light_field;
}

// What a frame says of itself.
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

// By what the first raw file is developed that can still be read.
void LockAsBefore(const LightField& light_field, LockedWhiteBalance& white_balance) {
  for (const View& view : light_field.views) {
    if (!IsRawFile(view.master_path)) continue;
    try {
      RawFacts facts = ReadRawFacts((light_field.root / view.master_path).string());
      facts.white_balance = view.raw_white_balance.value_or(facts.white_balance);
      white_balance.InPlaceOf(facts);
      return;
    } catch (const Error&) {
      continue;
    }
  }
}

// A capture that ended before its first view left only derived files.
bool IsUnused(const fs::path& dir) {
  std::error_code unknown;
  if (!fs::is_regular_file(dir / kJournalFile, unknown)) return false;
  for (const char* folder : {"images", "masters", "unposed"})
    if (fs::is_directory(dir / folder, unknown) && !fs::is_empty(dir / folder, unknown)) return false;
  try {
    // Without a header the capture ended before it began.
    if (ReadWholeFile(dir / kJournalFile).find('\n') == std::string::npos)
      return !fs::exists(dir / kTransformsFile) && !fs::exists(dir / "sparse");
    return ReadJournal(dir / kJournalFile).next_view_id == 1;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

LightField ReadLightField(const fs::path& path) {
  std::error_code unknown;
  if (fs::is_regular_file(path, unknown) && path.filename() == kJournalFile)
    throw Error("{}: give the folder that holds it: {}", path.string(), FolderOf(path).string());
  if (fs::is_regular_file(path, unknown)) return ReadForeignSet(path);
  if (!fs::is_directory(path, unknown))
    throw Error("{}: there is no such folder; give the folder of a light field", path.string());
  if (!fs::is_regular_file(path / kJournalFile)) {
    if (fs::is_regular_file(path / kTransformsFile)) return ReadForeignSet(path / kTransformsFile);
    if (IsJournalMissing(path) || !FormatsIn(path).empty()) throw MissingJournalError(path);
    throw Error(
        "{}: holds no light field: neither {} nor {}; capture or import one{}", path.string(), kJournalFile,
        kTransformsFile,
        fs::is_directory(path / "images", unknown)
            ? fmt::format(" (the photographs in images/ get new poses by 'ulf capture replay:{} -o NEW "
                          "--focal-px F --no-subject')",
                          ShellWord((path / "images").string()))
            : "");
  }
  JournalContents journal = ReadJournal(path / kJournalFile);
  const bool being_written = IsBeingWritten(path / kJournalFile);
  const FolderCheck check = CheckFolder(path, journal, being_written);
  RequireImages(journal.light_field, check);
  LightField light_field = std::move(journal.light_field);
  light_field.doubts = check.words;
  ReadPoints(light_field);
  WarnOnce(light_field.doubts);
  if (check.not_closed && !light_field.views.empty())
    spdlog::debug("{}: transforms.json and sparse/ are older than the journal", path.string());
  return light_field;
}

void WriteLightField(const LightField& light_field) {
  if (light_field.cameras.empty()) throw Error("{}: a light field needs a camera", light_field.root.string());
  Journal journal(light_field.root / kJournalFile);
  journal.CutAt(0);
  journal.Header(light_field);
  if (light_field.up_in_world) journal.SetUp(*light_field.up_in_world);
  if (light_field.goal) journal.SetGoal(*light_field.goal);
  if (light_field.readout) journal.SetReadout(*light_field.readout);
  if (light_field.turntable) journal.SetTurntable(*light_field.turntable);
  if (light_field.subject) journal.SetSubject(*light_field.subject);
  journal.AddViews(light_field.views);
  journal.Close(light_field.capture_s, light_field.reasons, light_field.measured);
  WriteDerivedFiles(light_field);
}

struct LightFieldWriter::State {
  explicit State(const fs::path& dir) : journal(dir / kJournalFile) { light_field.root = dir; }
  void TakeOutOfJournal(int view_id);
  void RequireReserved(int view_id, int last_id) const;

  Journal journal;
  LightField light_field;
  std::atomic<int> next_view_id = 1;
  int next_unposed = 1;
  // Of views that the journal no longer names, by id: files that are still to be moved, and their targets.
  std::map<int, std::map<std::string, fs::path>> to_unposed;
  bool keep_mosaics = false;
  LockedWhiteBalance white_balance;
  std::set<int> moved_since_points;  // views
};

LightFieldWriter::LightFieldWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
LightFieldWriter::LightFieldWriter(LightFieldWriter&&) noexcept = default;
LightFieldWriter& LightFieldWriter::operator=(LightFieldWriter&&) noexcept = default;
LightFieldWriter::~LightFieldWriter() = default;
const LightField& LightFieldWriter::Contents() const { return state_->light_field; }

int LightFieldWriter::NextViewId() const { return state_->next_view_id; }

int LightFieldWriter::ReserveViewId() { return state_->next_view_id++; }

LightFieldWriter LightFieldWriter::Create(const fs::path& dir, const CaptureHeader& header) {
  std::error_code unknown;  // MakeFolder below says what stands in the way
  if (fs::exists(dir, unknown) && !fs::is_directory(dir))
    throw Error("{}: is a file; choose another name", dir.string());
  const bool unused = IsUnused(dir);
  const Error taken("{}: holds a light field already; go on with it (--resume) or choose another folder",
                    dir.string());
  if (!unused && fs::is_regular_file(dir / kJournalFile, unknown)) throw taken;
  if (!unused && fs::is_directory(dir, unknown) && !fs::is_empty(dir, unknown))
    throw Error("{}: the folder is not empty; choose another one", dir.string());
  header.camera.Validate("the camera of " + dir.string());
  const bool made_folder = !fs::exists(dir, unknown);
  MakeFolder(dir / "images");
  auto state = std::make_unique<State>(dir);
  if (unused) {
    if (!IsUnused(dir)) throw taken;  // another process recorded into it before the lock was ours
    state->journal.CutAt(0);
  }
  LightField& light_field = state->light_field;
  light_field.cameras = {header.camera};
  if (header.flat_field) light_field.flat_fields[0] = *header.flat_field;
  if (header.color_profile) light_field.color_profiles[0] = *header.color_profile;
  light_field.device_uri = header.device_uri;
  light_field.device_serial = header.device_serial;
  light_field.device_maker = header.device_maker;
  light_field.device_model = header.device_model;
  light_field.window = header.window;
  light_field.calibration_source = header.calibration_source;
  light_field.units = header.units;
  light_field.threshold_px = header.threshold_px;
  light_field.coverage_width_px = header.coverage_width_px;
  try {
    state->journal.Header(light_field);
    SyncFolder(dir);
  } catch (...) {
    // Without a recorded view no folder remains.
    fs::remove(dir / kJournalFile, unknown);
    fs::remove(dir / "images", unknown);
    if (made_folder) fs::remove(dir, unknown);
    throw;
  }
  return LightFieldWriter(std::move(state));
}

LightFieldWriter LightFieldWriter::Resume(const fs::path& dir) {
  if (!fs::is_regular_file(dir / kJournalFile)) throw MissingJournalError(dir);
  auto state = std::make_unique<State>(dir);
  JournalContents contents = ReadJournal(dir / kJournalFile);
  const FolderCheck check = CheckFolder(dir, contents, false);
  RequireWholeJournal(dir, check);
  RequireImages(contents.light_field, check);
  RequireMatchingPictures(contents.light_field);
  WarnOnce(check.words);
  CutEnd(dir, contents, state->journal);
  RemoveLeftovers(dir);
  ReadPoints(contents.light_field);
  const std::vector<std::string> point_doubts = contents.light_field.doubts;
  WarnOnce(point_doubts);
  MoveRemoved(dir, contents);
  state->light_field = std::move(contents.light_field);
  LockAsBefore(state->light_field, state->white_balance);
  state->light_field.doubts = check.words;
  state->light_field.doubts.insert(state->light_field.doubts.end(), point_doubts.begin(), point_doubts.end());
  // A number in any file name is never used again, even if the journal does not contain it.
  state->next_view_id = std::max(contents.next_view_id, check.highest_number + 1);
  MakeFolder(dir / "images");
  MakeMissingPictures(state->light_field);
  KeepForeignFiles(dir, check, !point_doubts.empty());
  WriteDerivedFilesOrWarn(state->light_field);
  return LightFieldWriter(std::move(state));
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

void LightFieldWriter::State::RequireReserved(int view_id, int last_id) const {
  if (view_id >= next_view_id)
    throw Error("{}: the number of view {} was not reserved", light_field.root.string(), view_id);
  if (view_id <= last_id)
    throw Error("{}: view {} cannot follow view {}", light_field.root.string(), view_id, last_id);
}

std::vector<View> LightFieldWriter::AddViews(std::span<const NewView> added) {
  const fs::path& root = state_->light_field.root;
  std::vector<View> views;
  int last_id = state_->light_field.views.empty() ? 0 : state_->light_field.views.back().id;
  for (const NewView& add : added) {
    View& view = views.emplace_back(add.view);
    if (view.id == 0) view.id = ReserveViewId();
    state_->RequireReserved(view.id, last_id);
    last_id = view.id;
    const std::string name = fmt::format("{:06}", view.id);
    view.image_path = "images/" + name + add.files.image_extension;
    view.master_path = add.files.master ? "masters/" + name + add.files.master->extension : "";
    view.master_transfer = add.files.master_transfer;
    view.master_mosaic = add.files.master_mosaic;
    if (add.files.raw) view.raw_white_balance = state_->white_balance.InPlaceOf(*add.files.raw);
    NoteFrame(add.frame, view);
  }
  FileBatch batch(FileBatch::Existing::kKeep);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (added[i].files.master) {
      MakeFolder(root / "masters");
      batch.Write(root / views[i].master_path, added[i].files.master->content);
    }
    if (added[i].files.image) batch.Write(root / views[i].image_path, added[i].files.image->content);
  }
  batch.Commit();
  try {
    state_->journal.AddViews(views);
  } catch (...) {
    batch.TakeBack();  // a photograph without its journal line is no view
    throw;
  }
  state_->light_field.views.insert(state_->light_field.views.end(), views.begin(), views.end());
  return views;
}

void LightFieldWriter::AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view,
                                   bool pose_is_between) {
  const auto view = std::ranges::find(state_->light_field.views, view_id, &View::id);
  if (view == state_->light_field.views.end())
    return KeepUnposed(frame, "it is another exposure of a view that was taken back");
  const fs::path& root = state_->light_field.root;
  const ViewFiles files = Files(frame, MakePictures::kLater);
  const std::string name = ExposureName(view_id, view->exposures.size() + 1);
  View taken;
  NoteFrame(frame, taken);
  ViewExposure exposure{.image_path = files.image ? name + files.image_extension : "",
                        .master_path = files.master ? name + ".master" + files.master->extension : "",
                        .master_transfer = files.master_transfer,
                        .master_mosaic = files.master_mosaic,
                        .raw_white_balance = {},
                        .exposure_from_view = exposure_from_view,
                        .pose_is_between = pose_is_between,
                        .device_time_s = taken.device_time_s,
                        .host_time_s = taken.host_time_s,
                        .exposure_s = taken.exposure_s,
                        .gain = taken.gain,
                        .black_level = taken.black_level,
                        .f_number = taken.f_number};
  if (files.raw) exposure.raw_white_balance = state_->white_balance.InPlaceOf(*files.raw);
  MakeFolder(root / kExposuresFolder);
  FileBatch batch(FileBatch::Existing::kKeep);
  if (files.image) batch.Write(root / exposure.image_path, files.image->content);
  if (files.master) batch.Write(root / exposure.master_path, files.master->content);
  batch.Commit();
  try {
    state_->journal.AddExposure(view_id, exposure);
  } catch (...) {
    batch.TakeBack();  // the caller tries again
    throw;
  }
  view->exposures.push_back(std::move(exposure));
}

void LightFieldWriter::SetMerged(int view_id, const std::string& exr, int exposures, double ghost_share) {
  const auto view = std::ranges::find(state_->light_field.views, view_id, &View::id);
  if (view == state_->light_field.views.end())
    throw Error("{}: there is no view {}", state_->light_field.root.string(), view_id);
  const MergedExposures merged{MergedPath(view_id), exposures, ghost_share};
  MakeFolder(state_->light_field.root / kMergedFolder);
  WriteFileAtomically(state_->light_field.root / merged.path, exr);
  state_->journal.NoteMerged(view_id, merged);
  view->merged = merged;
}

void LightFieldWriter::UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                                   const std::map<int, CameraModel>& cameras) {
  if (cam_from_world_by_view.empty() && cameras.empty()) return;
  state_->journal.UpdatePoses(cam_from_world_by_view, cameras);
  for (const auto& [index, camera] : cameras)
    state_->light_field.cameras[static_cast<std::size_t>(index)] = camera;
  for (View& view : state_->light_field.views)
    if (const auto found = cam_from_world_by_view.find(view.id); found != cam_from_world_by_view.end())
      view.cam_from_world = found->second;
  for (const View& view : state_->light_field.views)
    if (cam_from_world_by_view.contains(view.id) || cameras.contains(view.camera))
      state_->moved_since_points.insert(view.id);
}

void LightFieldWriter::SetSubject(const Subject& subject) {
  state_->journal.SetSubject(subject);
  state_->light_field.subject = subject;
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
  MakeFolder(root / "masks");
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
  batch.Commit();
  try {
    state_->journal.SetMasks(paths);
  } catch (...) {
    batch.TakeBack();
    throw;
  }
  for (View& view : state_->light_field.views)
    if (const auto path = paths.find(view.id); path != paths.end()) view.mask_path = path->second;
  for (const std::string& path : replaced) {
    MakeFolder(FolderOf(root / "kept" / path));
    MoveToKept(root, path, path);
  }
}

void LightFieldWriter::SetPoints(std::vector<ScenePoint> points) {
  const LightField& now = state_->light_field;
  if (points.empty() && !now.points.empty()) return;
  if (!now.points.empty() && StatisticsOf(now.points).tracked == 0)
    for (const char* file : {"points.ply", "points.ulf"}) MoveToKept(now.root, file, file);
  state_->light_field.points = std::move(points);
  state_->moved_since_points.clear();
  MeasurePoints(state_->light_field);
  WritePoints(state_->light_field);
}

void LightFieldWriter::NoteGap(double from_s, double to_s, const std::string& reason) {
  state_->journal.NoteGap(from_s, to_s, reason);
}

// Does nothing the second time: the caller repeats only the moving of files.
void LightFieldWriter::State::TakeOutOfJournal(int view_id) {
  if (to_unposed.contains(view_id)) return;
  const auto view = std::ranges::find_if(
      light_field.views, [view_id](const View& candidate) { return candidate.id == view_id; });
  if (view == light_field.views.end())
    throw Error("{}: there is no view {} to remove", light_field.root.string(), view_id);
  bool has_picture = true;
  try {
    if (PictureFollowsFromMaster(*view))
      WritePictureFromMaster(light_field.root, *view, SizeOf(light_field.CameraOf(*view)));
  } catch (const DiskFullError&) {
    throw;  // the caller tries again when there is room
  } catch (const Error& error) {
    spdlog::warn("{}; only the master of view {} is kept in unposed/", error.what(), view_id);
    has_picture = false;
  }
  const fs::path unposed = light_field.root / "unposed";
  MakeFolder(unposed);
  journal.RemoveView(view_id);  // before the file moves: the journal never names a file that is gone
  std::map<std::string, fs::path>& files = to_unposed[view_id];
  for (const std::string& file : FilesOf(*view))
    if (has_picture || file != view->image_path) files[file] = unposed / UnposedName(file);
  light_field.views.erase(view);
  light_field.taken_back.insert(view_id);
}

void LightFieldWriter::RemoveView(int view_id) {
  state_->TakeOutOfJournal(view_id);
  const LightField& light_field = state_->light_field;
  std::map<std::string, fs::path>& files = state_->to_unposed.at(view_id);
  while (!files.empty()) {
    const auto& [from, to] = *files.begin();
    MoveWithoutReplacing(light_field.root / from, to);
    files.erase(files.begin());
  }
  state_->to_unposed.erase(view_id);
}

void LightFieldWriter::KeepUnposed(const Frame& frame, const std::string& problem) {
  const fs::path folder = state_->light_field.root / "unposed";
  MakeFolder(folder);
  const ViewFiles files = Files(frame, MakePictures::kNow);
  UnposedPhotograph photograph{.view = {}, .problem = problem};
  View& view = photograph.view;
  NoteFrame(frame, view);
  // Else the raw file is there already.
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
    if (files.raw) view.raw_white_balance = state_->white_balance.InPlaceOf(*files.raw);
  }
  batch.Commit();
  try {
    state_->journal.NoteUnposed(photograph);
  } catch (...) {
    batch.TakeBack();  // the caller tries again
    throw;
  }
  state_->light_field.unposed.push_back(std::move(photograph));
}

void LightFieldWriter::AddUnposed(std::vector<View> photographs) {
  LightField& light_field = state_->light_field;
  for (View& view : photographs) {
    state_->RequireReserved(view.id, light_field.views.empty() ? 0 : light_field.views.back().id);
    std::vector<fs::path> done;  // in unposed/
    FileBatch batch(FileBatch::Existing::kKeep);
    const auto copy = [&](const char* folder, std::string& path) {
      const fs::path from = light_field.root / path;
      path = fmt::format("{}/{:06}{}", folder, view.id, from.extension().string());
      MakeFolder(light_field.root / folder);
      const std::string bytes = ReadWholeFile(from);
      batch.Write(light_field.root / path, ContentOf(bytes));
      done.push_back(from);
    };
    copy("images", view.image_path);
    if (!view.master_path.empty()) copy("masters", view.master_path);
    batch.Commit();
    try {
      state_->journal.AddViews({&view, 1});
    } catch (...) {
      batch.TakeBack();
      throw;
    }
    std::error_code refused;  // then it is both
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
  WriteDerivedFiles(state_->light_field);
}

}  // namespace ulf
