#include "acquisition/calibration/lens_files/plain_numbers.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "acquisition/calibration/lens_files/marked_keys.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// The keys of fx, fy, cx and cy are written as LensWord() makes them.
using PlainKeys = std::array<std::string_view, 4>;
constexpr std::array kPlainKeys = {
    PlainKeys{"fx", "fy", "cx", "cy"},
    PlainKeys{"fx", "fy", "ppx", "ppy"},
    PlainKeys{"fx", "fy", "u0", "v0"},
    PlainKeys{"fu", "fv", "cu", "cv"},
    PlainKeys{"fu", "fv", "u0", "v0"},
    PlainKeys{"focalx", "focaly", "cx", "cy"},
    PlainKeys{"flx", "fly", "cx", "cy"},
    PlainKeys{"focallengthx", "focallengthy", "principalpointx", "principalpointy"},
    PlainKeys{"focallengthx", "focallengthy", "cx", "cy"},
};
// Lists of two, for the focal lengths and for the principal point.
constexpr std::array<std::string_view, 3> kFocalLists = {"focallength", "focallengths", "focal"};
constexpr std::array<std::string_view, 4> kPointLists = {"principalpoint", "principalpoints", "opticalcenter",
                                                         "pp"};

const LensNode* BehindWord(const LensNode& map, std::string_view word) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (LensWord(map.keys[i]) == word) return &map.items[i];
  return nullptr;
}

// The two texts of a list of two numbers; empty: there is none.
std::vector<std::string> PairBehind(const LensNode& map, std::span<const std::string_view> words) {
  for (const std::string_view word : words) {
    const LensNode* node = BehindWord(map, word);
    if (!node || !node->IsList() || node->items.size() != 2) continue;
    if (!LensNumber(node->items[0]) || !LensNumber(node->items[1])) continue;
    return {node->items[0].text, node->items[1].text};
  }
  return {};
}

// fx, fy, cx, cy as they stand in the map; empty: it has no such numbers.
std::vector<std::string> PlainPinhole(const LensNode& map) {
  for (const PlainKeys& keys : kPlainKeys) {
    std::vector<std::string> found;
    for (const std::string_view key : keys)
      if (const LensNode* node = BehindWord(map, key); node && LensNumber(*node)) found.push_back(node->text);
    if (found.size() == keys.size()) return found;
  }
  std::vector<std::string> focal = PairBehind(map, kFocalLists), point = PairBehind(map, kPointLists);
  if (focal.empty() || point.empty()) return {};
  focal.insert(focal.end(), point.begin(), point.end());
  return focal;
}

// RealSense's cameras name a model that OpenCV does not have also where all coefficients are zero.
bool HasOnlyZeros(const LensNode& map, std::string_view key) {
  const LensNode* node = BehindWord(map, key);
  const auto numbers = node ? LensNumbersIn(*node) : std::nullopt;
  return numbers && std::ranges::all_of(*numbers, [](double value) { return value == 0; });
}

}  // namespace

LensNode WithCameraMatrices(const LensNode& top) {
  LensNode made = top;
  for (LensNode& item : made.items)
    if (item.IsMap() || item.IsList()) item = WithCameraMatrices(item);
  if (!made.IsMap() || !MarksOfMatrices(made).empty()) return made;
  const std::vector<std::string> pinhole = PlainPinhole(made);
  if (pinhole.empty()) return made;
  if (BehindWord(made, "ppx") && HasOnlyZeros(made, "coeffs"))
    for (std::size_t i = made.keys.size(); i-- > 0;)
      if (LensWord(made.keys[i]) == "model") {
        made.keys.erase(made.keys.begin() + static_cast<std::ptrdiff_t>(i));
        made.items.erase(made.items.begin() + static_cast<std::ptrdiff_t>(i));
      }
  LensNode matrix{.kind = LensNode::Kind::kList};
  for (const std::string& text : {pinhole[0], std::string("0"), pinhole[2], std::string("0"), pinhole[1],
                                  pinhole[3], std::string("0"), std::string("0"), std::string("1")})
    matrix.items.push_back({.kind = LensNode::Kind::kText, .text = text});
  made.keys.emplace_back(kPlainMatrixKey);
  made.items.push_back(std::move(matrix));
  return made;
}

std::optional<std::vector<double>> PlainCoefficients(const LensNode& map, const LensNumbers& numbers,
                                                     const std::string& where) {
  constexpr std::array<std::string_view, 8> kRadialTangential = {"k1", "k2", "p1", "p2",
                                                                 "k3", "k4", "k5", "k6"};
  constexpr std::array<std::string_view, 8> kFisheye = {"k1", "k2", "k3", "k4", "p1", "p2", "k5", "k6"};
  const bool is_fisheye = numbers.said && numbers.said->model == LensModel::kFisheye;
  std::vector<double> found;
  std::size_t count = 0;
  bool are_zero = true;
  for (const std::string_view word : is_fisheye ? kFisheye : kRadialTangential) {
    const LensNode* node = BehindWord(map, word);
    const auto number = node ? LensNumber(*node) : std::nullopt;
    if (number) ++count;
    if (number && is_fisheye && found.size() >= 4 && *number != 0)
      throw Error("{}: '{}' is {}, which does not belong to '{}'; {}", where, word, *number,
                  numbers.said->said, kLensWayOut);
    are_zero = are_zero && number.value_or(0) == 0;
    found.push_back(number.value_or(0));
  }
  if (count == 0) {
    for (std::size_t i = 0; i < map.keys.size(); ++i)
      if (map.items[i].IsMap() && LensWord(map.keys[i]).find("dist") != std::string::npos &&
          !map.items[i].Has("data"))
        return PlainCoefficients(map.items[i], numbers, where);
    return std::nullopt;
  }
  if (!are_zero && !numbers.said)
    throw Error(
        "{}: 'k1', ... hold distortion in a form that ulf does not read without a word for the lens's model; "
        "add the "
        "line distortion_model: plumb_bob (k1 k2 p1 p2 k3) or distortion_model: equidistant (a fisheye's k1 "
        "k2 k3 k4)",
        where);
  if (are_zero && !numbers.said) return std::vector<double>(4);
  if (is_fisheye && BehindWord(map, "k4") == nullptr && !are_zero)
    throw Error("{}: a fisheye has k1 k2 k3 k4, and 'k4' is missing; write the file again, or add k4: 0",
                where);
  found.resize(is_fisheye                                                                     ? 4
               : numbers.said->model == LensModel::kRational                                  ? 8
               : std::all_of(found.begin() + 5, found.end(), [](double v) { return v == 0; }) ? 5
                                                                                              : 8);
  return found;
}

}  // namespace ulf::acquisition
