#include "acquisition/calibration/lens_files/lens_sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "acquisition/calibration/lens_files/marked_keys.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

// The words are written as LensWord() makes them. Rows and columns alone are a board's as well.
constexpr std::array<std::string_view, 13> kWidthWords = {
    "imagewidth", "imgwidth",    "width",     "w",          "widthpx",     "imagewidthpx", "imgw",
    "framewidth", "resolutionx", "imagecols", "imagesizex", "camerawidth", "videowidth"};
constexpr std::array<std::string_view, 13> kHeightWords = {
    "imageheight", "imgheight",   "height",    "h",          "heightpx",     "imageheightpx", "imgh",
    "frameheight", "resolutiony", "imagerows", "imagesizey", "cameraheight", "videoheight"};
// Lists with the width first, as OpenCV's Size, PIL, Kalibr, okvis and OpenCV's articles (DIM) have it.
constexpr std::array<std::string_view, 22> kSizeWords = {"imagesize",
                                                         "imgsize",
                                                         "resolution",
                                                         "imageresolution",
                                                         "cameraresolution",
                                                         "size",
                                                         "s",
                                                         "dim",
                                                         "dims",
                                                         "dimension",
                                                         "dimensions",
                                                         "imagedim",
                                                         "imagedimension",
                                                         "imagedimensions",
                                                         "imgdim",
                                                         "calibdimension",
                                                         "framesize",
                                                         "picturesize",
                                                         "videosize",
                                                         "imagesizepx",
                                                         "wh",
                                                         "imagewh"};
// The shape of an array: NumPy has the height first, but scripts turn it around under the same name.
constexpr std::array<std::string_view, 6> kShapeWords = {"imageshape", "imgshape", "shape",
                                                         "frameshape", "hw",       "imagehw"};

// Maps that hold two sides among other things.
constexpr std::array<std::string_view, 6> kPictureWords = {"image", "img",   "picture",
                                                           "frame", "video", "images"};

std::optional<double> SideBehind(const LensNode& map, std::span<const std::string_view> words,
                                 const std::string& mark, const std::string& where) {
  const auto [key, node] =
      FindMarked(map, words, mark, where, [](const LensNode& value) { return value.IsText(); });
  if (!node) return std::nullopt;
  const auto value = LensNumber(*node);
  if (!value) throw Error("{}: '{}' must be a number, not '{}'", where, key, node->text.substr(0, 40));
  return value;
}

// The numbers of a list, a matrix, or a text such as 640x480.
std::vector<double> SidesIn(const LensNode& node, const std::string& key, const std::string& where) {
  if (node.IsMap()) return LensMatrixOf(node, key, where).numbers;
  LensNode plain = node;
  if (plain.IsText())
    std::ranges::replace_if(
        plain.text, [](char c) { return std::string_view("xX*,()").find(c) != std::string_view::npos; }, ' ');
  return LensNumbersIn(plain).value_or(std::vector<double>());
}

// Whether the principal point is that of a picture with these sides and not of one with them exchanged; none: of either.
std::optional<bool> FitsPrincipalPoint(const LensNumbers& numbers, double width, double height) {
  const double off = std::hypot(numbers.cx - 0.5 * width, numbers.cy - 0.5 * height),
               off_exchanged = std::hypot(numbers.cx - 0.5 * height, numbers.cy - 0.5 * width);
  constexpr double kClearly = 2;  // nearer to the one middle than to the other; guessed
  if (width == height || kClearly * off < off_exchanged) return true;
  if (kClearly * off_exchanged < off) return false;
  return std::nullopt;
}

// An array's shape names rows, columns and, where it has a third number, channels.
void SetSizeOfShape(const std::vector<double>& shape, const std::string& key, LensNumbers& numbers,
                    const std::string& where) {
  numbers.width = shape[1];
  numbers.height = shape[0];
  const auto fits = FitsPrincipalPoint(numbers, shape[1], shape[0]);
  if (fits == true || shape.size() > 2) return;
  if (!fits)
    throw Error(
        "{}: '{}: {:g}, {:g}' may be height and width, as arrays have it, or width and height, and the "
        "principal "
        "point tells neither; write {} instead",
        where, key, shape[0], shape[1], numbers.size_keys);
  std::swap(numbers.width, numbers.height);
  numbers.warnings.push_back(fmt::format(
      "{}: '{}: {:g}, {:g}' is taken as width and height, since the principal point is their middle", where,
      key, shape[0], shape[1]));
}

void RequireSides(const LensNumbers& numbers, const std::string& where) {
  // 0 is a size of nothing, not one that the file does not say.
  if (numbers.width == 0 && numbers.height == 0)
    throw Error("{}: the size of the pictures is 0x0; calibrate again", where);
}

// Two keys of the map. Returns whether they are there.
bool SetTwoSides(const LensNode& map, const std::string& mark, LensNumbers& numbers,
                 const std::string& where) {
  const auto width = SideBehind(map, kWidthWords, mark, where),
             height = SideBehind(map, kHeightWords, mark, where);
  if (!width || !height) return false;
  numbers.width = *width;
  numbers.height = *height;
  RequireSides(numbers, where);
  return true;
}

bool SetSizeOf(const LensNode& map, const std::string& mark, LensNumbers& numbers, const std::string& where) {
  if (SetTwoSides(map, mark, numbers, where)) return true;
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.items[i].IsMap() &&
        std::ranges::find(kPictureWords, LensWord(map.keys[i])) != kPictureWords.end() &&
        SetTwoSides(map.items[i], "", numbers, where))
      return true;
  const auto is_there = [](const LensNode& value) { return value.kind != LensNode::Kind::kNothing; };
  for (const bool is_shape : {false, true}) {
    const auto [key, node] = FindMarked(
        map, is_shape ? std::span<const std::string_view>(kShapeWords) : kSizeWords, mark, where, is_there);
    if (!node) continue;
    if (node->IsMap() && SetTwoSides(*node, "", numbers, where)) return true;
    if (node->Has("x") && node->Has("y")) {
      numbers.width = RequiredLensNumber(*node, "x", where);
      numbers.height = RequiredLensNumber(*node, "y", where);
      return true;
    }
    const std::vector<double> sides = SidesIn(*node, key, where);
    const bool is_size = sides.size() == 2 || (is_shape && sides.size() == 3);
    if (!is_size) {
      // These words are of a marker's or a board's length as well.
      const std::string word = LensWord(key);
      if (word == "s" || word == "size" || word.starts_with("dim") || word == "shape") continue;
      throw Error("{}: '{}' must be width and height, two numbers", where, key);
    }
    if (is_shape) {
      SetSizeOfShape(sides, key, numbers, where);
    } else {
      numbers.width = sides[0];
      numbers.height = sides[1];
    }
    RequireSides(numbers, where);
    return true;
  }
  return false;
}

}  // namespace

void ReadLensSize(const std::vector<const LensNode*>& maps, const std::string& mark, LensNumbers& numbers,
                  const std::string& where) {
  for (const LensNode* map : maps)
    for (const std::string& of : {mark, std::string()})
      if (SetSizeOf(*map, of, numbers, where)) return;
}

}  // namespace ulf::acquisition
