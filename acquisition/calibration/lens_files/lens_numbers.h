// Converts the numbers of a lens file to a camera model, with the checks that all formats share: counts that
// contradict each other, and numbers that no lens has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_tree.h"
#include "acquisition/calibration/lens_files/lens_words.h"
#include "core/geometry/camera_model.h"

namespace ulf::acquisition {

struct Lens {
  CameraModel camera = {};
  std::vector<std::string> warnings = {};  // what was assumed, for the user; each names the file
};

struct LensNumbers {
  double width = 0, height = 0;  // 0: the file does not say
  double fx = 0, fy = 0, cx = 0, cy = 0;
  // The principal point counts from the picture's corner; false: from the middle of the first pixel.
  bool from_corner = false;
  std::vector<double> coefficients = {};  // in OpenCV's order
  std::optional<NamedLensModel> named = {};
  bool IsFisheye() const { return named && named->model == LensModel::kFisheye; }
  bool is_ros = false;                                           // then no word for the model means plumb_bob
  std::string size_keys = "image_width: W and image_height: H";  // lines to add where the size is missing
  std::vector<std::string> warnings = {};
};

// Sets focal lengths and principal point from the camera matrix behind `key`. Throws Error for a matrix that
// is no camera matrix, has skew, or is empty; transposes one with its columns first, as MATLAB and Open3D
// write it, with a warning.
void SetCameraMatrix(LensNumbers& numbers, const LensMatrix& matrix, const std::string& key,
                     const std::string& where);

// Throws Error that names the first value that is not finite.
void RequireFinite(const std::vector<double>& values, const std::string& key, const std::string& where);

// Returns a warning about a file without coefficients, which may be complete without them.
std::string WarningOfNoCoefficients(const std::string& where);

// Makes the camera model from the numbers. Throws Error that begins with `where` for numbers that make none.
Lens FinishedLens(const LensNumbers& numbers, const std::string& where);

// Throws Error that begins with `where` for a focal length or a principal point in shares of the picture or
// in millimetres; adds a warning for values that only unusual lenses and parts of a sensor have.
void CheckLensNumbers(Lens& lens, const std::string& where);

// Returns the name of the wanted one of a file's cameras, or of the only one. `wanted`: a name, its end or
// number (0 of cam0, left of narrow_stereo/left), or a topic, in any case; `topics`: one for each name, or
// empty. Throws Error that lists the cameras.
std::string PickLens(const std::vector<std::string>& names, const std::string& wanted,
                     const std::string& where, const std::vector<std::string>& topics = {});

// Throws Error if a camera is wanted by another number than 0 of a file that has a single one without a name.
void RequireOnlyLens(const std::string& wanted, const std::string& where);

// Reads the size of a lens's pictures under any of the words that programs have for it: two keys, a list, or
// a text. Searches the maps in their order, and in each the keys with the camera's mark (marked_keys.h)
// before those without. If the name of a list leaves the order of width and height open, the principal point
// of `numbers` decides. Throws Error that begins with `where`, also if it does not decide.
void ReadLensSize(const std::vector<const LensNode*>& maps, const std::string& mark, LensNumbers& numbers,
                  const std::string& where);

}  // namespace ulf::acquisition
