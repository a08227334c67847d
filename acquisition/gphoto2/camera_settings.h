// The settings of a photograph under the names that different makers' drivers give them: shutter, ISO,
// aperture, focus, exposure program, file format. Values are compared as what they mean ("1/125" is
// "0.0080s").
//
// Locked: what the URI asks for is written and read back, and everything is watched from then on. A setting
// that turns by itself (an automatic ISO, a dial that somebody moves) changes the picture in the middle of a
// capture: it is told.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

enum class ShotSetting { kShutter, kIso, kAperture, kFocus, kFormat, kProgram };
inline constexpr std::array kShotSettings{ShotSetting::kShutter, ShotSetting::kIso,    ShotSetting::kAperture,
                                          ShotSetting::kFocus,   ShotSetting::kFormat, ShotSetting::kProgram};
const char* Name(ShotSetting setting);  // as in the URI: "shutter", "iso", ...

// "1/125", "0.0080s", "f/5.6", "ISO 200", "2.5"; none for "Auto", "bulb".
std::optional<double> PhotographicNumber(const std::string& text);
bool MeansTheSame(const std::string& a, const std::string& b);
// What to write for a value that a person gave: the choice that means it. None when there is no such choice.
std::optional<std::string> ChoiceFor(const std::vector<std::string>& choices, const std::string& value);
// Of a setting that can be manual or automatic; none when it offers nothing manual.
std::optional<std::string> ManualChoice(const std::vector<std::string>& choices);
bool IsAutomatic(const std::string& value);

// For people, of an image format without JPEG: what is to be set instead. Empty where there is a JPEG.
std::string RawFormatProblem(GphotoCamera& camera, const std::string& image_format);

class CameraSettings {
 public:
  // Finds which settings the camera has. `uri` is for the words of errors.
  CameraSettings(GphotoCamera& camera, const std::string& uri);

  // Writes and reads back. Throws UsageError for a value that the camera does not offer, with those it does;
  // Error when the camera does not keep it.
  void Lock(ShotSetting setting, const std::string& value);
  // Everything else as far as the camera lets itself be told: manual exposure program. What stays automatic
  // is returned, in words.
  std::vector<std::string> LockTheRest(const std::vector<ShotSetting>& given);

  // What has changed since the last call, in words. Asks the camera.
  std::vector<std::string> Changes();
  // As last read; empty when the camera has no such setting.
  std::string Value(ShotSetting setting) const;
  std::optional<double> Number(ShotSetting setting) const { return PhotographicNumber(Value(setting)); }

 private:
  struct Known {
    std::string name;  // the driver's
    std::string value;
  };
  GphotoCamera& camera_;
  std::string uri_;
  std::map<ShotSetting, Known> known_;
};

}  // namespace ulf::acquisition
