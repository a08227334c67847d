#include "acquisition/calibration/lens_files/matrix_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_words.h"
#include "acquisition/calibration/lens_files/marked_keys.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// A camera of the file: its map, those that this lies in, and its mark in there.
struct FoundLens {
  std::string name;
  std::vector<const LensNode*> maps;  // the innermost first
  std::string mark;
};

void FindLenses(const LensNode& node, const std::string& name, std::vector<const LensNode*> outer, int levels,
                std::vector<FoundLens>& found) {
  if (node.IsMap()) outer.insert(outer.begin(), &node);
  if (node.IsMap())
    for (const std::string& mark : MarksOfMatrices(node))
      found.push_back({name.empty() ? mark : mark.empty() ? name : name + "." + mark, outer, mark});
  if (levels == 0) return;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const LensNode& item = node.items[i];
    // The numbers of a matrix are no cameras.
    if ((!item.IsMap() && !item.IsList()) || (item.IsMap() && item.Has("data"))) continue;
    const std::string inner = node.IsMap() ? node.keys[i] : std::to_string(i + 1);
    FindLenses(item, name.empty() ? inner : name + "." + inner, outer, levels - 1, found);
  }
}

constexpr int kLevelsOfLenses = 3;

std::vector<FoundLens> LensesIn(const LensNode& document) {
  std::vector<FoundLens> found;
  FindLenses(document, "", {}, kLevelsOfLenses, found);
  return found;
}

// Distortion under a key that is not known would be left out silently.
void RefuseUnknownDistortion(const LensNode& map, const std::string& where) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const bool is_distortion = LensWord(map.keys[i]).find("distortion") != std::string::npos &&
                               !map.items[i].IsText() && map.items[i].kind != LensNode::Kind::kNothing;
    if (is_distortion)
      throw Error(
          "{}: '{}' holds distortion in a form that ulf does not read beside a camera matrix; write it as "
          "distortion_coefficients: [k1, k2, p1, p2, k3]",
          where, map.keys[i]);
  }
}

// A file without coefficients is one of a lens without distortion, or was cut. Programs that write matrices
// with rows and columns, and ROS, always write coefficients; texts that do not end by themselves may have
// been cut.
void RefuseCutFile(const FoundLens& found, const LensNode& matrix, const LensNumbers& numbers,
                   bool may_be_cut, const std::string& where) {
  const bool says_none = numbers.named && numbers.named->model == LensModel::kNone;
  // Middlebury's stereo sets are rectified.
  if (says_none || found.maps.front()->Has("doffs")) return;
  if (!matrix.IsMap() && !numbers.named && !numbers.is_ros &&
      (!may_be_cut || found.maps.front()->Has(kPlainMatrixKey)))
    return;
  throw Error(
      "{}: there is a camera matrix, but there are no distortion coefficients{}: the file may be cut. Write "
      "it again; if the lens has no distortion, add the line distortion_coefficients: [0, 0, 0, 0, 0]",
      where, numbers.named ? " for '" + numbers.named->named + "'" : "");
}

std::vector<double> LensCoefficients(const FoundLens& found, const LensNode& of_matrix, bool may_be_cut,
                                     LensNumbers& numbers, const std::string& where) {
  std::pair<std::string, const LensNode*> list{"", nullptr};
  for (const LensNode* map : found.maps) {
    // A text without numbers is a word for the model.
    list = FindMarked(*map, kCoefficientKeys, found.mark, where, [](const LensNode& value) {
      return value.kind == LensNode::Kind::kNothing || value.IsList() ||
             (value.IsMap() && (value.Has("data") || value.Has("rows"))) ||
             (value.IsText() && LensNumbersIn(value));
    });
    if (list.second) break;
    if (const auto plain = PlainCoefficients(*map, numbers, where)) return *plain;
    RefuseUnknownDistortion(*map, where);
  }
  const auto& [key, node] = list;
  if (!node) {
    RefuseCutFile(found, of_matrix, numbers, may_be_cut, where);
    if (!numbers.named) numbers.warnings.push_back(WarningOfNoCoefficients(where));
    return {};
  }
  // Nothing but a tag, or a name alone in ost.ini, is an empty text.
  if (node->kind == LensNode::Kind::kNothing || (node->IsText() && LensWord(node->text).empty()))
    throw Error(
        "{}: nothing stands behind '{}': the file may be cut. Write it again; if the lens has no distortion, "
        "write {}: []",
        where, key, key);
  const LensMatrix matrix = LensMatrixOf(*node, key, where);
  if (std::min(matrix.rows, matrix.cols) > 1)
    throw Error("{}: '{}' has {} x {} values; distortion coefficients are one row or one column", where, key,
                matrix.rows, matrix.cols);
  RequireFinite(matrix.numbers, key, where);
  return matrix.numbers;
}

