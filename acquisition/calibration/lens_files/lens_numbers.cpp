#include "acquisition/calibration/lens_files/lens_numbers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>

#include "acquisition/calibration/lens_files/marked_keys.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"

namespace ulf::acquisition {
namespace {

bool AreZeroFrom(const std::vector<double>& values, std::size_t first) {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(std::min(first, values.size())),
                     values.end(), [](double value) { return value == 0; });
}

int LensSide(double side, const LensNumbers& numbers, const std::string& where) {
  if (numbers.width == 0 && numbers.height == 0)
    throw Error("{}: the size of the pictures is missing, or zero; write it into the file ({})", where,
                numbers.size_keys);
  constexpr double kMostPx = 1 << 20;
  if (!(side >= 1 && side <= kMostPx) || side != std::floor(side))
    throw Error("{}: a size of {} x {} px; width and height are whole numbers from 1 to {:.0f}", where,
                numbers.width, numbers.height, kMostPx);
  return static_cast<int>(side);
}

// Returns the model by the word, else by the number of coefficients; with its warnings.
LensModel ModelOfNumbers(const LensNumbers& numbers, const std::string& where,
                         std::vector<std::string>& warnings) {
  const std::size_t count = numbers.coefficients.size();
  if (numbers.named) return numbers.named->model;
  const bool is_plain = AreZeroFrom(numbers.coefficients, 0);
  if (count == 4 && !is_plain) {
    warnings.push_back(fmt::format(
        "{}: four coefficients and no word for the model: they may be k1 k2 p1 p2 or a fisheye's "
        "k1 k2 k3 k4. Taken as k1 k2 p1 p2{}; if they are a fisheye's, add the line fisheye_model: 1 (or "
        "distortion_model: equidistant), if not, distortion_model: plumb_bob",
        where, numbers.is_ros ? ", plumb_bob, as ROS takes it" : ""));
  } else if (numbers.is_ros) {
    warnings.push_back(
        fmt::format("{}: no distortion_model; taken as plumb_bob, as ROS takes it. If the lens is a fisheye, "
                    "the file must say distortion_model: equidistant",
                    where));
  }
  if (count == 0) return LensModel::kNone;
  return count <= 5 ? LensModel::kRadialTangential : LensModel::kRational;
}

// Throws Error where the number of coefficients does not belong to the model.
void RequireCount(const LensNumbers& numbers, LensModel model, const std::string& where) {
  const std::vector<double>& d = numbers.coefficients;
  const std::string named = numbers.named ? " (" + numbers.named->named + ")" : "";
  const auto contradicts = [&](const char* name, const char* counts) {
    throw Error(
        "{}: a {} lens{} has {} coefficients, but there are {}; correct the model's word or the coefficients",
        where, name, named, counts, d.size());
  };
  switch (model) {
    case LensModel::kNone:
      if (!AreZeroFrom(d, 0))
        throw Error(
            "{}: a lens without distortion{} has {} coefficients that are not zero; correct one of the two",
            where, named, d.size());
      return;
    case LensModel::kFisheye:
      if (d.size() < 4 || !AreZeroFrom(d, 4)) contradicts("fisheye", "4");
      return;
    case LensModel::kRadialTangential:
      if (!d.empty() && (d.size() < 4 || !AreZeroFrom(d, 5))) contradicts("radial-tangential", "4 or 5");
      return;
    default:
      constexpr std::array<std::size_t, 3> kCounts = {8, 12, 14};
      if (std::ranges::find(kCounts, d.size()) == kCounts.end())
        throw Error(
            "{}: {} coefficients{}; a rational model has 8, 12 or 14, k1 k2 p1 p2 k3 are 4 or 5: correct the "
            "model's word or the coefficients",
            where, d.size(), named);
      if (!AreZeroFrom(d, 5))
        throw Error(
            "{}: a rational, thin prism or tilted model ({} coefficients, and those after the fifth are not "
            "zero); calibrate again without CALIB_RATIONAL_MODEL and similar flags: {}",
            where, d.size(), kLensWayOut);
  }
}

// Half of the difference of the sides off the middle, each axis towards the other's: the size was written
// height first, as arrays have it.
bool HasExchangedSides(const CameraModel& c) {
  const double off = std::hypot(c.cx - 0.5 * c.width, c.cy - 0.5 * c.height),
               off_exchanged = std::hypot(c.cx - 0.5 * c.height, c.cy - 0.5 * c.width);
  const double apart = std::abs(c.width - c.height) * 0.5 * std::sqrt(2.0);
  return apart > 0.05 * c.width && off_exchanged < 0.25 * apart && off > 0.75 * apart;
}

// Returns the number of "2", "cam2", "Camera 2"; -1: it is none.
int NumberOfCameraWord(const std::string& text) {
  std::string word = LensWord(text);
  for (const std::string_view name : {"camera", "cam"})
    if (word.starts_with(name)) word.erase(0, name.size());
  const bool is_number = !word.empty() && word.size() <= 6 &&
                         std::ranges::all_of(word, [](unsigned char c) { return std::isdigit(c) != 0; });
  return is_number ? std::stoi(word) : -1;
}

// Returns whether a name ends, after its last / or dot, in what is wanted.
bool EndsInCamera(const std::string& name, const std::string& wanted) {
  const std::string last = name.substr(name.find_last_of("/.") + 1);
  const int number = NumberOfCameraWord(wanted);
  return LensWord(last) == LensWord(wanted) || (number >= 0 && NumberOfCameraWord(last) == number);
}

// The words are written as LensWord() makes them. Rows and columns alone are a board's as well.
constexpr std::array<std::string_view, 13> kWidthWords = {
    "imagewidth", "imgwidth",    "width",     "w",          "widthpx",     "imagewidthpx", "imgw",
    "framewidth", "resolutionx", "imagecols", "imagesizex", "camerawidth", "videowidth"};
constexpr std::array<std::string_view, 13> kHeightWords = {
    "imageheight", "imgheight",   "height",    "h",          "heightpx",     "imageheightpx", "imgh",
    "frameheight", "resolutiony", "imagerows", "imagesizey", "cameraheight", "videoheight"};
// Lists with the width first, as OpenCV's Size, PIL, Kalibr, okvis and OpenCV's articles (DIM) have it.
constexpr auto kSizeWords = LensWordsIn<22>(
    "imagesize imgsize resolution imageresolution cameraresolution size s dim dims dimension dimensions "
    "imagedim imagedimension imagedimensions imgdim calibdimension framesize picturesize videosize "
    "imagesizepx wh imagewh");
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

// Returns the numbers of a list, a matrix, or a text such as 640x480.
std::vector<double> SidesIn(const LensNode& node, const std::string& key, const std::string& where) {
  if (node.IsMap()) return LensMatrixOf(node, key, where).numbers;
  LensNode plain = node;
  if (plain.IsText())
    std::ranges::replace_if(
        plain.text, [](char c) { return std::string_view("xX*,()").find(c) != std::string_view::npos; }, ' ');
  return LensNumbersIn(plain).value_or(std::vector<double>());
}

// Returns whether the principal point is that of a picture with these sides and not of one with them
// exchanged; none: of either.
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
        "principal point tells neither; write {} instead",
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

// Sets the size from two keys of the map. Returns whether they are there.
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

void SetCameraMatrix(LensNumbers& numbers, const LensMatrix& matrix, const std::string& key,
                     const std::string& where) {
  std::vector<double> k = matrix.numbers;
  const bool is_square = (matrix.rows == 3 && matrix.cols == 3) || (std::min(matrix.rows, matrix.cols) == 1);
  if (k.size() != 9 || !is_square)
    throw Error("{}: '{}' is no 3x3 camera matrix: it has {} x {} values", where, key, matrix.rows,
                matrix.cols);
  RequireFinite(k, key, where);
  if (AreZeroFrom(k, 0))
    throw Error(
        "{}: all values of '{}' are zero: the camera is not calibrated (ROS publishes such messages until it "
        "is); calibrate it, and take the file of that",
        where, key);
  if (k[2] == 0 && k[5] == 0 && k[8] == 1 && (k[6] != 0 || k[7] != 0)) {
    std::swap(k[1], k[3]);
    std::swap(k[2], k[6]);
    std::swap(k[5], k[7]);
    numbers.warnings.push_back(
        fmt::format("{}: '{}' has its columns first, as MATLAB and Open3D write it; taken so", where, key));
  }
  if (k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw Error(
        "{}: the last row of '{}' is {} {} {}, not 0 0 1; divide the matrix by its last value, or correct it",
        where, key, k[6], k[7], k[8]);
  if (k[3] != 0)
    throw Error("{}: '{}' has {} below its first focal length, where 0 belongs", where, key, k[3]);
  // Skew moves points by itself times their height over the focal length.
  constexpr double kNoSkew_px = 1e-3;
  if (std::abs(k[1]) > kNoSkew_px)
    throw Error("{}: '{}' has skew ({}), which ulf does not support; calibrate again with CALIB_FIX_SKEW",
                where, key, k[1]);
  numbers.fx = k[0];
  numbers.fy = k[4];
  numbers.cx = k[2];
  numbers.cy = k[5];
}

void RequireFinite(const std::vector<double>& values, const std::string& key, const std::string& where) {
  for (const double value : values)
    if (!std::isfinite(value))
      throw Error("{}: '{}' has a value that is not finite ({}); calibrate again or correct the file", where,
                  key, value);
}

std::string WarningOfNoCoefficients(const std::string& where) {
  return where + ": holds no distortion coefficients; taken as a lens without distortion";
}

Lens FinishedLens(const LensNumbers& numbers, const std::string& where) {
  Lens lens{.warnings = numbers.warnings};
  CameraModel& camera = lens.camera;
  camera.width = LensSide(numbers.width, numbers, where);
  camera.height = LensSide(numbers.height, numbers, where);
  const LensModel model = ModelOfNumbers(numbers, where, lens.warnings);
  RequireCount(numbers, model, where);
  const double half = numbers.from_corner ? 0 : 0.5;
  camera.fx = numbers.fx;
  camera.fy = numbers.fy;
  camera.cx = numbers.cx + half;
  camera.cy = numbers.cy + half;
  if (model == LensModel::kFisheye)
    camera.distortion = Distortion::kFisheye;
  else if (!AreZeroFrom(numbers.coefficients, 0))
    camera.distortion = Distortion::kRadialTangential;
  std::copy_n(numbers.coefficients.begin(), std::min<std::size_t>(5, numbers.coefficients.size()),
              camera.coefficients.begin());
  camera.Validate(where);
  CheckLensNumbers(lens, where);
  return lens;
}

void CheckLensNumbers(Lens& lens, const std::string& where) {
  const CameraModel& c = lens.camera;
  const double longest = std::max(c.width, c.height), focal = std::max(c.fx, c.fy);
  // The widest fisheyes see 280 degrees: with their circle inside a picture of 16:9 they have 0.115 of its
  // width.
  constexpr double kShortest = 0.1;
  if (focal < kShortest * longest)
    throw Error(
        "{}: focal lengths of {} and {} px with pictures of {}x{}; no lens has that: is it in millimetres or "
        "in widths of the picture? Write pixels",
        where, c.fx, c.fy, c.width, c.height);
  // No lens has its axis at a picture's corner to a pixel. Shifted lenses and parts of a sensor have it far
  // off the middle.
  constexpr double kCorner_px = 1.5, kLeastSide_px = 8;
  if (std::abs(c.cx) <= kCorner_px && std::abs(c.cy) <= kCorner_px && longest >= kLeastSide_px)
    throw Error(
        "{}: the principal point is in the corner of pictures of {}x{}: is it in parts of the picture, or "
        "from its middle? Write pixels from the upper left corner; the middle is {} {}",
        where, c.width, c.height, 0.5 * c.width, 0.5 * c.height);
  // The shortest lens that keeps lines straight has 9 mm for pictures 36 mm wide; the longest zooms have 83
  // widths.
  constexpr double kShortestStraight = 0.2, kLongest = 100;
  // Shares: as ulf calibrate warns; anamorphic lenses and old video have more.
  constexpr double kOffMiddle = 0.1, kUnequal = 1.2;
  if (focal < kShortestStraight * longest && c.distortion != Distortion::kFisheye)
    lens.warnings.push_back(fmt::format(
        "{}: a focal length of {:.6g} px is short for pictures of {}x{} without a fisheye: is "
        "that the size of the pictures from which the lens was found, and is the lens no fisheye?",
        where, focal, c.width, c.height));
  if (focal > kLongest * longest)
    lens.warnings.push_back(fmt::format(
        "{}: a focal length of {:.6g} px is that of a telescope with pictures of {}x{}: is it in pixels?",
        where, focal, c.width, c.height));
  if (!c.Contains({c.cx, c.cy}))
    lens.warnings.push_back(
        fmt::format("{}: the principal point ({:.1f}, {:.1f}) lies outside the picture of {}x{}: is that the "
                    "size of the pictures from which the lens was found?",
                    where, c.cx, c.cy, c.width, c.height));
  else if (HasExchangedSides(c))
    lens.warnings.push_back(fmt::format(
        "{}: the principal point ({:.1f}, {:.1f}) is the middle of a picture of {}x{}, not of {}x{}: are "
        "width and height exchanged?",
        where, c.cx, c.cy, c.height, c.width, c.width, c.height));
  else if (const double wide = std::abs(c.cx / c.width - 0.5), high = std::abs(c.cy / c.height - 0.5);
           std::max(wide, high) > kOffMiddle)
    lens.warnings.push_back(
        fmt::format("{}: the principal point ({:.1f}, {:.1f}) is {:.0f} % of the width and {:.0f} % of the "
                    "height from the middle of pictures of {}x{}, which hardly any lens has: are its numbers "
                    "whole and in their order, and is that the size of the pictures from which the lens was "
                    "found? It is right if these were cropped",
                    where, c.cx, c.cy, 100 * wide, 100 * high, c.width, c.height));
  if (const double ratio = focal / std::min(c.fx, c.fy); ratio > kUnequal)
    lens.warnings.push_back(
        fmt::format("{}: fx and fy, {:.6g} and {:.6g} px, differ by {:.0f} %, which they do not where pixels "
                    "are square: are the numbers in their order, and were the pictures not stretched?",
                    where, c.fx, c.fy, 100 * (ratio - 1)));
}

std::string PickLens(const std::vector<std::string>& names, const std::string& wanted,
                     const std::string& where, const std::vector<std::string>& topics) {
  if (names.empty()) throw Error("{}: contains no camera", where);
  if (wanted.empty() && names.size() == 1) return names[0];
  std::vector<std::string> list = names;
  for (std::size_t i = 0; i < topics.size(); ++i)
    if (!topics[i].empty()) list[i] += fmt::format(" {}", topics[i]);
  constexpr std::size_t kMostNamed = 12;
  if (list.size() > kMostNamed) {
    list.resize(kMostNamed);
    list.emplace_back("...");
  }
  if (wanted.empty())
    throw Error("{}: contains {} cameras ({}); extract one: ulf calibration {} --camera {} -o camera.json",
                where, names.size(), fmt::join(list, ", "), ShellWord(where), ShellWord(names[0]));
  for (const auto& words : {names, topics})
    for (std::size_t i = 0; i < words.size(); ++i)
      if (!words[i].empty() && LensWord(words[i]) == LensWord(wanted)) return names[i];
  std::vector<std::string> ending;
  std::ranges::copy_if(names, std::back_inserter(ending),
                       [&](const std::string& name) { return EndsInCamera(name, wanted); });
  if (ending.size() == 1) return ending[0];
  throw Error("{}: there is no camera '{}' (there {}: {})", where, wanted,
              names.size() == 1 ? "is only" : "are", fmt::join(list, ", "));
}

void RequireOnlyLens(const std::string& wanted, const std::string& where) {
  if (!wanted.empty() && NumberOfCameraWord(wanted) != 0)
    throw Error("{}: contains only one camera, which has no name; '{}' must be left out", where, wanted);
}

void ReadLensSize(const std::vector<const LensNode*>& maps, const std::string& mark, LensNumbers& numbers,
                  const std::string& where) {
  for (const LensNode* map : maps)
    for (const std::string& of : {mark, std::string()})
      if (SetSizeOf(*map, of, numbers, where)) return;
}

}  // namespace ulf::acquisition
