#include "acquisition/calibration/lens_files/lens_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "acquisition/calibration/lens_files/lens_tree.h"
#include "acquisition/calibration/lens_files/matrix_files.h"
#include "acquisition/calibration/lens_files/other_files.h"
#include "acquisition/calibration/lens_files/program_files.h"
#include "acquisition/calibration/lens_files/set_files.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

struct LensProgram {
  const char* name;
  const char* files;
  // Null: what has no tree is looked for elsewhere.
  bool (*is)(const LensNode& top) = nullptr;
  Lens (*read)(const LensNode& top, const std::string& where, const std::string& wanted) = nullptr;
};

// In the order in which they are looked for.
constexpr std::array kLensPrograms = {
    LensProgram{"ulf", "JSON of ulf calibrate, or one line fx fy cx cy k1 k2 p1 p2 width height"},
    LensProgram{"COLMAP", "cameras.txt"},
    LensProgram{"nerfstudio", "transforms.json, also of instant-ngp"},
    LensProgram{"Basalt", "calibration.json", IsBasaltLens, ReadBasaltLens},
    LensProgram{"calib.io", "JSON with the OpenCV model", IsCalibIoLens, ReadCalibIoLens},
    LensProgram{"Metashape", "the lens's XML, Agisoft's own form", IsMetashapeLens, ReadMetashapeLens},
    LensProgram{"maplab", "camera YAML, one or a rig, also of aslam_cv2", IsMaplabLens, ReadMaplabLens},
    LensProgram{"Kalibr", "camchain YAML", IsKalibrLens, ReadKalibrLens},
    LensProgram{"EuRoC", "sensor.yaml", IsEurocLens, ReadEurocLens},
    LensProgram{"ORB-SLAM", "settings YAML", IsOrbSlamLens, ReadOrbSlamLens},
    LensProgram{"VINS", "camera YAML", IsVinsLens, ReadVinsLens},
    LensProgram{"ROS", "camera_info YAML, an echo of the topic, ost.ini"},
    LensProgram{"OpenCV", "YAML, XML or JSON with camera_matrix and distortion_coefficients"},
};

// Whether damaged text has words of a lens file: else it is of something else, which no message should tell to mend.
bool HasLensWords(const std::string& text) {
  for (const char* word : {"intrinsic", "amera_matrix", "ameraMatrix", "istortion", "resolution",
                           "K:", "\"K\"", "fx", "<f>", "projection", "amera_model", "mage_width", "opencv"})
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// As LensTreesOf(); none for damaged text without words of a lens file, too.
std::optional<std::vector<LensNode>> TreesOfLensText(const std::string& text, const std::string& where) {
  try {
    return LensTreesOf(text, where);
  } catch (const Error&) {
    if (HasLensWords(text)) throw;
    return std::nullopt;
  }
}

}  // namespace

std::optional<ReadLens> ReadLensText(const std::string& text, const std::string& where,
                                     const std::string& camera) {
  if (const auto other = OtherLensText(text))
    throw Error("{}: {}. Read are the files of {}", where, *other, ReadableLensFiles());
  if (IsColmapCameras(text)) return ReadLens{ReadColmapLens(text, where, camera), "COLMAP"};
  const auto trees = TreesOfLensText(text, where);
  if (!trees || trees->empty()) return std::nullopt;
  const LensNode& top = trees->front();
  if (IsTransformsLens(top)) return ReadLens{ReadTransformsLens(text, where, camera), "nerfstudio"};
  for (const LensProgram& program : kLensPrograms)
    if (program.is && program.is(top)) return ReadLens{program.read(top, where, camera), program.name};
  if (const auto other = OtherLensTree(top))
    throw Error("{}: {}. Read are the files of {}", where, *other, ReadableLensFiles());
  if (std::ranges::any_of(*trees, HasCameraMatrix))
    return ReadLens{ReadMatrixLens(*trees, where, camera), IsRosLens(top) ? "ROS" : "OpenCV"};
  std::vector<std::string> keys;
  constexpr std::size_t kMostKeys = 6;
  for (std::size_t i = 0; i < std::min(kMostKeys, top.keys.size()); ++i)
    keys.push_back(top.keys[i].substr(0, 40));
  throw Error("{}: holds no lens that ulf knows{}{}. Read are the files of {}", where,
              keys.empty() ? "" : fmt::format(" (it holds {}", fmt::join(keys, ", ")),
              keys.empty()                  ? ""
              : top.keys.size() > kMostKeys ? ", ...)"
                                            : ")",
              ReadableLensFiles());
}

std::string ReadableLensFiles() {
  std::string list;
  for (const LensProgram& program : kLensPrograms)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", program.name, program.files);
  return list;
}

std::vector<std::string> ReadableLensPrograms() {
  std::vector<std::string> names;
  for (const LensProgram& program : kLensPrograms) names.push_back(program.name);
  return names;
}

}  // namespace ulf::acquisition
