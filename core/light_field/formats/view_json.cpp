#include "core/light_field/formats/view_json.h"

#include <algorithm>
#include <cmath>

#include "core/base/json_text.h"
#include "core/geometry/camera_json.h"
#include "core/light_field/light_field.h"

namespace ulf {

namespace {

constexpr char kSharedClock[] = "ieee1588";

// JSON numbers are exact up to this value.
constexpr double kMostExact = 9007199254740992;

std::optional<std::uint64_t> CountIn(const JsonPlace& place, const char* key) {
  if (!place.Has(key)) return std::nullopt;
  const double value = place.Number(key);
  if (!(value >= 0 && value <= kMostExact))
    throw Error("{}: '{}' must be a count, not {}", place.where, key, value);
  return static_cast<std::uint64_t>(value);
}

}  // namespace

nlohmann::json PoseToJson(const Rigid3& cam_from_world) {
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

std::string PathBelow(const std::string& relative, const std::string& where) {
  const std::filesystem::path path = std::filesystem::path(relative).lexically_normal();
  if (relative.empty() || path.is_absolute() || *path.begin() == "..")
    throw Error("{}: the path '{:.200}' leaves the folder; a light field only holds what lies inside it",
                where, relative);
  return path.generic_string();
}

void RequirePathsBelow(const std::string& where, View& view) {
  const auto require = [&](std::string& path) {
    if (!path.empty()) path = PathBelow(path, where);
  };
  require(view.master_path);
  require(view.mask_path);
  for (ViewExposure& exposure : view.exposures) {
    require(exposure.image_path);
    require(exposure.master_path);
  }
  if (view.merged) require(view.merged->path);
}

nlohmann::json PhotographToJson(const View& view) {
  nlohmann::json keys = {{"device_time_s", view.device_time_s},
                         {"host_time_s", view.host_time_s},
                         {"exposure_s", view.exposure_s},
                         {"gain", view.gain},
                         {"black_level", view.black_level}};
  if (view.frame_id) keys["frame_id"] = *view.frame_id;
  if (view.line_status) keys["line_status"] = *view.line_status;
  if (view.on_shared_clock) keys["clock"] = kSharedClock;
  if (!view.master_path.empty()) keys["master"] = view.master_path;
  if (!view.mask_path.empty()) keys["mask"] = view.mask_path;
  if (view.master_transfer)
    keys["master_transfer"] = *view.master_transfer == Transfer::kLinear ? "linear" : "srgb";
  if (view.master_mosaic != Mosaic::kNone) keys["master_mosaic"] = Name(view.master_mosaic);
  if (view.f_number) keys["f_number"] = *view.f_number;
  if (view.focal_mm) keys["focal_mm"] = *view.focal_mm;
  if (!view.lens.empty()) keys["lens"] = view.lens;
  if (view.raw_white_balance) keys["raw_white_balance"] = *view.raw_white_balance;
  return keys;
}

nlohmann::json ViewToJson(const View& view) {
  nlohmann::json keys = PhotographToJson(view);
  keys["id"] = view.id;
  keys["tracking_quality"] = view.tracking_quality;
  if (view.bound_px) keys["bound_px"] = *view.bound_px;
  if (view.twist) keys["twist"] = *view.twist;
  for (const ViewExposure& exposure : view.exposures) keys["exposures"].push_back(ExposureToJson(exposure));
  if (view.merged) keys["merged"] = MergedToJson(*view.merged);
  return keys;
}

void ReadViewJson(const JsonPlace& place, View& view) {
  view.id = place.Integer("id", view.id);
  if (view.id < 1 || view.id > kMostViewId)
    throw Error("{}: 'id' is {}; views are numbered from 1 to {}", place.where, view.id, kMostViewId);
  ReadPhotographJson(place, view);
  view.tracking_quality = place.Number("tracking_quality", 1);
  if (place.Has("bound_px")) view.bound_px = place.Number("bound_px");
  if (place.Has("twist")) {
    const std::vector<double> twist = place.Numbers("twist", 6);
    view.twist.emplace();
    std::ranges::copy(twist, view.twist->begin());
  }
  if (place.Has("exposures"))
    for (const nlohmann::json& exposure : place.Raw("exposures"))
      view.exposures.push_back(ExposureFromJson({exposure, place.where + ", exposures"}));
  if (place.Has("merged")) view.merged = MergedFromJson(place.Inside("merged"));
}

void ReadPhotographJson(const JsonPlace& place, View& view) {
  view.master_path = place.Text("master", "");
  view.mask_path = place.Text("mask", view.mask_path);
  if (place.Has("master_transfer")) {
    const std::string transfer = place.Text("master_transfer");
    if (transfer != "linear" && transfer != "srgb")
      throw Error("{}: 'master_transfer' must be linear or srgb, not '{}'", place.where, transfer);
    view.master_transfer = transfer == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  }
  if (place.Has("master_mosaic")) {
    const std::string pattern = place.Text("master_mosaic");
    const auto mosaic = MosaicByName(pattern);
    if (!mosaic || mosaic == Mosaic::kNone)
      throw Error("{}: 'master_mosaic' must be RGGB, GRBG, GBRG or BGGR, not '{}'", place.where, pattern);
    view.master_mosaic = *mosaic;
  }
  view.device_time_s = place.Number("device_time_s", 0);
  view.host_time_s = place.Number("host_time_s", 0);
  view.exposure_s = place.Number("exposure_s", 0);
  view.gain = place.Number("gain", 1);
  view.black_level = place.Number("black_level", 0);
  view.frame_id = CountIn(place, "frame_id");
  view.line_status = CountIn(place, "line_status");
  view.on_shared_clock = place.Text("clock", "") == kSharedClock;
  if (place.Has("f_number")) view.f_number = place.Number("f_number");
  if (place.Has("focal_mm")) view.focal_mm = place.Number("focal_mm");
  view.lens = place.Text("lens", "");
  if (place.Has("raw_white_balance")) {
    const std::vector<double> factors = place.Numbers("raw_white_balance", 3);
    if (std::ranges::any_of(factors, [](double factor) { return !(factor > 0); }))
      throw Error("{}: 'raw_white_balance' must be three positive factors", place.where);
    view.raw_white_balance.emplace();
    std::ranges::copy(factors, view.raw_white_balance->begin());
  }
}

nlohmann::json ExposureToJson(const ViewExposure& exposure) {
  nlohmann::json keys = PhotographToJson(PhotographOf({}, exposure));
  if (!exposure.image_path.empty()) keys["image"] = exposure.image_path;
  keys["exposure_from_view"] = PoseToJson(exposure.exposure_from_view);
  keys["pose"] = exposure.pose_is_between ? "between" : "found";
  return keys;
}

ViewExposure ExposureFromJson(const JsonPlace& place) {
  View photograph;
  ReadPhotographJson(place, photograph);
  photograph.image_path = place.Text("image", "");
  ViewExposure exposure{photograph, PoseFromJson(place, "exposure_from_view"),
                        place.Text("pose", "found") == "between"};
  if (exposure.image_path.empty() && exposure.master_path.empty())
    throw Error("{}: an exposure needs 'image' or 'master'", place.where);
  if (!(exposure.exposure_s > 0))
    throw Error("{}: an exposure needs 'exposure_s' above 0, not {}", place.where, exposure.exposure_s);
  return exposure;
}

nlohmann::json MergedToJson(const MergedExposures& merged) {
  return {{"image", merged.path}, {"exposures", merged.exposures}, {"ghosts", merged.ghost_share}};
}

MergedExposures MergedFromJson(const JsonPlace& place) {
  MergedExposures merged{place.Text("image"), place.Integer("exposures"), place.Number("ghosts")};
  if (merged.exposures < 2 || !(merged.ghost_share >= 0 && merged.ghost_share <= 1))
    throw Error("{}: {} merged exposures with a share of {} of ghosts are not possible", place.where,
                merged.exposures, merged.ghost_share);
  return merged;
}

void ReadCaptureJson(const JsonPlace& place, LightField& light_field) {
  light_field.device_uri = place.Text("device_uri", "");
  light_field.device_serial = place.Text("device_serial", "");
  light_field.device_maker = place.Text("device_maker", "");
  light_field.device_model = place.Text("device_model", "");
  if (place.Has("sensor")) light_field.window = WindowFromJson(place.Inside("sensor"));
  light_field.units = place.Text("units", "arbitrary");
  if (place.Has("threshold_px")) light_field.threshold_px = place.Number("threshold_px");
  light_field.coverage_width_px = place.Integer("coverage_width_px", kCoverageWidthPx);
}

nlohmann::json CaptureToJson(const CaptureFacts& facts) {
  nlohmann::json keys{{"units", facts.units}, {"coverage_width_px", facts.coverage_width_px}};
  if (!facts.device_uri.empty()) keys["device_uri"] = facts.device_uri;
  if (!facts.device_serial.empty()) keys["device_serial"] = facts.device_serial;
  if (!facts.device_maker.empty()) keys["device_maker"] = facts.device_maker;
  if (!facts.device_model.empty()) keys["device_model"] = facts.device_model;
  if (facts.window) keys["sensor"] = WindowToJson(*facts.window);
  if (facts.threshold_px) keys["threshold_px"] = *facts.threshold_px;
  return keys;
}

void NoteCalibrationSource(const JsonPlace& place, int camera, LightField& light_field) {
  const std::string source = place.Text("calibration_source", "");
  if (!source.empty()) light_field.calibration_sources[camera] = source;
}

std::map<std::string, std::uint64_t> ReasonsFromJson(const JsonPlace& place) {
  if (!place.object.is_object()) throw Error("{}: must be an object of counts", place.where);
  std::map<std::string, std::uint64_t> reasons;
  for (const auto& [reason, count] : place.object.items()) {
    if (!count.is_number_unsigned())
      throw Error("{}: '{}' must be a count, not {}", place.where, reason, JsonText(count).substr(0, 40));
    reasons[reason] = count.get<std::uint64_t>();
  }
  return reasons;
}

nlohmann::json MeasuredToJson(const MeasuredErrors& measured) {
  nlohmann::json directions = nlohmann::json::array();
  for (const MeasuredDirection& at : measured.directions)
    directions.push_back({at.direction.x(), at.direction.y(), at.direction.z(), at.nearest_view_angle,
                          at.one_sided, at.db, at.db_outside, at.misregistration_px, at.cause});
  return {{"cover", measured.cover},
          {"goal_db", measured.goal_db},
          {"frames", measured.frames},
          {"directions", std::move(directions)}};
}

MeasuredErrors MeasuredFromJson(const JsonPlace& place) {
  MeasuredErrors measured;
  measured.cover = place.Text("cover", measured.cover);
  measured.goal_db = place.Number("goal_db", 0);
  measured.frames = static_cast<std::uint64_t>(std::max(0.0, place.Number("frames", 0)));
  if (!place.Has("directions")) return measured;
  constexpr std::size_t kNumbers = 8;
  for (const nlohmann::json& each : place.Raw("directions")) {
    const bool is_whole = each.is_array() && each.size() == kNumbers + 1 && each[kNumbers].is_string() &&
                          std::all_of(each.begin(), each.begin() + kNumbers,
                                      [](const nlohmann::json& number) { return number.is_number(); });
    if (!is_whole)
      throw Error("{}: a measured direction must be eight numbers and a cause, not {}", place.where,
                  JsonText(each).substr(0, 60));
    MeasuredDirection at;
    at.direction = {each[0].get<double>(), each[1].get<double>(), each[2].get<double>()};
    if (!(at.direction.norm() > 0)) throw Error("{}: a measured direction is zero", place.where);
    at.direction.normalize();
    at.nearest_view_angle = each[3].get<double>();
    at.one_sided = each[4].get<double>();
    at.db = each[5].get<double>();
    at.db_outside = each[6].get<double>();
    at.misregistration_px = each[7].get<double>();
    at.cause = each[kNumbers].get<std::string>();
    measured.directions.push_back(at);
  }
  return measured;
}

nlohmann::json ReadoutToJson(const ShutterReadout& readout) {
  nlohmann::json keys = {{"readout_s", readout.readout_s}};
  if (readout.sigma_s) keys["sigma_s"] = *readout.sigma_s;
  return keys;
}

ShutterReadout ReadoutFromJson(const JsonPlace& place) {
  ShutterReadout readout{place.Number("readout_s"), {}};
  if (!(std::abs(readout.readout_s) <= 1))
    throw Error("{}: a readout of {} s is not possible; the most is 1 s", place.where, readout.readout_s);
  if (place.Has("sigma_s")) readout.sigma_s = place.Positive("sigma_s");
  return readout;
}

nlohmann::json CoverageGoalToJson(const CoverageGoal& goal) {
  return {{"cap_deg", {goal.cap_deg.x(), goal.cap_deg.y()}}, {"share", goal.share}};
}

CoverageGoal CoverageGoalFromJson(const JsonPlace& place) {
  const std::vector<double> cap = place.Numbers("cap_deg", 2);
  const double share = place.Number("share");
  if (!(cap[0] > 0 && cap[0] <= 360 && cap[1] > 0 && cap[1] <= 180 && share > 0 && share <= 1))
    throw Error(
        "{}: a goal of {} x {} degrees and a share of {} is not possible; the most is 360 x 180, and 1",
        place.where, cap[0], cap[1], share);
  return {{cap[0], cap[1]}, share};
}

std::vector<KeptFinding> KeptFindingsFromJson(const JsonPlace& event) {
  std::vector<KeptFinding> kept;
  const std::string check = event.Text("check");
  for (const nlohmann::json& object : event.Raw("found")) {
    const JsonPlace found{object, event.where + ", found"};
    KeptFinding& each = kept.emplace_back();
    each.check = check;
    each.text = found.Text("text");
    each.whole = found.Has("whole") && found.Raw("whole") == nlohmann::json(true);
    for (const auto& [id, view] : found.Raw("views").items()) {
      const JsonPlace judged{view, found.where + ", view " + id};
      each.views[std::atoi(id.c_str())] = {judged.Text("photograph", ""), judged.Text("pose", "")};
    }
  }
  return kept;
}

nlohmann::json KeptFindingsToJson(const std::string& check, const std::vector<KeptFinding>& kept) {
  nlohmann::json event{{"check", check}, {"found", nlohmann::json::array()}};
  for (const KeptFinding& each : kept) {
    nlohmann::json views = nlohmann::json::object();
    for (const auto& [id, judged] : each.views) {
      nlohmann::json& view = views[std::to_string(id)] = nlohmann::json::object();
      if (!judged.photograph.empty()) view["photograph"] = judged.photograph;
      if (!judged.pose.empty()) view["pose"] = judged.pose;
    }
    event["found"].push_back({{"text", each.text}, {"whole", each.whole}, {"views", std::move(views)}});
  }
  return event;
}

}  // namespace ulf
