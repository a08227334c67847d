// What a lens file says of the lens's model, in the words of any program: a word decides, never the number of
// coefficients.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

enum class LensModel {
  kNone,              // no distortion
  kRadialTangential,  // k1 k2 p1 p2 [k3]
  kRational,          // k1 k2 p1 p2 k3 k4 k5 k6: ours where k4 k5 k6 are zero
  kFisheye,           // k1 k2 k3 k4 of Kannala and Brandt
};

struct SaidLensModel {
  LensModel model = LensModel::kNone;
  std::string said = {};  // "distortion_model: equidistant"
};

// What ulf models, and what to do with another lens; ends no sentence.
extern const char* const kLensWayOut;

// A word for a model; none: it says only how points are projected (pinhole, perspective, frame), or is empty.
// Throws Error that names the word, and begins with `where`, for a model that ulf does not have or know.
// `said`: for messages.
std::optional<SaidLensModel> LensModelOfWord(std::string_view word, const std::string& said,
                                             const std::string& where);

// What the keys of a map say, distortion_model, camera_model, type, fisheye_model and their like. None:
// nothing. Throws as LensModelOfWord(), for two words that contradict each other, and for keys of other
// models (xi).
std::optional<SaidLensModel> SaidLensModelOf(const LensNode& map, const std::string& where);

// Whether the map has a key for the lens's model without a word.
bool HasEmptyLensModel(const LensNode& map);

// Text of a lens file that speaks of a fisheye or of an omnidirectional lens under a key, or in a wording,
// that SaidLensModelOf() does not take as the model's word. Such a lens must not be taken silently as k1 k2
// p1 p2. `part`: what the file says of the camera, at any depth. Where `said` is none, throws Error that
// begins with `where`, quotes key and value, and tells to add `lines`; names of cameras, topics and files are
// appended to `warnings` instead. Where there is a word, it decides: text that speaks of another model is a
// warning, names are left alone.
void CheckLensMentions(const LensNode& part, const std::optional<SaidLensModel>& said,
                       const std::string& lines, const std::string& where,
                       std::vector<std::string>& warnings);

}  // namespace ulf::acquisition
