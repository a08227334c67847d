#include "acquisition/calibration/lens_files/marked_keys.h"

#include <algorithm>
#include <cctype>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr auto kMatrixWords = LensWordsIn<15>(
    "cameramatrix intrinsicmatrix intrinsicsmatrix cameraintrinsics cameraintrinsic intrinsics intrinsic mtx "
    "cammatrix cameramat matrix cam fxfycxcy k m");
constexpr auto kCoefficientWords = LensWordsIn<14>(
    "distortioncoefficients distortioncoeffs distortioncoeff distortionparameters distortionvector "
    "distcoefficients distcoeffs distcoeff distcoefs distortion coeffs dist distortions d");

bool IsMark(std::string_view word) {
  for (const std::string_view mark : {"left", "right", "l", "r", "rgb", "color", "colour", "ir", "depth"})
    if (word == mark) return true;
  if (word.starts_with("camera")) word.remove_prefix(6);
  if (word.starts_with("cam")) word.remove_prefix(3);
  return !word.empty() && word.size() <= 2 &&
         std::ranges::all_of(word, [](unsigned char c) { return std::isdigit(c) != 0; });
}

// Keys that may be of poses and colours as well: only numbers in the form of a camera matrix are one.
bool IsMatrixBehind(std::string_view base, const LensNode& value) {
  if (!LooksLikeLensMatrix(value)) return false;
  if (base != "matrix" && base != "cam") return true;
  const LensNode* data = value.IsMap() ? value.Find("data") : &value;
  const auto numbers = data ? LensNumbersIn(*data) : std::nullopt;
  constexpr std::size_t kOfMatrix = 9;
  return numbers && numbers->size() == kOfMatrix && (*numbers)[0] > 1 && (*numbers)[4] > 1 &&
         (*numbers)[8] == 1;
}

}  // namespace

const std::span<const std::string_view> kMatrixKeys = kMatrixWords;
const std::span<const std::string_view> kCoefficientKeys = kCoefficientWords;

std::optional<MarkedKey> MarkedAs(const std::string& key, std::span<const std::string_view> bases) {
  const std::string word = LensWord(key);
  for (const std::string_view base : bases)
    if (word == base) return MarkedKey{base, ""};
  for (const std::string_view base : bases) {
    if (word.size() <= base.size()) continue;
    const std::string behind = word.substr(base.size()), before = word.substr(0, word.size() - base.size());
    if (word.starts_with(base) && IsMark(behind)) return MarkedKey{base, behind};
    if (word.ends_with(base) && IsMark(before)) return MarkedKey{base, before};
  }
  return std::nullopt;
}

std::pair<std::string, const LensNode*> FindMarked(const LensNode& map,
                                                   std::span<const std::string_view> bases,
                                                   const std::string& mark, const std::string& where,
                                                   const std::function<bool(const LensNode&)>& test) {
  std::pair<std::string, const LensNode*> found{"", nullptr};
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const auto marked = MarkedAs(map.keys[i], bases);
    if (!marked || marked->mark != mark || !test(map.items[i])) continue;
    if (!found.second) {
      found = {map.keys[i], &map.items[i]};
      continue;
    }
    const auto first = LensNumbersIn(*found.second), second = LensNumbersIn(map.items[i]);
    if (first && second ? *first != *second : *found.second != map.items[i])
      throw Error("{}: '{}' and '{}' are of the same thing and have different values; delete the wrong one",
                  where, found.first, map.keys[i]);
  }
  return found;
}

std::vector<std::string> MarksOfMatrices(const LensNode& map) {
  std::vector<std::string> marks;
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const auto marked = MarkedAs(map.keys[i], kMatrixKeys);
    if (marked && IsMatrixBehind(marked->base, map.items[i]) &&
        std::ranges::find(marks, marked->mark) == marks.end())
      marks.push_back(marked->mark);
  }
  return marks;
}

}  // namespace ulf::acquisition
