// Reads and writes cameras in transforms.json: intrinsics with the keys of nerfstudio and instant-ngp, for
// the whole set or per frame. Lengths are pixels, pixel centres at integer + 0.5; "camera_angle_x" is in
// radians, "x_fov" in degrees. "distortion_params" are k1 k2 k3 k4 p1 p2. Keys of lenses that ulf does not
// have (panoramas, f-theta, thin prisms) are refused.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/json_fields.h"
#include "core/geometry/camera_model.h"
#include "core/light_field/formats/fitted_lens.h"

namespace ulf {

// Returns whether the value of a key says no: null, false or 0.
bool IsOff(const nlohmann::json& value);
bool IsCameraKey(const std::string& key);
// Returns the camera keys of an object, without null values.
nlohmann::json CameraKeysOf(const nlohmann::json& object);
// Merges camera keys as nerfstudio does: the keys of a frame override those of the set. If a frame contains a
// key for the focal length, or for the lens model, no such key of the set is used (but a focal length along
// the one axis that neither the frame nor the set says with it); nor are coefficients, if the frame spells
// them otherwise ("distortion_params" instead of "k1" and so on).
nlohmann::json MergedCameraKeys(const nlohmann::json& set, const nlohmann::json& frame);
bool HasSize(const JsonPlace& place);
bool HasIntrinsics(const JsonPlace& place);
// The size is that of the file `example_image` if none is given. Throws an Error that names the place and the
// key if a value is missing, impossible, of another lens model or contradicted by another.
// A lens that our model lacks (OPENCV with k4, as nerfstudio has it) is taken in by `fitted`, and without it
// refused.
CameraModel ReadCamera(const JsonPlace& place, const std::filesystem::path& example_image,
                       FittedLenses* fitted = nullptr);

void WriteCamera(const CameraModel& camera, nlohmann::json& object);
// Writes the lens model, which nerfstudio reads only at the top level, for a set with several cameras:
// nothing if some are fisheyes and some are not.
void WriteCameraKind(const std::vector<CameraModel>& cameras, nlohmann::json& object);

}  // namespace ulf
