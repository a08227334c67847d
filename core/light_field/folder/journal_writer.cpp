#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

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

static nlohmann::json CameraEntry(const CameraModel& camera, const FlatField* flat_field,
                                  const ColorProfile* color_profile, const std::string& calibration_source) {
  nlohmann::json entry = CameraToJson(camera);
  if (flat_field) entry["flat_field"] = FlatFieldToJson(*flat_field);
  if (color_profile) entry["color_profile"] = ColorProfileToJson(*color_profile);
  if (!calibration_source.empty()) entry["calibration_source"] = calibration_source;
  return entry;
}

void Journal::Header(const LightField& light_field) {
  nlohmann::json event = {{"event", "header"},
                          {"version", kJournalVersion},
                          {"device_uri", light_field.device_uri},
                          {"device_serial", light_field.device_serial},
                          {"device_maker", light_field.device_maker},
                          {"device_model", light_field.device_model},
                          {"units", light_field.units},
                          {"coverage_width_px", light_field.coverage_width_px}};
  if (light_field.window) event["sensor"] = WindowToJson(*light_field.window);
  if (light_field.threshold_px) event["threshold_px"] = *light_field.threshold_px;
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i) {
    const auto flat = light_field.flat_fields.find(static_cast<int>(i));
    const auto profile = light_field.color_profiles.find(static_cast<int>(i));
    event["cameras"].push_back(
        CameraEntry(light_field.cameras[i], flat == light_field.flat_fields.end() ? nullptr : &flat->second,
                    profile == light_field.color_profiles.end() ? nullptr : &profile->second,
                    light_field.CalibrationSource(static_cast<int>(i))));
  }
  Append(JsonText(event));
}

void Journal::AddCamera(int index, const NewCamera& camera) {
  Append(JsonText(nlohmann::json{
      {"event", "camera"},
      {"index", index},
      {"camera",
       CameraEntry(camera.camera, camera.flat_field ? &*camera.flat_field : nullptr,
                   camera.color_profile ? &*camera.color_profile : nullptr, camera.calibration_source)}}));
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
  nlohmann::json event{{"event", "pose_update"}, {"poses", poses}};
  for (const auto& [index, lens] : cameras)
    event["cameras"][std::to_string(index)] =
        CameraEntry(lens.camera, nullptr, nullptr, lens.calibration_source);
  Append(JsonText(event));
}

void Journal::AddExposure(int view_id, const ViewExposure& exposure) {
  nlohmann::json event = ExposureToJson(exposure);
  event["event"] = "exposure";
  event["view"] = view_id;
  Append(JsonText(event));
}

void Journal::NoteMerged(int view_id, const MergedExposures& merged) {
  nlohmann::json event = MergedToJson(merged);
  event["event"] = "merged";
  event["view"] = view_id;
  Append(JsonText(event));
}

void Journal::SetSubject(const Subject& subject) {
  Append(JsonText(nlohmann::json{
      {"event", "subject"}, {"center", Vector3ToJson(subject.center_in_world)}, {"radius", subject.radius}}));
}

void Journal::SetUp(const Eigen::Vector3d& up_in_world) {
  Append(JsonText(nlohmann::json{{"event", "up"}, {"up", Vector3ToJson(up_in_world)}}));
}

void Journal::SetGoal(const CoverageGoal& goal) {
  nlohmann::json event = CoverageGoalToJson(goal);
  event["event"] = "goal";
  Append(JsonText(event));
}

void Journal::SetReadout(const ShutterReadout& readout) {
  nlohmann::json event = ReadoutToJson(readout);
  event["event"] = "readout";
  Append(JsonText(event));
}

void Journal::SetTurntable(const Turntable& turntable) {
  Append(JsonText(nlohmann::json{{"event", "turntable"}, {"board", turntable.board}}));
}

void Journal::SetMasks(const std::map<int, std::string>& mask_path_by_view) {
  nlohmann::json masks = nlohmann::json::object();
  for (const auto& [id, path] : mask_path_by_view) masks[std::to_string(id)] = path;
  Append(JsonText(nlohmann::json{{"event", "masks"}, {"masks", masks}}));
}

void Journal::NoteGap(double from_s, double to_s, const std::string& reason) {
  Append(JsonText(nlohmann::json{{"event", "gap"}, {"from_s", from_s}, {"to_s", to_s}, {"reason", reason}}));
}

void Journal::RemoveViews(const std::set<int>& view_ids) {
  if (view_ids.empty()) return;
  nlohmann::json event{{"event", "remove"}};
  if (view_ids.size() == 1)
    event["id"] = *view_ids.begin();
  else
    event["ids"] = view_ids;
  Append(JsonText(event));
}

void Journal::NoteUnposed(const UnposedPhotograph& photograph) {
  nlohmann::json event = PhotographToJson(photograph.view);
  event["event"] = "unposed";
  event["image"] = photograph.view.image_path;
  event["camera"] = photograph.view.camera;
  if (!photograph.problem.empty()) event["problem"] = photograph.problem;
  Append(JsonText(event));
}

void Journal::NoteChecked(const std::string& check, const std::vector<KeptFinding>& found) {
  Append(JsonText(KeptFindingsToJson(check, found)));
}

void Journal::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons,
                    const std::optional<MeasuredErrors>& measured) {
  nlohmann::json event{{"event", "close"}, {"capture_s", capture_s}, {"reasons", reasons}};
  if (measured) event["measured"] = MeasuredToJson(*measured);
  Append(JsonText(event));
}

}  // namespace ulf
