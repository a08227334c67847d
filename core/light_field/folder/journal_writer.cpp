#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/camera_json.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/formats/view_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"

namespace ulf {

Journal::Journal(const std::filesystem::path& file) : file_(file) {
  // Another writer may replace the file by a copy before we hold the lock.
  constexpr int kMostTries = 100;  // a limit for file systems that report two numbers of one file
  for (int tries = 0; tries == 0 || (tries < kMostTries && !IsSameFile(descriptor_.Number(), file_)); ++tries)
    Open();
}

void Journal::Open() {
  descriptor_ = {};
  descriptor_ =
      FileDescriptor(open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644));
  if (!descriptor_.IsOpen())
    throw Error("{}: cannot be opened for writing: {}; check permissions", file_.string(),
                std::strerror(errno));
  if (flock(descriptor_.Number(), LOCK_EX | LOCK_NB) != 0)
    throw Error("{}: another process is recording into this light field; stop it or choose another folder",
                file_.parent_path().string());
}

void Journal::BreakHardLinks() {
  struct stat status {
  }, of_name{};
  const bool is_link = lstat(file_.c_str(), &of_name) == 0 && S_ISLNK(of_name.st_mode);
  if (!is_link && (fstat(descriptor_.Number(), &status) != 0 || status.st_nlink <= 1)) return;
  const std::filesystem::path copy = TemporaryName(file_);
  const std::string bytes = ReadWholeFile(file_);
  FileDescriptor own(open(copy.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644));
  // The copy is locked before it gets the name, so that no other writer can intervene.
  if (!own.IsOpen() || flock(own.Number(), LOCK_EX | LOCK_NB) != 0 || !WriteAll(own.Number(), bytes) ||
      fsync(own.Number()) != 0 || rename(copy.c_str(), file_.c_str()) != 0) {
    const int reason = errno;
    unlink(copy.c_str());
    ThrowDiskError(reason, fmt::format("{}: shares its bytes with another light field and cannot be copied",
                                       file_.string()));
  }
  descriptor_ = std::move(own);
  SyncFolder(FolderOf(file_));
}

void Journal::CutAt(std::size_t whole_bytes) {
  struct stat status {};
  if (fstat(descriptor_.Number(), &status) == 0 && static_cast<std::size_t>(status.st_size) == whole_bytes)
    return;
  BreakHardLinks();
  if (ftruncate(descriptor_.Number(), static_cast<off_t>(whole_bytes)) != 0)
    throw Error("{}: cannot be repaired: {}", file_.string(), std::strerror(errno));
}

void Journal::Append(const std::string& lines) {
  BreakHardLinks();
  const std::string text = lines + "\n";
  const int number = descriptor_.Number();
  const off_t before = lseek(number, 0, SEEK_END);
  // Removes a partial line: the next one would be appended to it.
  const auto undo = [&](const char* what) {
    const int reason = errno;
    if (ftruncate(number, before) == 0) fsync(number);
    ThrowDiskError(reason, fmt::format("{}: {} (everything before this is safe)", file_.string(), what));
  };
  if (!WriteAll(number, text)) undo("writing failed");
  if (fsync(number) != 0) undo("syncing to disk failed");
}

void Journal::NoteRepair(std::uint64_t bytes) {
  const std::string line = JsonText(nlohmann::json{{"event", "repaired"}});
  const auto now = static_cast<std::uint64_t>(lseek(descriptor_.Number(), 0, SEEK_END)) + line.size() + 1;
  Append(line + std::string(now < bytes ? bytes - now : 0, ' '));
}

static nlohmann::json CameraEntry(const NewCamera& camera) {
  nlohmann::json entry = CameraToJson(camera.camera);
  if (camera.flat_field) entry["flat_field"] = FlatFieldToJson(*camera.flat_field);
  if (camera.color_profile) entry["color_profile"] = ColorProfileToJson(*camera.color_profile);
  if (!camera.calibration_source.empty()) entry["calibration_source"] = camera.calibration_source;
  return entry;
}

static void AppendEvent(const char* kind, nlohmann::json keys, Journal& journal) {
  keys["event"] = kind;
  journal.Append(JsonText(keys));
}

