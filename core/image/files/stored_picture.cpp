#include "core/image/files/stored_picture.h"

#include <array>
#include <cctype>

namespace ulf {

std::string WithoutNumbers(const std::string& sentence) {
  std::string words;
  bool is_in_number = false;
  for (char before = ' '; const char c : sentence) {
    const auto is = [](int (*kind)(int), char of) { return kind(static_cast<unsigned char>(of)) != 0; };
    if (is(std::isdigit, c) && !is(std::isalnum, before)) is_in_number = true;
    if (is(std::isspace, c) || c == ',' || c == ')' || c == ';') is_in_number = false;
    if (!is_in_number) words += c;
    before = c;
  }
  return words;
}

void NoteOrientation(int orientation, StoredPicture& picture) {
  constexpr std::array kWords = {"mirrored",
                                 "turned by 180 degrees",
                                 "turned by 180 degrees and mirrored",
                                 "turned by 90 degrees and mirrored",
                                 "turned by 90 degrees clockwise",
                                 "turned by 90 degrees clockwise and mirrored",
                                 "turned by 90 degrees counterclockwise"};
  constexpr int kFirst = 2;
  if (orientation < kFirst || orientation >= kFirst + static_cast<int>(kWords.size())) return;
  picture.notes.push_back(
      std::string("its mark says that it is shown ") +
      kWords[static_cast<std::size_t>(orientation - kFirst)] +
      ": its pixels stay in the order of the file, for which the camera's calibration holds");
}

}  // namespace ulf
