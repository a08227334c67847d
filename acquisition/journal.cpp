#include "acquisition/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "acquisition/atomic_file.h"
#include "acquisition/camera_json.h"
#include "acquisition/error.h"
#include "acquisition/json_fields.h"
#include "acquisition/transforms_json.h"
#include "acquisition/view_json.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kVersion = 1;

json PoseToJson(const Rigid3& cam_from_world) {
  const Eigen::Quaterniond& q = cam_from_world.rotation;
  const Eigen::Vector3d& t = cam_from_world.translation;
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

Rigid3 PoseFromJson(const JsonPlace& place, const char* key) {
  const std::vector<double> n = place.Numbers(key, 7);
  const Eigen::Quaterniond rotation(n[0], n[1], n[2], n[3]);
  if (std::abs(rotation.norm() - 1) > 1e-6)
    throw Error("{}: the quaternion of '{}' has not unit length", place.where, key);
  return {rotation, {n[4], n[5], n[6]}};
}

json Vector3ToJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Vector3d Vector3FromJson(const JsonPlace& place, const char* key) {
  const std::vector<double> n = place.Numbers(key, 3);
  return {n[0], n[1], n[2]};
}

void ApplyHeader(const JsonPlace& event, LightField& light_field) {
  const int version = event.Integer("version");
  if (version > kVersion)
    throw Error("{}: journal version {} is newer than this program's {}; use a newer ulf", event.where,
                version, kVersion);
  for (const json& camera : event.Raw("cameras")) {
    if (camera.contains("flat_field"))
      light_field.flat_fields[static_cast<int>(light_field.cameras.size())] =
          FlatFieldFromJson(camera["flat_field"], event.where);
    light_field.cameras.push_back(CameraFromJson({camera, event.where}));
  }
  light_field.device_uri = event.Text("device_uri", "");
  light_field.device_serial = event.Text("device_serial", "");
  light_field.device_maker = event.Text("device_maker", "");
  light_field.device_model = event.Text("device_model", "");
  if (event.Has("sensor"))
    light_field.window = WindowFromJson({event.Raw("sensor"), event.where + ", sensor"});
  light_field.calibration_source = event.Text("calibration_source", "");
  light_field.units = event.Text("units", "arbitrary");
  if (event.Has("threshold_px")) light_field.threshold_px = event.Number("threshold_px");
  light_field.coverage_width_px = event.Integer("coverage_width_px", 640);
}

void ApplyView(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  View view;
  view.id = event.Integer("id");
  if (view.id < contents.next_view_id)
    throw Error("{}: view {} comes after view {}; the journal was edited or mixed", event.where, view.id,
                contents.next_view_id - 1);
  ReadViewJson(event, view);
  view.image_path = PathInside(light_field.root, event.Text("image"), event.where);
  if (!view.master_path.empty())
    view.master_path = PathInside(light_field.root, view.master_path, event.where);
  view.camera = event.Integer("camera", 0);
  if (view.camera < 0 || view.camera >= static_cast<int>(light_field.cameras.size()))
    throw Error("{}: camera {} is not among the header's", event.where, view.camera);
  view.cam_from_world = PoseFromJson(event, "cam_from_world");
  view.recorded_cam_from_world = view.cam_from_world;
  contents.next_view_id = view.id + 1;
  light_field.views.push_back(std::move(view));
}

View* FindView(LightField& light_field, int id) {
  const auto found = std::lower_bound(light_field.views.begin(), light_field.views.end(), id,
                                      [](const View& view, int wanted) { return view.id < wanted; });
  return found != light_field.views.end() && found->id == id ? &*found : nullptr;
}

void ApplyEvent(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  const std::string kind = event.Text("event");
  contents.closed = kind == "close";
  if (kind == "header") {
    ApplyHeader(event, light_field);
  } else if (kind == "view") {
    ApplyView(event, contents);
  } else if (kind == "pose_update") {
    const JsonPlace poses{event.Raw("poses"), event.where + ", poses"};
    for (const auto& [id, pose] : poses.object.items())
      if (View* view = FindView(light_field, std::atoi(id.c_str())))
        view->cam_from_world = PoseFromJson(poses, id.c_str());
    if (event.Has("cameras"))
      for (const auto& [index, camera] : event.Raw("cameras").items()) {
        const auto at = static_cast<std::size_t>(std::atoi(index.c_str()));
        if (at >= light_field.cameras.size())
          throw Error("{}: camera {} is not among the header's", event.where, index);
        light_field.cameras[at] = CameraFromJson({camera, event.where});
      }
  } else if (kind == "subject") {
    light_field.subject = Subject{Vector3FromJson(event, "center"), event.Positive("radius")};
  } else if (kind == "up") {
    light_field.up_in_world = Vector3FromJson(event, "up").normalized();
  } else if (kind == "goal") {
    light_field.goal = CoverageGoalFromJson(event);
  } else if (kind == "remove") {
    const int id = event.Integer("id");
    light_field.taken_back +=
        std::erase_if(light_field.views, [id](const View& view) { return view.id == id; });
  } else if (kind == "close") {
    light_field.capture_s = event.Number("capture_s", 0);
    if (event.Has("reasons"))
      light_field.reasons = ReasonsFromJson({event.Raw("reasons"), event.where + ", reasons"});
  } else if (kind != "gap") {
    throw Error("{}: unknown event '{}'; use a newer ulf", event.where, kind);
  }
}

bool NothingWholeFollows(const std::string& bytes, std::size_t begin) {
  for (std::size_t end; (end = bytes.find('\n', begin)) != std::string::npos; begin = end + 1)
    if (json::accept(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                     bytes.begin() + static_cast<std::ptrdiff_t>(end)))
      return false;
  return true;
}

}  // namespace

