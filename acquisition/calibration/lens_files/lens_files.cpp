#include "acquisition/calibration/lens_files/lens_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

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
  // Null: what has no tree is looked for elsewhere.
  bool (*is)(const LensNode& top) = nullptr;
  Lens (*read)(const LensNode& top, const std::string& where, const std::string& wanted) = nullptr;
};

// In the order in which they are looked for.
constexpr std::array kLensPrograms = {
    LensProgram{"ulf"},
    LensProgram{"COLMAP"},
    LensProgram{"nerfstudio"},
    LensProgram{"Gyroflow", IsGyroflowLens, ReadGyroflowLens},
    LensProgram{"Basalt", IsBasaltLens, ReadBasaltLens},
    LensProgram{"calib.io", IsCalibIoLens, ReadCalibIoLens},
    LensProgram{"Metashape", IsMetashapeLens, ReadMetashapeLens},
    LensProgram{"maplab", IsMaplabLens, ReadMaplabLens},
    LensProgram{"Kalibr", IsKalibrLens, ReadKalibrLens},
    LensProgram{"EuRoC", IsEurocLens, ReadEurocLens},
    LensProgram{"okvis", IsOkvisLens, ReadOkvisLens},
    LensProgram{"ORB-SLAM", IsOrbSlamLens, ReadOrbSlamLens},
    LensProgram{"VINS", IsVinsLens, ReadVinsLens},
    LensProgram{"ROS"},
    LensProgram{"OpenCV"},
};

// Whether damaged text has words of a lens file: else it is of something else, which no message should tell to mend.
bool HasLensWords(const std::string& text) {
  for (const char* word :
       {"intrinsic", "matrix", "ameraMatrix", "istortion", "resolution", "K:", "\"K\"", "fx", "<f>", "fl_x",
        "camera_angle", "projection", "amera_model", "mage_width", "opencv"})
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// Throws Error for a message of ROS (CameraInfo) that ends before its camera matrix does.
void RefuseCutMessage(const LensNode& top, const std::string& where) {
  if (!top.Has("distortion_model") || !top.Has("height")) return;
  const char* key = top.Has("K") ? "K" : "k";
  const LensNode* matrix = top.Find(key);
  throw Error("{}: '{}' has {} of 9 values: the file may be cut; write it again", where, key,
              matrix ? std::ranges::count_if(matrix->items, &LensNode::IsText) : 0);
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
  const auto refuse = [&](const std::string& what) {
    throw Error("{}: {}. {}", where, what, ReadableLensFiles());
  };
  // It checks the numbers of readers that do not check them by themselves.
  const auto checked = [&](Lens lens, const char* program) {
    CheckLensNumbers(lens, where);
    return ReadLens{lens, program};
  };
  if (const auto other = OtherLensText(text)) refuse(*other);
  if (IsColmapCameras(text)) return checked(ReadColmapLens(text, where, camera), "COLMAP");
  const auto trees = TreesOfLensText(text, where);
  if (!trees || trees->empty()) return std::nullopt;
  const LensNode& top = trees->front();
  if (IsTransformsLens(top)) return checked(ReadTransformsLens(text, where, camera), "nerfstudio");
  for (const LensProgram& program : kLensPrograms)
    if (program.is && program.is(top)) return ReadLens{program.read(top, where, camera), program.name};
  if (const auto other = OtherLensTree(top)) refuse(*other);
  if (std::ranges::any_of(*trees,
                          [](const LensNode& tree) { return HasCameraMatrix(WithCameraMatrices(tree)); })) {
    // JSON and XML close what they open.
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool is_section =
        text[first] == '[' && std::isalpha(static_cast<unsigned char>(text[first + 1])) != 0;
    const bool may_be_cut = is_section || std::string_view("{[<").find(text[first]) == std::string_view::npos;
    return ReadLens{ReadMatrixLens(*trees, where, camera, may_be_cut), IsRosLens(top) ? "ROS" : "OpenCV"};
  }
  RefuseCutMessage(top, where);
  constexpr std::size_t kMostKeys = 6;
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < std::min(kMostKeys, top.keys.size()); ++i)
    keys.push_back("'" + top.keys[i].substr(0, 40) + "'");
  if (top.keys.size() > kMostKeys) keys.emplace_back("...");
  refuse(fmt::format("holds no lens that ulf knows: neither a camera matrix nor fx, fy, cx and cy{}",
                     keys.empty() ? "" : fmt::format(" (its keys are {})", fmt::join(keys, ", "))));
  return std::nullopt;
}

std::string ReadableLensFiles() {
  return fmt::format("Lenses of {} are read (docs/calibration.md)", fmt::join(ReadableLensPrograms(), ", "));
}

std::vector<std::string> ReadableLensPrograms() {
  std::vector<std::string> names;
  for (const LensProgram& program : kLensPrograms) names.emplace_back(program.name);
  return names;
}

}  // namespace ulf::acquisition
