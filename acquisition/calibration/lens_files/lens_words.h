// Finds what a lens file says about the lens's model, in the words of any program: a word decides, never the
// number of coefficients.
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
  kRational,          // k1 k2 p1 p2 k3 k4 k5 k6; ulf has it only with k4 k5 k6 zero
  kFisheye,           // k1 k2 k3 k4 of Kannala and Brandt
};

struct NamedLensModel {
  LensModel model = LensModel::kNone;
  std::string named = {};  // key and word, for messages: "distortion_model: equidistant"
};

// A clause for messages: what ulf models, and what to do with another lens.
extern const char* const kLensWayOut;

// Reads a word for a model. Returns none when it says only how points are projected (pinhole, perspective,
// frame), or is empty. Throws Error that names the word, and begins with `where`, for a model that ulf does
// not have or know. `named`: for messages.
std::optional<NamedLensModel> LensModelOfWord(std::string_view word, const std::string& named,
                                              const std::string& where);

// Returns the model that the keys of a map name: distortion_model, camera_model, type, fisheye_model and
// similar ones. Returns none when they say nothing. Throws as LensModelOfWord(), for two words that
// contradict each other, and for keys of other models (xi).
std::optional<NamedLensModel> NamedLensModelOf(const LensNode& map, const std::string& where);

// Returns whether the map has a key for the lens's model whose value is empty.
bool HasEmptyLensModel(const LensNode& map);

// Checks a lens file for mentions of a fisheye or of an omnidirectional lens that NamedLensModelOf() does not
// recognise as the model, because such a lens must not be read silently as k1 k2 p1 p2. `part`: what the file
// says of the camera, at any depth. Where `named` is none, throws Error that begins with `where`, quotes key
// and value, and advises to add `lines`; for names of cameras, topics and files it appends to `warnings`
// instead. A named model decides: text that mentions another one is a warning, names are ignored.
void CheckLensMentions(const LensNode& part, const std::optional<NamedLensModel>& named,
                       const std::string& lines, const std::string& where,
                       std::vector<std::string>& warnings);

}  // namespace ulf::acquisition
