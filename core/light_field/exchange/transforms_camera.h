// A camera in transforms.json: intrinsics by the keys of nerfstudio and instant-ngp, of the set or of a
// frame.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/json_fields.h"
#include "core/geometry/camera_model.h"

namespace ulf {

bool IsCameraKey(const std::string& key);
// Those of an object's keys, without null values.
nlohmann::json CameraKeysOf(const nlohmann::json& object);
// Key by key, as nerfstudio reads them: what a frame says of its camera stands before what the set says. A
// frame that gives its focal length, or its kind of lens, in one way gives it whole.
nlohmann::json MergedCameraKeys(const nlohmann::json& set, const nlohmann::json& frame);
bool HasIntrinsics(const JsonPlace& place);
// The size of `example_image` where none is given. Throws Error that names the place and the key.
CameraModel ReadCamera(const JsonPlace& place, const std::filesystem::path& example_image);

void WriteCamera(const CameraModel& camera, nlohmann::json& object);
// For sets of several cameras: nerfstudio looks for the kind of lens at the top alone.
void WriteCameraKind(const std::vector<CameraModel>& cameras, nlohmann::json& object);

}  // namespace ulf
