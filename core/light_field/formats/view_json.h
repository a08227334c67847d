// Converts properties of a light field and its views to JSON and back, with the same keys in the journal and
// in transforms.json (under "ulf"); docs/light_field.md describes them. The readers throw an Error that names
// the place and the key if a value is missing, of another type or impossible; they leave paths unchecked.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_fields.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Writes all keys of a view but its image path, camera and pose.
nlohmann::json ViewToJson(const View& view);
// Writes those of a photograph that is no view: no id, nothing that needs a pose, and no exposures.
nlohmann::json PhotographToJson(const View& view);

inline constexpr int kMostViewId = 999'999'999;  // nine digits in a file's name

// These read what the two write, into a new view, whose id and mask hold if their keys are missing.
void ReadViewJson(const JsonPlace& place, View& view);
void ReadPhotographJson(const JsonPlace& place, View& view);

// Returns the path, normalised and with '/' between folders, without following links (followed_links.h does).
// Throws Error if it is empty, is absolute or leaves the folder by "..".
std::string PathBelow(const std::string& relative, const std::string& where);
// Replaces the paths that ReadViewJson() and ReadPhotographJson() read by those of PathBelow().
void RequirePathsBelow(const std::string& where, View& view);

// The form is [qw qx qy qz tx ty tz], with a unit quaternion.
nlohmann::json PoseToJson(const Rigid3& pose);
Rigid3 PoseFromJson(const JsonPlace& place, const char* key);

// The keys of another exposure of a view are those of a photograph, image, exposure_from_view and pose.
nlohmann::json ExposureToJson(const ViewExposure& exposure);
ViewExposure ExposureFromJson(const JsonPlace& place);

// The form is {image, exposures, ghosts}.
nlohmann::json MergedToJson(const MergedExposures& merged);
MergedExposures MergedFromJson(const JsonPlace& place);

// These read and write device_uri, device_serial, device_maker, device_model, sensor, units, threshold_px and
// coverage_width_px of the journal's header. What is unknown is not written.
void ReadCaptureJson(const JsonPlace& place, LightField& light_field);
nlohmann::json CaptureToJson(const CaptureFacts& facts);

// Reads calibration_source, the origin of this camera's intrinsics; without the key, the former one stays.
void NoteCalibrationSource(const JsonPlace& place, int camera, LightField& light_field);

// Reads {"covered": 781, "recorded": 217}: why frames were recorded or not.
std::map<std::string, std::uint64_t> ReasonsFromJson(const JsonPlace& place);

// The form is {"cover":"bound","goal_db":33,"frames":412,"directions":[[x,y,z, nearest_view_angle, one_sided,
// db, db_outside, misregistration_px, "cause"],...]}.
nlohmann::json MeasuredToJson(const MeasuredErrors& measured);
MeasuredErrors MeasuredFromJson(const JsonPlace& place);

// The form is {"readout_s":0.0281,"sigma_s":0.0004}.
nlohmann::json ReadoutToJson(const ShutterReadout& readout);
ShutterReadout ReadoutFromJson(const JsonPlace& place);

// The form is {"cap_deg":[width,height],"share":0 to 1}.
nlohmann::json CoverageGoalToJson(const CoverageGoal& goal);
CoverageGoal CoverageGoalFromJson(const JsonPlace& place);

// The form is {"check":"light","found":[{"text":"...","whole":false,"views":
// {"7":{"photograph":"...","pose":"..."}}}]}.
std::vector<KeptFinding> KeptFindingsFromJson(const JsonPlace& event);
nlohmann::json KeptFindingsToJson(const std::string& check, const std::vector<KeptFinding>& kept);

}  // namespace ulf