// `flags` of OpenCV's calibrateCamera: what they say must not contradict the coefficients. fisheye::calibrate
// has other meanings for the same bits.
void CheckFlags(const FoundLens& found, const LensNumbers& numbers, const std::string& where) {
  const LensNode* node = nullptr;
  std::string key;
  for (const char* name : {"flags", "flagValue", "calibration_flags", "calib_flags"})
    if (!node && found.maps.front()->Has(name)) node = found.maps.front()->Find(key = name);
  const auto value = node ? LensNumber(*node) : std::nullopt;
  if (!value || !(*value >= 0 && *value < 1e9)) return;
  const auto flags = static_cast<unsigned>(*value);
  const std::vector<double>& d = numbers.coefficients;
  constexpr unsigned kNoTangential = 8, kRational = 16384, kThinPrism = 32768, kTilted = 262144;
  if (numbers.IsFisheye()) return;
  if ((flags & kNoTangential) != 0 && d.size() >= 4 && (d[2] != 0 || d[3] != 0))
    throw Error(
        "{}: '{}: {}' is without tangential distortion (CALIB_ZERO_TANGENT_DIST), but the third and fourth "
        "coefficient, {} and {}, are not zero. If they are a fisheye's, whose flag of this value is "
        "CALIB_FIX_SKEW, add the line fisheye_model: 1; else delete the flags",
        where, key, flags, d[2], d[3]);
  const std::size_t least = (flags & kTilted) != 0      ? 14
                            : (flags & kThinPrism) != 0 ? 12
                            : (flags & kRational) != 0  ? 8
                                                        : 0;
  if (d.size() < least)
    throw Error(
        "{}: '{}: {}' is of a model with {} coefficients (CALIB_RATIONAL_MODEL, THIN_PRISM or TILTED), but "
        "there are {}; write the file again",
        where, key, flags, least, d.size());
}

void WarnOfWindow(const LensNode& map, LensNumbers& numbers, const std::string& where) {
  const auto value = [&](const LensNode* node) { return node ? LensNumber(*node).value_or(0) : 0; };
  const double x = value(map.Find("binning_x")), y = value(map.Find("binning_y"));
  if (x > 1 || y > 1)
    numbers.warnings.push_back(
        fmt::format("{}: binning {:g}x{:g}: the lens is that of pictures without binning, of {:g}x{:g}, and "
                    "is scaled to pictures of the same shape",
                    where, std::max(1.0, x), std::max(1.0, y), numbers.width, numbers.height));
  const LensNode* roi = map.Find("roi");
  if (!roi) return;
  const double width = value(roi->Find("width")), height = value(roi->Find("height")),
               left = value(roi->Find("x_offset")), top = value(roi->Find("y_offset"));
  const bool is_whole = left == 0 && top == 0 &&
                        ((width == 0 && height == 0) || (width == numbers.width && height == numbers.height));
  if (!is_whole)
    numbers.warnings.push_back(
        fmt::format("{}: roi {:g}x{:g}+{:g}+{:g}: the lens is that of the whole picture of {:g}x{:g}; "
                    "pictures of the region alone need a calibration of their own, or the sensor and the "
                    "region that ulf calibration binds them to",
                    where, width, height, left, top, numbers.width, numbers.height));
}

// Returns the map without what is said of another camera in it, as distortion_model_right.
LensNode WordsOfLens(const LensNode& map, const std::string& mark) {
  constexpr std::array<std::string_view, 4> kWords = {"distortionmodel", "cameramodel", "model", "xi"};
  LensNode words{.kind = LensNode::Kind::kMap};
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const auto marked = MarkedAs(map.keys[i], kWords);
    const bool has_mark = marked && !marked->mark.empty();
    if (has_mark && marked->mark != mark) continue;
    words.Add(has_mark ? std::string(marked->base) : map.keys[i], map.items[i]);
  }
  return words;
}

bool IsOfMark(const std::string& key, const std::string& mark) {
  // A single letter must stand alone, as in type_r.
  const std::string word = LensWord(key);
  if (mark.size() > 1 || std::isdigit(static_cast<unsigned char>(mark[0])) != 0)
    return word.starts_with(mark) || word.ends_with(mark);
  return key.size() > 2 && (LensWord(std::string_view(key).substr(0, 2)) == mark ||
                            LensWord(std::string_view(key).substr(key.size() - 2)) == mark);
}

