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
#include "core/light_field/exchange/colmap_text.h"
#include "core/light_field/exchange/transforms_json.h"
#include "core/light_field/folder_check.h"
#include "core/light_field/journal.h"
#include "core/light_field/missing_journal.h"
#include "core/light_field/points/point_io.h"
#include "core/light_field/points/point_tracks.h"
#include "core/light_field/view_files.h"
#include "core/light_field/view_numbers.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "journal.jsonl";
constexpr const char* kTransforms = "transforms.json";

bool IsBeingWritten(const fs::path& journal) {
  const int descriptor = open(journal.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return locked;
}

// A photograph that the master holds, too, is not missing.
void RequireImages(const LightField& light_field, const FolderCheck& check) {
  if (check.missing_images.empty()) return;
  const int id = check.missing_images.front();
  const auto view = std::find_if(light_field.views.begin(), light_field.views.end(),
                                 [id](const View& each) { return each.id == id; });
  throw Error(
      "{0}: the image '{1}' of view {2} is missing{3}; restore it, or take out what is gone: ulf repair {4}",
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
  for (const char* folder : {".", "images", "masters", "unposed", "sparse/0"}) {
    if (!fs::is_directory(dir / folder)) continue;
    for (const auto& entry : fs::directory_iterator(dir / folder))
      if (IsOurTemporary(entry)) fs::remove(entry.path());
  }
}

// What a writer that was killed had taken out of the journal and not yet moved.
void MoveRemoved(const fs::path& dir, const JournalContents& journal) {
  std::set<std::string> named;
  for (const View& view : journal.light_field.views) named.insert({view.image_path, view.master_path});
  for (const std::string& file : journal.removed_files) {
    if (file.empty() || named.contains(file) || !fs::is_regular_file(dir / file)) continue;
    MakeFolder(dir / "unposed");
    const fs::path path = file;
    const std::string master = file.starts_with("masters/") ? ".master" : "";
    MoveWithoutReplacing(dir / file,
                         dir / "unposed" / (path.stem().string() + master + path.extension().string()));
  }
}

// Lines that are damaged to the journal's end are cut off, and kept: more than a line that was being written.
void CutEnd(const fs::path& dir, const JournalContents& contents, Journal& journal) {
  const std::string bytes = ReadWholeFile(dir / kJournal);
  const std::string end = bytes.substr(std::min(contents.whole_bytes, bytes.size()));
  if (end.find('\n') != std::string::npos) {
    MakeFolder(dir / "kept");
    const fs::path copy = dir / "kept" / fmt::format("journal-end.{}.part", getpid());
    WriteFileAtomically(copy, end);
    const fs::path kept = MoveWithoutReplacing(copy, dir / "kept" / "journal-end.jsonl");
    spdlog::warn("{}: its last lines are damaged and cut off; they are kept as {}", (dir / kJournal).string(),
                 kept.string());
  }
  journal.CutAt(contents.whole_bytes);
}

// Said once in a run: some commands read a light field several times.
void WarnOnce(const std::vector<std::string>& words) {
  static Mutex mutex;
  static std::set<std::string> said ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  for (const std::string& each : words)
    if (said.insert(each).second) spdlog::warn("{}", each);
}

// Refuses a folder whose other files know more than its journal, before anything is written there.
void RequireWholeJournal(const fs::path& dir, const FolderCheck& check) {
  if (!check.HoldsWhatIsLost()) return;
  std::string words;
  for (const std::string& each : check.words) words += each + "; ";
  throw Error("{}nothing was written; put it back with 'ulf repair {} --write', then go on", words,
              ShellWord(dir.string()));
}

void RequireOwnPictures(const LightField& light_field) {
  const PictureCheck check = CheckPictures(light_field);
  if (!check.damaged.empty())
    spdlog::warn("{}: the photographs of {} cannot be read; 'ulf repair {}' shows what can be done",
                 light_field.root.string(), ViewNumbers({check.damaged.begin(), check.damaged.end()}),
                 ShellWord(light_field.root.string()));
  const std::vector<int>& others = check.others;
  if (others.empty()) return;
  throw Error(
      "{0}: the photographs in images/ of {1} are not those of their masters, are damaged, or have not their "
      "camera's size; "
      "nothing "
      "was written; 'ulf repair {2}' shows what can be done",
      light_field.root.string(), ViewNumbers({others.begin(), others.end()}),
      ShellWord(light_field.root.string()));
}

}  // namespace

// As far as there is room and masters are whole.
std::size_t MakeMissingPictures(const LightField& light_field) {
  std::size_t made = 0, missing = 0;
  bool full = false;
  for (const View& view : light_field.views) {
    if (!PictureFollowsFromMaster(view) || fs::exists(light_field.root / view.image_path)) continue;
    if (full) {
      ++missing;
      continue;
    }
    if (made++ == 0)
      spdlog::info("{}: making the photographs of images/ that are still missing from their masters",
                   light_field.root.string());
    try {
      WritePictureFromMaster(light_field.root, view);
    } catch (const DiskFullError& error) {
      spdlog::warn("{}; photographs missing in images/ are read from masters/", error.what());
      full = true;
      ++missing;
    } catch (const std::exception& error) {
      spdlog::warn("{}; {} is still missing", error.what(), view.image_path);
      ++missing;
    }
  }
  return missing;
}

namespace {

// What is not ours goes to kept/ first.
void KeepWhatIsNotOurs(const fs::path& dir, const FolderCheck& check, bool points_are_in_doubt) {
  const auto keep = [&](const char* name, const char* as) {
    if (!fs::exists(dir / name)) return;
    MakeFolder(dir / "kept");
    const fs::path to = MoveWithoutReplacing(dir / name, dir / "kept" / as);
    spdlog::warn("{}: another program, or a hand, had changed it; it is kept as {}", (dir / name).string(),
                 to.string());
  };
  if (!check.transforms.IsOurs()) keep("transforms.json", "transforms.json");
  if (!check.model.IsOurs()) keep("sparse/0", "sparse");
  if (points_are_in_doubt)
    for (const char* points : {"points.ply", "points.ulf"}) keep(points, points);
}

// They can be made again from the journal at any time: no room for them is no reason not to work.
void DeriveOrWarn(const LightField& light_field) {
  try {
    WriteDerivedFiles(light_field);
  } catch (const Error& error) {
    spdlog::warn("{}; 'ulf repair {}' makes transforms.json and sparse/ later", error.what(),
                 ShellWord(light_field.root.string()));
  }
}

LightField ReadSetOfOthers(const fs::path& transforms) {
  LightField light_field = ReadTransformsJson(transforms);
  WarnOnce(light_field.doubts);
  return light_field;
}

// A capture that ended before its first view left no more than what can be made again.
bool IsUnused(const fs::path& dir) {
  std::error_code unknown;
  if (!fs::is_regular_file(dir / kJournal, unknown)) return false;
  for (const char* folder : {"images", "masters", "unposed"})
    if (fs::is_directory(dir / folder, unknown) && !fs::is_empty(dir / folder, unknown)) return false;
  try {
    // Not even a header: the disk was full, or the capture was killed, before it began.
    if (ReadWholeFile(dir / kJournal).find('\n') == std::string::npos)
      return !fs::exists(dir / kTransforms) && !fs::exists(dir / "sparse");
    return ReadJournal(dir / kJournal).next_view_id == 1;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

LightField ReadLightField(const fs::path& path) {
  std::error_code unknown;
  if (fs::is_regular_file(path, unknown) && path.filename() == kJournal)
    throw Error("{}: give the folder that holds it: {}", path.string(),
                path.parent_path().empty() ? "." : path.parent_path().string());
  if (fs::is_regular_file(path, unknown)) return ReadSetOfOthers(path);
  if (!fs::is_directory(path, unknown))
    throw Error("{}: there is no such folder; give the folder of a light field", path.string());
  if (!fs::is_regular_file(path / kJournal)) {
    if (fs::is_regular_file(path / kTransforms)) return ReadSetOfOthers(path / kTransforms);
    if (HasLostItsJournal(path)) throw NoJournal(path);
    throw Error(
        "{}: holds no light field: neither {} nor {}; capture or import one{}", path.string(), kJournal,
        kTransforms,
        fs::is_directory(path / "images", unknown)
            ? fmt::format(" (the photographs in images/ are posed anew by 'ulf capture replay:{} -o NEW "
                          "--focal-px F --no-subject')",
                          ShellWord((path / "images").string()))
            : "");
  }
  JournalContents journal = ReadJournal(path / kJournal);
  const bool being_written = IsBeingWritten(path / kJournal);
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

void WriteDerivedFiles(const LightField& light_field) {
  const fs::path sparse = light_field.root / "sparse" / "0";
  MakeFolder(sparse);
  const auto made_from = StampOf(light_field.root / kJournal);
  const ColmapFiles colmap = ToColmapText(ToColmap(light_field), made_from);
  WriteFileAtomically(sparse / "cameras.txt", colmap.cameras);
  WriteFileAtomically(sparse / "images.txt", colmap.images);
  WriteFileAtomically(sparse / "points3D.txt", colmap.points3d);
  if (!light_field.points.empty()) WritePoints(light_field);
  WriteFileAtomically(light_field.root / kTransforms, TransformsJsonText(light_field, made_from));
}

void WriteLightField(const LightField& light_field) {
  if (light_field.cameras.empty()) throw Error("{}: a light field needs a camera", light_field.root.string());
  Journal journal(light_field.root / kJournal);
  journal.CutAt(0);
  journal.Header(light_field);
  if (light_field.up_in_world) journal.SetUp(*light_field.up_in_world);
  if (light_field.goal) journal.SetGoal(*light_field.goal);
  if (light_field.subject) journal.SetSubject(*light_field.subject);
  journal.AddViews(light_field.views);
  journal.Close(light_field.capture_s, light_field.reasons);
  WriteDerivedFiles(light_field);
}

struct LightFieldWriter::State {
  explicit State(const fs::path& dir) : journal(dir / kJournal) { light_field.root = dir; }
  void TakeOutOfJournal(int view_id);
  void RequireReserved(int view_id, int last_id) const;

  Journal journal;
  LightField light_field;
  std::atomic<int> next_view_id = 1;
  int next_unposed = 1;
  // Of views that the journal no longer names, by id: files that are still to be moved, and whereto.
  std::map<int, std::map<std::string, fs::path>> to_unposed;
  bool keep_mosaics = false;
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
  if (!unused && fs::is_regular_file(dir / kJournal, unknown)) throw taken;
  if (!unused && fs::is_directory(dir, unknown) && !fs::is_empty(dir, unknown))
    throw Error("{}: the folder is not empty; choose another one", dir.string());
  header.camera.Validate("the camera of " + dir.string());
  const bool made_folder = !fs::exists(dir, unknown);
  MakeFolder(dir / "images");
  auto state = std::make_unique<State>(dir);
  if (unused) {
    if (!IsUnused(dir)) throw taken;  // by who held the journal until now
    state->journal.CutAt(0);
  }
  LightField& light_field = state->light_field;
  light_field.cameras = {header.camera};
  if (header.flat_field) light_field.flat_fields[0] = *header.flat_field;
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
    // Nothing was recorded: no folder stays that says otherwise.
    fs::remove(dir / kJournal, unknown);
    fs::remove(dir / "images", unknown);
    if (made_folder) fs::remove(dir, unknown);
    throw;
  }
  return LightFieldWriter(std::move(state));
}

LightFieldWriter LightFieldWriter::Resume(const fs::path& dir) {
  if (!fs::is_regular_file(dir / kJournal)) throw NoJournal(dir);
  auto state = std::make_unique<State>(dir);
  JournalContents contents = ReadJournal(dir / kJournal);
  const FolderCheck check = CheckFolder(dir, contents, false);
  RequireWholeJournal(dir, check);
  RequireImages(contents.light_field, check);
  RequireOwnPictures(contents.light_field);
  WarnOnce(check.words);
  CutEnd(dir, contents, state->journal);
  RemoveLeftovers(dir);
  ReadPoints(contents.light_field);
  const std::vector<std::string> of_points = contents.light_field.doubts;
  WarnOnce(of_points);
  MoveRemoved(dir, contents);
  state->light_field = std::move(contents.light_field);
  state->light_field.doubts = check.words;
  state->light_field.doubts.insert(state->light_field.doubts.end(), of_points.begin(), of_points.end());
  // A number that any file bears is never given again, whatever the journal says.
  state->next_view_id = std::max(contents.next_view_id, check.highest_number + 1);
  MakeFolder(dir / "images");
  MakeMissingPictures(state->light_field);
  KeepWhatIsNotOurs(dir, check, !of_points.empty());
  DeriveOrWarn(state->light_field);
  return LightFieldWriter(std::move(state));
}

void LightFieldWriter::KeepMosaics(bool keep) { state_->keep_mosaics = keep; }

ViewFiles LightFieldWriter::Files(const Frame& frame, MakePictures pictures) const {
  return MakeViewFiles(frame, state_->keep_mosaics, pictures);
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
    view.f_number = add.frame.f_number;
    view.device_time_s = add.frame.device_time_s;
    view.host_time_s = add.frame.host_time_s;
    view.exposure_s = add.frame.exposure_s;
    view.gain = add.frame.gain;
    view.black_level = add.frame.black_level;
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
    batch.TakeBack();  // a photograph without its journal line is half a view
    throw;
  }
  state_->light_field.views.insert(state_->light_field.views.end(), views.begin(), views.end());
  return views;
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

void LightFieldWriter::SetPoints(std::vector<ScenePoint> points) {
  const LightField& now = state_->light_field;
  if (points.empty() && !now.points.empty()) return;
  if (!now.points.empty() && StatisticsOf(now.points).tracked == 0) {
    MakeFolder(now.root / "kept");
    for (const char* file : {"points.ply", "points.ulf"})
      if (fs::exists(now.root / file)) MoveWithoutReplacing(now.root / file, now.root / "kept" / file);
  }
  state_->light_field.points = std::move(points);
  state_->moved_since_points.clear();
  MeasurePoints(state_->light_field);
  WritePoints(state_->light_field);
}

void LightFieldWriter::NoteGap(double from_s, double to_s, const std::string& reason) {
  state_->journal.NoteGap(from_s, to_s, reason);
}

// Once: moving its files, which comes after, may have to be tried again.
void LightFieldWriter::State::TakeOutOfJournal(int view_id) {
  if (to_unposed.contains(view_id)) return;
  const auto view = std::find_if(light_field.views.begin(), light_field.views.end(),
                                 [view_id](const View& candidate) { return candidate.id == view_id; });
  if (view == light_field.views.end())
    throw Error("{}: there is no view {} to remove", light_field.root.string(), view_id);
  bool has_picture = true;
  try {
    if (PictureFollowsFromMaster(*view)) WritePictureFromMaster(light_field.root, *view);
  } catch (const DiskFullError&) {
    throw;  // to be tried again when there is room
  } catch (const Error& error) {
    spdlog::warn("{}; only the master of view {} is kept in unposed/", error.what(), view_id);
    has_picture = false;
  }
  const fs::path unposed = light_field.root / "unposed";
  MakeFolder(unposed);
  journal.RemoveView(view_id);  // before the file moves: the journal never names a file that is gone
  std::map<std::string, fs::path>& files = to_unposed[view_id];
  if (has_picture) files[view->image_path] = unposed / fs::path(view->image_path).filename();
  // Beside the photograph, under a name of its own where both are PNG files.
  if (const fs::path master = view->master_path; !master.empty())
    files[view->master_path] = unposed / (master.stem().string() + ".master" + master.extension().string());
  light_field.views.erase(view);
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

void LightFieldWriter::KeepUnposed(const Frame& frame) {
  const fs::path folder = state_->light_field.root / "unposed";
  MakeFolder(folder);
  const ViewFiles files = Files(frame, MakePictures::kNow);
  fs::path path;
  do path = folder / fmt::format("unposed_{:06}{}", state_->next_unposed++, files.image_extension);
  while (fs::exists(path));
  FileBatch batch;
  batch.Write(path, files.image->content);
  if (files.master && (!frame.image.empty() || frame.encoded))  // else the raw file is there already
    batch.Write(folder / (path.stem().string() + ".master" + files.master->extension), files.master->content);
  batch.Commit();
}

void LightFieldWriter::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons) {
  state_->journal.Close(capture_s, reasons);
  state_->light_field.capture_s = capture_s;
  state_->light_field.reasons = reasons;
  FitPointsOf(state_->moved_since_points, state_->light_field);
  MeasurePoints(state_->light_field);
  WriteDerivedFiles(state_->light_field);
}

}  // namespace ulf
