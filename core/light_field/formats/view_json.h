// Converts the properties of a view to JSON, with the same keys in the journal and in transforms.json
// ("ulf").
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/json_fields.h"
#include "core/light_field/light_field.h"

namespace ulf {

// The keys are id, master, mask, master_transfer, master_mosaic, device_time_s, host_time_s, exposure_s,
// gain, black_level, frame_id, line_status, clock, f_number, tracking_quality, bound_px, exposures, merged;
// neither image path nor pose.
nlohmann::json ViewToJson(const View& view);
// Writes the subset that needs no pose, for a photograph that is no view.
nlohmann::json PhotographToJson(const View& view);

inline constexpr int kMostViewId = 999'999'999;  // nine digits in a file's name

// Sets the values that are present. Paths are unchecked.
void ReadViewJson(const JsonPlace& place, View& view);
void ReadPhotographJson(const JsonPlace& place, View& view);

// Returns the path with '/' between folders, without following links (followed_links.h does). Throws Error if
// it is absolute or leaves the folder by "..".
std::string PathBelow(const std::string& relative, const std::string& where);
// Replaces the paths that ReadViewJson() and ReadPhotographJson() read by those of PathBelow(). Throws as it
// does.
void RequirePathsBelow(const std::string& where, View& view);

// The form is [qw qx qy qz tx ty tz].
nlohmann::json PoseToJson(const Rigid3& pose);
Rigid3 PoseFromJson(const JsonPlace& place, const char* key);

// The keys of another exposure of a view are those of a photograph, image, exposure_from_view and pose.
nlohmann::json ExposureToJson(const ViewExposure& exposure);
// Paths are unchecked.
ViewExposure ExposureFromJson(const JsonPlace& place);

// The form is "merged": {image, exposures, ghosts}.
nlohmann::json MergedToJson(const MergedExposures& merged);
MergedExposures MergedFromJson(const JsonPlace& place);

// Reads device_uri, device_serial, device_maker, device_model, sensor, units, threshold_px,
// coverage_width_px, with the same keys in the journal's header and under "ulf" in transforms.json.
void ReadCaptureJson(const JsonPlace& place, LightField& light_field);
// Writes those that are known.
nlohmann::json CaptureToJson(const CaptureFacts& facts);

// Reads calibration_source, the origin of this camera's intrinsics; without the key it stays.
void NoteCalibrationSource(const JsonPlace& place, int camera, LightField& light_field);

// Reads {"covered": 781, "recorded": 217}: why frames were recorded or not.
std::map<std::string, std::uint64_t> ReasonsFromJson(const JsonPlace& place);

// The form is {"cover":"bound","goal_db":33,"frames":412,"directions":[[x,y,z,angle,db,px,"cause"],...]}.
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