// Returns what the file says of this camera, at any depth: the maps that it lies in, without other cameras.
LensNode PartOfLens(const FoundLens& found) {
  LensNode part{.kind = LensNode::Kind::kMap};
  std::vector<std::string> others = MarksOfMatrices(*found.maps.front());
  std::erase_if(others, [&](const std::string& mark) { return mark.empty() || mark == found.mark; });
  for (const LensNode* map : found.maps)
    for (std::size_t i = 0; i < map->keys.size(); ++i) {
      const std::string& key = map->keys[i];
      const bool is_of_other =
          std::ranges::any_of(others, [&](const std::string& mark) { return IsOfMark(key, mark); });
      if (is_of_other || HasCameraMatrix(map->items[i])) continue;
      part.Add(key, map->items[i]);
    }
  // The camera's own name: of a map that is called fisheye, this is the word.
  const bool is_word = LensWord(found.name) == "fisheye" || LensWord(found.name) == "equidistant";
  part.Add(is_word ? "camera" : "camera name", {.kind = LensNode::Kind::kText, .text = found.name});
  return part;
}

// Numbers beside the matrix must be the matrix's, up to rounding and where pixels are counted from.
void RefuseOtherPinhole(const LensNode& map, const LensNumbers& numbers, const std::string& key,
                        const std::string& where) {
  constexpr double kSame_px = 1;
  for (const auto& [name, value] : {std::pair{"fx", numbers.fx}, std::pair{"fy", numbers.fy},
                                    std::pair{"cx", numbers.cx}, std::pair{"cy", numbers.cy}}) {
    const auto beside = map.Has(name) ? LensNumber(*map.Find(name)) : std::nullopt;
    if (beside && std::abs(*beside - value) > kSame_px)
      throw Error("{}: '{}: {}' stands beside '{}', which has {} there; delete the wrong one", where, name,
                  *beside, key, value);
  }
}

Lens ReadFoundLens(const FoundLens& found, bool may_be_cut, const std::string& where) {
  LensNumbers numbers;
  const LensNode& map = *found.maps.front();
  auto [key, matrix] = FindMarked(map, kMatrixKeys, found.mark, where, LooksLikeLensMatrix);
  // In A2D2's file CamMatrix is of pictures without their distortion.
  if (const LensNode* distorted = map.Find("CamMatrixOriginal"))
    std::tie(key, matrix) = std::pair(std::string("CamMatrixOriginal"), distorted);
  numbers.is_ros = IsRosLens(map);
  // A word stands beside the numbers or in a map around them.
  for (const LensNode* outer : found.maps)
    if (!numbers.named) numbers.named = NamedLensModelOf(WordsOfLens(*outer, found.mark), where);
  CheckLensMentions(PartOfLens(found), numbers.named,
                    "distortion_model: equidistant (a fisheye's k1 k2 k3 k4), or distortion_model: plumb_bob "
                    "(k1 k2 p1 p2 k3)",
                    where, numbers.warnings);
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (const auto skew = LensNumber(map.items[i]); skew && *skew != 0 && LensWord(map.keys[i]) == "skew")
      throw Error("{}: '{}' is {}, which ulf does not support; calibrate again with CALIB_FIX_SKEW", where,
                  map.keys[i], *skew);
  SetCameraMatrix(numbers, LensMatrixOf(*matrix, key, where), key, where);
  if (key != kPlainMatrixKey && found.mark.empty()) RefuseOtherPinhole(map, numbers, key, where);
  ReadLensSize(found.maps, found.mark, numbers, where);
  numbers.coefficients = LensCoefficients(found, *matrix, may_be_cut, numbers, where);
  CheckFlags(found, numbers, where);
  WarnOfWindow(map, numbers, where);
  return FinishedLens(numbers, where);
}

// Returns whether they are of one list, and equal.
bool AreSameLens(const std::vector<FoundLens>& all, bool may_be_cut, const std::string& where) {
  const auto without_number = [](std::string name) {
    std::erase_if(name, [](unsigned char c) { return std::isdigit(c) != 0; });
    return name;
  };
  for (const FoundLens& found : all)
    if (without_number(found.name) != without_number(all[0].name)) return false;
  try {
    const Lens first = ReadFoundLens(all[0], may_be_cut, where);
    return std::all_of(all.begin() + 1, all.end(), [&](const FoundLens& found) {
      return ReadFoundLens(found, may_be_cut, where).camera == first.camera;
    });
  } catch (const Error&) {
    return false;  // the one that is wanted is read, or named
  }
}

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

