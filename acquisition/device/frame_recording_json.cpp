#include "acquisition/device/frame_recording_json.h"

#include "core/geometry/camera_json.h"

namespace ulf::acquisition {
namespace {

using nlohmann::json;

constexpr int kVersion = 2;  // version 1 has no photographs' files, sensor and flat field

void AddCalibration(json& header, const std::string& prefix, const std::optional<CameraModel>& camera,
                    const std::optional<FlatField>& flat_field) {
  if (camera) header[prefix + "camera"] = CameraToJson(*camera);
  if (flat_field) header[prefix + "flat_field"] = FlatFieldToJson(*flat_field);
}

void ReadCalibration(const JsonPlace& line, const std::string& prefix, std::optional<CameraModel>& camera,
                     std::optional<FlatField>& flat_field) {
  const std::string camera_key = prefix + "camera", flat_field_key = prefix + "flat_field";
  if (line.Has(camera_key.c_str()))
    camera = CameraFromJson({line.Raw(camera_key.c_str()), line.where + ", " + camera_key});
  if (line.Has(flat_field_key.c_str()))
    flat_field = FlatFieldFromJson(line.Raw(flat_field_key.c_str()), line.where + ", " + flat_field_key);
}

}  // namespace

json RecordingHeaderToJson(const RecordingHeader& header) {
  const DeviceInfo& device = header.device;
  json line = {{"event", "header"},
               {"version", kVersion},
               {"device",
                {{"uri", device.uri},
                 {"maker", device.maker},
                 {"model", device.model},
                 {"serial", device.serial},
                 {"bus", device.bus}}},
               {"takes_stills", header.takes_stills}};
  if (header.window) line["sensor"] = WindowToJson(*header.window);
  AddCalibration(line, "", header.camera, header.flat_field);
  AddCalibration(line, "still_", header.still_camera, header.still_flat_field);
  return line;
}

RecordingHeader RecordingHeaderFromJson(const JsonPlace& line) {
  if (line.Integer("version") > kVersion)
    throw Error("{}: a recording of a newer version; use a newer ulf", line.where);
  const JsonPlace device{line.Raw("device"), line.where + ", device"};
  RecordingHeader header;
  header.device = {.uri = device.Text("uri", ""),
                   .maker = device.Text("maker", ""),
                   .model = device.Text("model", ""),
                   .serial = device.Text("serial", ""),
                   .bus = device.Text("bus", "files"),
                   .problem = ""};
  if (line.Has("sensor")) header.window = WindowFromJson({line.Raw("sensor"), line.where + ", sensor"});
  header.takes_stills = line.Has("takes_stills") && line.Raw("takes_stills") == true;
  ReadCalibration(line, "", header.camera, header.flat_field);
  ReadCalibration(line, "still_", header.still_camera, header.still_flat_field);
  return header;
}

json FrameToJson(const Frame& frame, const std::string& file, const std::string& raw_file) {
  json line = {{"event", "frame"},
               {"id", frame.id},
               {"device_time_s", frame.device_time_s},
               {"host_time_s", frame.host_time_s},
               {"exposure_s", frame.exposure_s},
               {"gain", frame.gain},
               {"black_level", frame.black_level},
               {"transfer", frame.image.transfer == Transfer::kLinear ? "linear" : "srgb"}};
  if (!file.empty()) line["file"] = file;
  if (!raw_file.empty()) line["raw"] = raw_file;
  if (frame.f_number) line["f_number"] = *frame.f_number;
  if (frame.kind == FrameKind::kStill) line["still"] = true;
  if (frame.requested_s) line["requested_s"] = *frame.requested_s;
  if (frame.status == FrameStatus::kIncomplete) line["incomplete"] = true;
  if (frame.image.mosaic != Mosaic::kNone) line["mosaic"] = Name(frame.image.mosaic);
  if (frame.known_cam_from_world) {
    const Eigen::Quaterniond& q = frame.known_cam_from_world->rotation;
    const Eigen::Vector3d& t = frame.known_cam_from_world->translation;
    line["known_cam_from_world"] = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
  }
  return line;
}

Frame FrameFromJson(const JsonPlace& line) {
  Frame frame;
  frame.id = static_cast<std::uint64_t>(line.Number("id"));
  frame.device_time_s = line.Number("device_time_s");
  frame.host_time_s = line.Number("host_time_s", 0);
  frame.exposure_s = line.Number("exposure_s", 0);
  frame.gain = line.Number("gain", 1);
  frame.black_level = line.Number("black_level", 0);
  if (line.Has("f_number")) frame.f_number = line.Number("f_number");
  if (line.Has("still")) frame.kind = FrameKind::kStill;
  if (line.Has("requested_s")) frame.requested_s = line.Number("requested_s");
  if (line.Has("incomplete")) frame.status = FrameStatus::kIncomplete;
  frame.image.transfer = line.Text("transfer", "srgb") == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  if (line.Has("mosaic")) {
    const auto mosaic = MosaicByName(line.Text("mosaic"));
    if (!mosaic) throw Error("{}: there is no mosaic '{}'", line.where, line.Text("mosaic"));
    frame.image.mosaic = *mosaic;
  }
  if (line.Has("known_cam_from_world")) {
    const std::vector<double> n = line.Numbers("known_cam_from_world", 7);
    frame.known_cam_from_world =
        Rigid3{Eigen::Quaterniond(n[0], n[1], n[2], n[3]), Eigen::Vector3d(n[4], n[5], n[6])};
  }
  return frame;
}

}  // namespace ulf::acquisition