JournalContents ReadJournal(const fs::path& file) {
  JournalContents contents;
  contents.light_field.root = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  const std::string bytes = ReadWholeFile(file);
  int line_number = 0;
  for (std::size_t end; (end = bytes.find('\n', contents.whole_bytes)) != std::string::npos;) {
    const std::string line = bytes.substr(contents.whole_bytes, end - contents.whole_bytes);
    const std::string where = fmt::format("{}, line {}", file.string(), ++line_number);
    json object;
    try {
      object = json::parse(line);
    } catch (const json::exception&) {
      // Blocks of a file can reach the disk out of order: what was written last may be damaged though its
      // end is there.
      if (NothingWholeFollows(bytes, end + 1)) break;
      throw Error(
          "{}: damaged; restore the file from a copy, or cut it before this line to keep what came before",
          where);
    }
    const JsonPlace event{object, where};
    if (line_number == 1 && event.Text("event") != "header")
      throw Error("{}: a journal begins with its header; this file is none", where);
    ApplyEvent(event, contents);
    contents.whole_bytes = end + 1;
  }
  if (contents.whole_bytes == 0)
    throw Error("{}: the journal has no header; the capture was killed before it began, remove the folder",
                file.string());
  return contents;
}

Journal::Journal(const fs::path& file) : file_(file) {
  descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0)
    throw Error("{}: cannot be opened for writing: {}; check permissions", file.string(),
                std::strerror(errno));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    close(descriptor_);
    descriptor_ = -1;
    throw Error("{}: another process is recording into this light field; stop it or choose another folder",
                file.parent_path().string());
  }
}

void Journal::CutAt(std::size_t whole_bytes) {
  if (ftruncate(descriptor_, static_cast<off_t>(whole_bytes)) != 0)
    throw Error("{}: cannot be repaired: {}", file_.string(), std::strerror(errno));
}

Journal::~Journal() {
  if (descriptor_ >= 0) close(descriptor_);
}

void Journal::Append(const std::string& lines) {
  const std::string text = lines + "\n";
  const off_t before = lseek(descriptor_, 0, SEEK_END);
  // A part of a line must not stay: the next one would be written behind it.
  const auto take_back = [&](const char* what) {
    const int reason = errno;
    if (ftruncate(descriptor_, before) == 0) fsync(descriptor_);
    ThrowDiskError(reason, fmt::format("{}: {} (everything before this is safe)", file_.string(), what));
  };
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t written = write(descriptor_, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) take_back("writing failed");
    done += static_cast<std::size_t>(written);
  }
  if (fsync(descriptor_) != 0) take_back("syncing to disk failed");
}

void Journal::Header(const LightField& light_field) {
  json event = {{"event", "header"},
                {"version", kVersion},
                {"device_uri", light_field.device_uri},
                {"device_serial", light_field.device_serial},
                {"device_maker", light_field.device_maker},
                {"device_model", light_field.device_model},
                {"calibration_source", light_field.calibration_source},
                {"units", light_field.units},
                {"coverage_width_px", light_field.coverage_width_px}};
  if (light_field.window) event["sensor"] = WindowToJson(*light_field.window);
  if (light_field.threshold_px) event["threshold_px"] = *light_field.threshold_px;
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i) {
    json camera = CameraToJson(light_field.cameras[i]);
    if (const auto flat = light_field.flat_fields.find(static_cast<int>(i));
        flat != light_field.flat_fields.end())
      camera["flat_field"] = FlatFieldToJson(flat->second);
    event["cameras"].push_back(camera);
  }
  Append(event.dump());
}

void Journal::AddViews(std::span<const View> views) {
  std::string lines;
  for (const View& view : views) {
    json event = ViewToJson(view);
    event["event"] = "view";
    event["image"] = view.image_path;
    event["camera"] = view.camera;
    event["cam_from_world"] = PoseToJson(view.cam_from_world);
    if (!lines.empty()) lines += '\n';
    lines += event.dump();
  }
  if (!lines.empty()) Append(lines);
}

void Journal::UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                          const std::map<int, CameraModel>& cameras) {
  json poses = json::object();
  for (const auto& [id, pose] : cam_from_world_by_view) poses[std::to_string(id)] = PoseToJson(pose);
  json event{{"event", "pose_update"}, {"poses", poses}};
  for (const auto& [index, camera] : cameras) event["cameras"][std::to_string(index)] = CameraToJson(camera);
  Append(event.dump());
}

void Journal::SetSubject(const Subject& subject) {
  Append(json{
      {"event", "subject"}, {"center", Vector3ToJson(subject.center_in_world)}, {"radius", subject.radius}}
             .dump());
}

void Journal::SetUp(const Eigen::Vector3d& up_in_world) {
  Append(json{{"event", "up"}, {"up", Vector3ToJson(up_in_world)}}.dump());
}

void Journal::SetGoal(const CoverageGoal& goal) {
  json event = CoverageGoalToJson(goal);
  event["event"] = "goal";
  Append(event.dump());
}

void Journal::NoteGap(double from_s, double to_s, const std::string& reason) {
  Append(json{{"event", "gap"}, {"from_s", from_s}, {"to_s", to_s}, {"reason", reason}}.dump());
}

void Journal::RemoveView(int view_id) { Append(json{{"event", "remove"}, {"id", view_id}}.dump()); }

void Journal::Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons) {
  Append(json{{"event", "close"}, {"capture_s", capture_s}, {"reasons", reasons}}.dump());
}

}  // namespace ulf
