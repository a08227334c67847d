#include "acquisition/calibration/lens_files/lens_words.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <span>
#include <string_view>
#include <utility>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

enum class MentionedLens { kNone, kFisheye, kOther };

bool ContainsAny(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(),
                     [text](std::string_view word) { return text.find(word) != std::string_view::npos; });
}

// "omni" as the beginning of a word, and not of OmniVision, which makes sensors.
bool SpeaksOfOmni(const std::string& word, std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  for (std::size_t at = lower.find("omni"); at != std::string::npos; at = lower.find("omni", at + 1)) {
    const bool is_beginning = at == 0 || std::isalpha(static_cast<unsigned char>(lower[at - 1])) == 0;
    if (is_beginning && !std::string_view(lower).substr(at).starts_with("omnivision")) return true;
  }
  return ContainsAny(word, {"omnidir"});
}

MentionedLens LensMentionedIn(std::string_view text) {
  const std::string word = LensWord(text);
  if (SpeaksOfOmni(word, text) ||
      ContainsAny(word, {"doublesphere", "scaramuzza", "catadioptric", "equisolid", "thinprism"}))
    return MentionedLens::kOther;
  return ContainsAny(word, {"fisheye", "equidist", "kannala"}) ? MentionedLens::kFisheye
                                                               : MentionedLens::kNone;
}

bool IsKeyOfModel(const std::string& key) {
  return ContainsAny(LensWord(key), {"model", "type", "lens", "distort", "projection", "flag"});
}

bool EndsAsFile(std::string_view text) {
  const std::size_t dot = text.rfind('.');
  if (dot == std::string_view::npos || text.find(' ') != std::string_view::npos) return false;
  const std::string_view ending = text.substr(dot + 1);
  return ending.size() >= 2 && ending.size() <= 5 &&
         std::isalpha(static_cast<unsigned char>(ending.front())) != 0 &&
         std::ranges::all_of(ending, [](unsigned char c) { return std::isalnum(c) != 0; });
}

// Returns whether the text names a camera, a topic, a frame of coordinates, a file or a folder: users choose
// such names, so that they are no word for the model.
bool IsNameOrPlace(const std::string& key, std::string_view text) {
  const bool is_place = text.starts_with('/') || text.starts_with('~') || text.starts_with("./") ||
                        text.starts_with("../") || text.find("://") != std::string_view::npos ||
                        text.find('\\') != std::string_view::npos || EndsAsFile(text);
  if (is_place) return true;
  if (IsKeyOfModel(key)) return false;
  const std::string word = LensWord(key);
  return text.find('/') != std::string_view::npos || word == "id" || word.ends_with("id") || word == "ns" ||
         ContainsAny(word, {"name", "topic", "file", "path", "frame", "folder", "directory", "label", "title",
                            "serial", "url", "uri", "prefix"});
}

struct LensMention {
  std::string named = {};  // "camera_lens: fisheye"
  MentionedLens lens = MentionedLens::kNone;
  bool is_name = false;
};

// Reads 1, true, yes, on and their opposites; none for another word.
std::optional<bool> SwitchOf(const std::string& text) {
  const std::string word = LensWord(text);
  for (const std::string_view yes : {"1", "10", "true", "yes", "on"})
    if (word == yes) return true;
  for (const std::string_view no : {"0", "00", "false", "no", "off"})
    if (word == no) return false;
  return std::nullopt;
}

// Returns whether numbers below the key are a lens's, and not, say, the pose of a camera with this name.
bool AreNumbersOfLens(const std::string& key, const LensNode& value) {
  const std::string word = LensWord(key);
  if (IsKeyOfModel(key) || ContainsAny(word, {"param", "coef", "intrinsic", "calib"})) return true;
  if (value.IsMap())
    return std::ranges::any_of(value.keys, [](const std::string& inner) {
      const std::string name = LensWord(inner);
      return name == "k1" || name == "k2" || name == "d" || ContainsAny(name, {"coef", "dist"});
    });
  return word == "fisheye" || word == "equidistant" || word == "kannalabrandt" || word == "omni";
}

void FindMentions(const LensNode& node, const std::string& key, std::vector<LensMention>& mentions) {
  const MentionedLens by_key = LensMentionedIn(key);
  if (node.IsText()) {
    const std::string named = key + ": " + node.text.substr(0, 60);
    if (const MentionedLens lens = LensMentionedIn(node.text); lens != MentionedLens::kNone) {
      mentions.push_back({named, lens, IsNameOrPlace(key, node.text)});
      return;
    }
    const bool is_numbers = LensNumbersIn(node) && LensNumbersIn(node)->size() > 1;
    if (by_key != MentionedLens::kNone && (SwitchOf(node.text) == true || is_numbers))
      mentions.push_back({named, by_key, is_numbers ? !AreNumbersOfLens(key, node) : IsNameOrPlace(key, "")});
    return;
  }
  if (by_key != MentionedLens::kNone && node.kind != LensNode::Kind::kNothing && !node.items.empty() &&
      (node.IsMap() || LensNumbersIn(node)))
    mentions.push_back({key + ": ...", by_key, !AreNumbersOfLens(key, node)});
  if (LensNumbersIn(node)) return;  // a 1 in there is no switch
  for (std::size_t i = 0; i < node.items.size(); ++i)
    FindMentions(node.items[i], node.IsMap() ? node.keys[i] : key, mentions);
}

}  // namespace

