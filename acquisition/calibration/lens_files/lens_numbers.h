// From the numbers of a lens file to a camera model, with the checks that all dialects share: counts that
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
  // Whether the principal point counts from the picture's corner, as ulf does; else from the middle of the
  // first pixel.
  bool from_corner = false;
  std::vector<double> coefficients = {};  // in OpenCV's order
  std::optional<SaidLensModel> said = {};
  bool is_ros = false;                                           // no word is plumb_bob there
  std::string size_keys = "image_width: W and image_height: H";  // lines to add where the size is missing
  std::vector<std::string> warnings = {};
};

// Sets focal lengths and principal point. Throws Error for a matrix that is no camera matrix, has skew, or is
// empty; one with its columns first, as MATLAB and Open3D write it, is turned, with a warning.
void SetCameraMatrix(LensNumbers& numbers, const LensMatrix& matrix, const std::string& key,
                     const std::string& where);

// This warns of a file that has no coefficients and may be whole without them.
std::string WarningOfNoCoefficients(const std::string& where);

// Throws Error that begins with `where`.
Lens FinishedLens(const LensNumbers& numbers, const std::string& where);

// What no lens has: throws Error that begins with `where` for a focal length or a principal point in parts of
// the picture or in millimetres; a warning names what only strange lenses and parts of a sensor have.
void CheckLensNumbers(Lens& lens, const std::string& where);

// The wanted one of a file's cameras, or the only one: by its name, its number (cam0: 0; narrow_stereo/left:
// left), or its topic, one for each name or none at all; cases do not matter. Throws Error that lists them.
std::string PickLens(const std::vector<std::string>& names, const std::string& wanted,
                     const std::string& where, const std::vector<std::string>& topics = {});

// Of a file that has only one camera without a name. Throws Error where one is wanted.
void RequireOnlyLens(const std::string& wanted, const std::string& where);

// The size of a lens's pictures under any of the words that programs have for it: two keys, a list, or a
// text. Looks in the maps in their order, and in each for the keys with the mark before those without. The
// principal point of `numbers` decides what the name of a list leaves open. Throws Error that begins with
// `where`, also where it does not.
void ReadLensSize(const std::vector<const LensNode*>& maps, const std::string& mark, LensNumbers& numbers,
                  const std::string& where);

}  // namespace ulf::acquisition
