#include "acquisition/calibration/lens_files/lens_mentions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string_view>

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

// Of a camera, a topic, a frame of coordinates, a file or a folder: chosen by somebody, and no word for the model.
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
  std::string said = {};  // "camera_lens: fisheye"
  MentionedLens lens = MentionedLens::kNone;
  bool is_name = false;
};

bool IsSwitch(std::string_view text, std::initializer_list<std::string_view> words) {
  const std::string word = LensWord(text);
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Whether numbers below the key are a lens's, and not, say, the pose of a camera with this name.
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
    const std::string said = key + ": " + node.text.substr(0, 60);
    if (const MentionedLens lens = LensMentionedIn(node.text); lens != MentionedLens::kNone) {
      mentions.push_back({said, lens, IsNameOrPlace(key, node.text)});
      return;
    }
    const bool is_numbers = LensNumbersIn(node) && LensNumbersIn(node)->size() > 1;
    if (by_key != MentionedLens::kNone &&
        (IsSwitch(node.text, {"1", "10", "true", "yes", "on"}) || is_numbers))
      mentions.push_back({said, by_key, is_numbers ? !AreNumbersOfLens(key, node) : IsNameOrPlace(key, "")});
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

void CheckLensMentions(const LensNode& part, const std::optional<SaidLensModel>& said,
                       const std::string& lines, const std::string& where,
                       std::vector<std::string>& warnings) {
  std::vector<LensMention> mentions;
  FindMentions(part, "", mentions);
  for (const LensMention& mention : mentions) {
    if (said) {
      const bool agrees = said->model == LensModel::kFisheye && mention.lens == MentionedLens::kFisheye;
      if (!agrees && !mention.is_name)
        warnings.push_back(fmt::format("{}: '{}' speaks of another lens model than '{}', which decides",
                                       where, mention.said, said->said));
      continue;
    }
    if (!mention.is_name)
      throw Error(
          "{}: '{}' speaks of a lens model where ulf does not take its word, and no other line says the "
          "model. Add the line that is true of the coefficients: {}. For another model: {}",
          where, mention.said, lines, kLensWayOut);
    warnings.push_back(fmt::format(
        "{}: '{}' is taken as a name and not as the lens's model; if the lens is a fisheye, the file must "
        "say it: {}",
        where, mention.said, lines));
  }
}

}  // namespace ulf::acquisition