const char* const kLensWayOut =
    "ulf has pinholes with k1 k2 p1 p2 k3 (plumb_bob, radtan) and fisheyes with k1 k2 k3 k4 of Kannala and "
    "Brandt (equidistant): calibrate again with one of them (Kalibr: pinhole-radtan, pinhole-equi; OpenCV: "
    "calibrateCamera, fisheye::calibrate), or with ulf calibrate";

namespace {

enum class WordMeaning { kProjectionOnly, kModel, kOther, kUnknown };

// The words are written as LensWord() makes them.
constexpr auto kNoDistortionWords = LensWordsIn<4>("none nodistortion undistorted rectified");
constexpr auto kRadialTangentialWords = LensWordsIn<12>(
    "plumbbob radtan radtan4 radtan5 pinholeradtan radialtangential opencvstandard brown "
    "brownconrady opencv opencv4 opencv5");
constexpr auto kRationalWords = LensWordsIn<8>(
    "rational rationalpolynomial radtan8 radialtangential8 pinholeradtan8 opencv8 fullopencv "
    "pinholefull");
constexpr auto kFisheyeWords = LensWordsIn<20>(
    "equidistant equidistant4 equi equidist pinholeequi pinholeequidistant equidistantfisheye "
    "fisheyeequidistant fisheye fisheye4 cvfisheye opencvfisheye fisheyeopencv pinholefisheye "
    "kannalabrandt kannalabrandt4 kannalabrandt8 kb kb4 kb8");
constexpr std::array kModelWords = {
    std::pair{LensModel::kNone, std::span<const std::string_view>(kNoDistortionWords)},
    std::pair{LensModel::kRadialTangential, std::span<const std::string_view>(kRadialTangentialWords)},
    std::pair{LensModel::kRational, std::span<const std::string_view>(kRationalWords)},
    std::pair{LensModel::kFisheye, std::span<const std::string_view>(kFisheyeWords)},
};

constexpr std::array<std::string_view, 6> kProjectionWords = {"pinhole",     "perspective", "frame",
                                                              "rectilinear", "standard",    "normal"};

// Models that ulf does not have, for keys that may be of anything else as well.
constexpr auto kOtherModels = LensWordsIn<42>(
    "omni omnidirectional omniradtan omnidir mei unified ucm eucm extendedunified catadioptric ds "
    "doublesphere scaramuzza ocam ocamcalib polynomial division ftheta thinprism thinprismfisheye "
    "radtanthinprismfisheye tilted fov atan equisolid equisolidfisheye stereographic orthographic "
    "equirectangular spherical panoramic cylindrical cylinder inversebrownconrady modifiedbrownconrady "
    "rational6kt fisheye62 fisheye624 cahvor cahvore splinedstereographic genericcamera");

WordMeaning MeaningOf(std::string_view word, LensModel& model) {
  if (std::ranges::find(kProjectionWords, word) != kProjectionWords.end())
    return WordMeaning::kProjectionOnly;
  for (const auto& [known, words] : kModelWords)
    if (std::ranges::find(words, word) != words.end()) {
      model = known;
      return WordMeaning::kModel;
    }
  return std::ranges::find(kOtherModels, word) != kOtherModels.end() ? WordMeaning::kOther
                                                                     : WordMeaning::kUnknown;
}

// Keys whose words are of models alone; and those that may be of anything, such as the camera's maker.
constexpr std::array<std::string_view, 17> kModelKeys = {
    "distortionmodel",  "distortiontype",  "cameramodel",     "modeltype",           "lensmodel",
    "lenstype",         "projectionmodel", "projectiontype",  "projection",          "distortion",
    "calibrationmodel", "intrinsicmodel",  "intrinsicsmodel", "intrinsicsmodeltype", "distmodel",
    "disttype",         "cameramodeltype"};
constexpr std::array<std::string_view, 5> kAnyKeys = {"model", "type", "cameratype", "lens", "modelname"};
constexpr std::array<std::string_view, 6> kFisheyeSwitches = {
    "fisheyemodel", "isfisheye", "fisheye", "usefisheye", "usefisheyemodel", "calibrateusefisheyemodel"};

template <std::size_t kCount>
bool IsOneOf(const std::array<std::string_view, kCount>& keys, std::string_view key) {
  return std::ranges::find(keys, key) != keys.end();
}

bool IsSame(LensModel a, LensModel b) {
  const auto is_polynomial = [](LensModel model) {
    return model == LensModel::kRadialTangential || model == LensModel::kRational;
  };
  return a == b || (is_polynomial(a) && is_polynomial(b));
}

}  // namespace