// Returns the two texts of a list of two numbers; empty if there is none.
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

bool HasCameraMatrix(const LensNode& top) { return !LensesIn(top).empty(); }

bool IsRosLens(const LensNode& top) {
  const auto is = [](const LensNode& map) {
    if (!map.IsMap()) return false;
    if (HasEmptyLensModel(map)) return true;
    for (const char* key :
         {"rectification_matrix", "projection_matrix", "binning_x", "header", "rectification"})
      if (map.Has(key)) return true;
    return (map.Has("camera_name") && map.Has("distortion_model")) || (map.Has("R") && map.Has("P")) ||
           (map.Has("r") && map.Has("p"));
  };
  return is(top) || std::ranges::any_of(top.items, is);
}

Lens ReadMatrixLens(const std::vector<LensNode>& documents, const std::string& where,
                    const std::string& wanted, bool may_be_cut) {
  std::vector<LensNode> with_matrices;
  for (const LensNode& document : documents) with_matrices.push_back(WithCameraMatrices(document));
  std::vector<FoundLens> all;
  for (std::size_t i = 0; i < with_matrices.size(); ++i)
    for (FoundLens& found : LensesIn(with_matrices[i])) {
      const bool is_numbered = documents.size() > 1;
      if (is_numbered) found.name = std::to_string(i + 1) + (found.name.empty() ? "" : "." + found.name);
      all.push_back(std::move(found));
    }
  // Messages of one topic, or pictures of one camera, one after the other: the same lens, unless it was set
  // anew.
  if (all.size() > 1 && wanted.empty() && AreSameLens(all, may_be_cut, where))
    return ReadFoundLens(all[0], may_be_cut, where);
  if (all.size() == 1 && all[0].name.empty()) RequireOnlyLens(wanted, where);
  std::vector<std::string> names;
  for (const FoundLens& found : all) names.push_back(found.name);
  const std::string name = PickLens(names, wanted, where);
  const auto chosen = std::ranges::find(all, name, &FoundLens::name);
  return ReadFoundLens(*chosen, may_be_cut, all.size() == 1 ? where : where + ", camera " + name);
}

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
  made.Add(kPlainMatrixKey, std::move(matrix));
  return made;
}

std::optional<std::vector<double>> PlainCoefficients(const LensNode& map, const LensNumbers& numbers,
                                                     const std::string& where) {
  constexpr std::array<std::string_view, 8> kRadialTangential = {"k1", "k2", "p1", "p2",
                                                                 "k3", "k4", "k5", "k6"};
  constexpr std::array<std::string_view, 8> kFisheye = {"k1", "k2", "k3", "k4", "p1", "p2", "k5", "k6"};
  const bool is_fisheye = numbers.IsFisheye();
  std::vector<double> found;
  std::size_t count = 0;
  bool are_zero = true;
  for (const std::string_view word : is_fisheye ? kFisheye : kRadialTangential) {
    const LensNode* node = BehindWord(map, word);
    const auto number = node ? LensNumber(*node) : std::nullopt;
    if (number) ++count;
    if (number && is_fisheye && found.size() >= 4 && *number != 0)
      throw Error("{}: '{}' is {}, which does not belong to '{}'; {}", where, word, *number,
                  numbers.named->named, kLensWayOut);
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
  if (!are_zero && !numbers.named)
    throw Error(
        "{}: 'k1', ... hold distortion in a form that ulf does not read without a word for the lens's model; "
        "add the line distortion_model: plumb_bob (k1 k2 p1 p2 k3) or distortion_model: equidistant (a "
        "fisheye's k1 k2 k3 k4)",
        where);
  if (are_zero && !numbers.named) return std::vector<double>(4);
  if (is_fisheye && BehindWord(map, "k4") == nullptr && !are_zero)
    throw Error("{}: a fisheye has k1 k2 k3 k4, and 'k4' is missing; write the file again, or add k4: 0",
                where);
  found.resize(is_fisheye                                                                     ? 4
               : numbers.named->model == LensModel::kRational                                 ? 8
               : std::all_of(found.begin() + 5, found.end(), [](double v) { return v == 0; }) ? 5
                                                                                              : 8);
  return found;
}

}  // namespace ulf::acquisition