void Journal::Header(const LightField& light_field) {
  nlohmann::json event = CaptureToJson(light_field);
  event["version"] = kJournalVersion;
  for (const char* key : {"device_uri", "device_serial", "device_maker", "device_model"})
    event.emplace(key, "");
  for (int i = 0; i < static_cast<int>(light_field.cameras.size()); ++i) {
    NewCamera camera{light_field.cameras[At(i)], {}, {}, light_field.CalibrationSource(i)};
    if (light_field.flat_fields.contains(i)) camera.flat_field = light_field.flat_fields.at(i);
    if (light_field.color_profiles.contains(i)) camera.color_profile = light_field.color_profiles.at(i);
    event["cameras"].push_back(CameraEntry(camera));
  }
  AppendEvent("header", std::move(event), *this);
}

void Journal::AddCamera(int index, const NewCamera& camera) {
  AppendEvent("camera", {{"index", index}, {"camera", CameraEntry(camera)}}, *this);
}

void Journal::AddViews(std::span<const View> views) {
  std::string lines;
  for (const View& view : views) {
    nlohmann::json event = ViewToJson(view);
    event["event"] = "view";
    event["image"] = view.image_path;
    event["camera"] = view.camera;
    event["cam_from_world"] = PoseToJson(view.cam_from_world);
    if (!lines.empty()) lines += '\n';
    lines += JsonText(event);
  }
  if (!lines.empty()) Append(lines);
}

void Journal::UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                          const std::map<int, CorrectedLens>& cameras) {
  nlohmann::json poses = nlohmann::json::object();
  for (const auto& [id, pose] : cam_from_world_by_view) poses[std::to_string(id)] = PoseToJson(pose);
  nlohmann::json event{{"poses", poses}};
  for (const auto& [index, lens] : cameras)
    event["cameras"][std::to_string(index)] = CameraEntry({lens.camera, {}, {}, lens.calibration_source});
  AppendEvent("pose_update", std::move(event), *this);
}

void Journal::AddExposure(int view_id, const ViewExposure& exposure) {
  nlohmann::json event = ExposureToJson(exposure);
  event["view"] = view_id;
  AppendEvent("exposure", std::move(event), *this);
}

void Journal::NoteMerged(int view_id, const MergedExposures& merged) {
  nlohmann::json event = MergedToJson(merged);
  event["view"] = view_id;
  AppendEvent("merged", std::move(event), *this);
}

void Journal::SetSubject(const Subject& subject) {
  AppendEvent("subject", {{"center", Vector3ToJson(subject.center_in_world)}, {"radius", subject.radius}},
              *this);
}
void Journal::SetUp(const Eigen::Vector3d& up_in_world) {
  AppendEvent("up", {{"up", Vector3ToJson(up_in_world)}}, *this);
}
void Journal::SetGoal(const CoverageGoal& goal) { AppendEvent("goal", CoverageGoalToJson(goal), *this); }
void Journal::SetReadout(const ShutterReadout& readout) {
  AppendEvent("readout", ReadoutToJson(readout), *this);
}
void Journal::SetTurntable(const Turntable& turntable) {
  AppendEvent("turntable", {{"board", turntable.board}}, *this);
}

void Journal::SetMasks(const std::map<int, std::string>& mask_path_by_view) {
  nlohmann::json masks = nlohmann::json::object();
  for (const auto& [id, path] : mask_path_by_view) masks[std::to_string(id)] = path;
  AppendEvent("masks", {{"masks", masks}}, *this);
}

void Journal::NoteGap(double from_s, double to_s, const std::string& reason) {
  AppendEvent("gap", {{"from_s", from_s}, {"to_s", to_s}, {"reason", reason}}, *this);
}

void Journal::RemoveViews(const std::set<int>& view_ids) {
  if (view_ids.size() == 1)
    AppendEvent("remove", {{"id", *view_ids.begin()}}, *this);
  else if (!view_ids.empty())
    AppendEvent("remove", {{"ids", view_ids}}, *this);
}

void Journal::NoteUnposed(const UnposedPhotograph& photograph) {
  nlohmann::json event = PhotographToJson(photograph.view);
  event["image"] = photograph.view.image_path;
  event["camera"] = photograph.view.camera;
  if (!photograph.problem.empty()) event["problem"] = photograph.problem;
  AppendEvent("unposed", std::move(event), *this);
}

void Journal::NoteChecked(const std::string& check, const std::vector<KeptFinding>& found) {
  AppendEvent("checked", KeptFindingsToJson(check, found), *this);
}

void Journal::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
                    const std::optional<MeasuredErrors>& measured) {
  nlohmann::json event{{"capture_s", capture_s}, {"reasons", reasons}};
  if (measured) event["measured"] = MeasuredToJson(*measured);
  AppendEvent("close", std::move(event), *this);
}

}  // namespace ulf