std::optional<NamedLensModel> LensModelOfWord(std::string_view text, const std::string& named,
                                              const std::string& where) {
  std::string word = LensWord(text);
  if (word.starts_with("distortion") && word.size() > 10) word.erase(0, 10);  // RealSense's distortion.none
  if (word.empty()) return std::nullopt;
  LensModel model = LensModel::kNone;
  switch (MeaningOf(word, model)) {
    case WordMeaning::kProjectionOnly:
      return std::nullopt;
    case WordMeaning::kModel:
      return NamedLensModel{model, named};
    case WordMeaning::kOther:
      throw Error("{}: the lens model '{}' ({}) is not one of ulf's; {}", where, text.substr(0, 60), named,
                  kLensWayOut);
    default:
      throw Error(
          "{}: the lens model '{}' ({}) is unknown to ulf; {}. If it is no lens model, delete the line",
          where, text.substr(0, 60), named, kLensWayOut);
  }
}

std::optional<NamedLensModel> NamedLensModelOf(const LensNode& map, const std::string& where) {
  std::optional<NamedLensModel> found;
  std::optional<NamedLensModel> no_fisheye;  // fisheye_model: 0
  const auto add = [&](const std::optional<NamedLensModel>& more) {
    if (!more) return;
    if (found && !IsSame(found->model, more->model))
      throw Error("{}: '{}' and '{}' contradict each other; correct the wrong one", where, found->named,
                  more->named);
    // Between radtan and rational the first remains.
    if (!found) found = more;
  };
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const LensNode& value = map.items[i];
    const std::string key = LensWord(map.keys[i]);
    if (key == "xi" && !value.IsMap())
      throw Error("{}: '{}' is the mirror's parameter of an omnidirectional lens model; {}", where,
                  map.keys[i], kLensWayOut);
    if (!value.IsText()) continue;
    const std::string named = map.keys[i] + ": " + value.text.substr(0, 60);
    if (IsOneOf(kFisheyeSwitches, key)) {
      const auto is_on = SwitchOf(value.text);
      if (!is_on)
        throw Error("{}: '{}' must be 1 or 0, not '{}'", where, map.keys[i], value.text.substr(0, 40));
      if (*is_on)
        add(NamedLensModel{LensModel::kFisheye, named});
      else
        no_fisheye = NamedLensModel{LensModel::kRadialTangential, named};
    } else if (IsOneOf(kModelKeys, key)) {
      // Some files have the coefficients, or the projection's matrix, under these keys.
      if ((key == "distortion" || key == "projection") && LensNumbersIn(value)) continue;
      // MC-Calib numbers its two models.
      if (key == "distortiontype" && map.Has("distortion_vector") && SwitchOf(value.text)) {
        add(NamedLensModel{*SwitchOf(value.text) ? LensModel::kFisheye : LensModel::kRadialTangential,
                           named});
        continue;
      }
      add(LensModelOfWord(value.text, named, where));
    } else if (IsOneOf(kAnyKeys, key)) {
      LensModel model = LensModel::kNone;
      std::string word = LensWord(value.text);
      if (word.starts_with("distortion")) word.erase(0, 10);
      const WordMeaning meaning = MeaningOf(word, model);
      if (meaning == WordMeaning::kModel || meaning == WordMeaning::kOther)
        add(LensModelOfWord(value.text, named, where));
    }
  }
  if (no_fisheye && found && found->model == LensModel::kFisheye)
    throw Error("{}: '{}' and '{}' contradict each other; correct the wrong one", where, no_fisheye->named,
                found->named);
  return found ? found : no_fisheye;
}

bool HasEmptyLensModel(const LensNode& map) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (LensWord(map.keys[i]) == "distortionmodel" &&
        (map.items[i].kind == LensNode::Kind::kNothing ||
         (map.items[i].IsText() && LensWord(map.items[i].text).empty())))
      return true;
  return false;
}

void CheckLensMentions(const LensNode& part, const std::optional<NamedLensModel>& named,
                       const std::string& lines, const std::string& where,
                       std::vector<std::string>& warnings) {
  std::vector<LensMention> mentions;
  FindMentions(part, "", mentions);
  for (const LensMention& mention : mentions) {
    if (named) {
      const bool agrees = named->model == LensModel::kFisheye && mention.lens == MentionedLens::kFisheye;
      if (!agrees && !mention.is_name)
        warnings.push_back(fmt::format("{}: '{}' speaks of another lens model than '{}', which decides",
                                       where, mention.named, named->named));
      continue;
    }
    if (!mention.is_name)
      throw Error(
          "{}: '{}' speaks of a lens model where ulf does not take its word, and no other line says the "
          "model. Add the line that is true of the coefficients: {}. For another model: {}",
          where, mention.named, lines, kLensWayOut);
    warnings.push_back(fmt::format(
        "{}: '{}' is taken as a name and not as the lens's model; if the lens is a fisheye, the file must "
        "say it: {}",
        where, mention.named, lines));
  }
}

}  // namespace ulf::acquisition
