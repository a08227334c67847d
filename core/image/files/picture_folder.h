// Lists the pictures of a folder, and describes the files and folders in it that are left out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ulf {

struct PictureFolder {
  // Paths of the files that are not hidden and have a picture's extension (HasImageEnding()), in NameOrder().
  // A camera's raw file is left out if there is another picture of the same name but for the extension.
  std::vector<std::filesystem::path> pictures;
  std::size_t others = 0;  // number of other files, also hidden ones and text files
  bool is_empty = true;    // holds neither files nor folders
  // Clauses for messages, each with a count: pictures of each kind that ulf does not read, pictures without a
  // picture's extension, files that are no pictures (except text files and what programs keep beside
  // photographs), and folders inside that hold pictures. The last three kinds name some files.
  std::vector<std::string> left_out;
  // Returns `left_out` in one line, joined by "; ".
  std::string LeftOut() const;
};

// Lists a folder without those inside it. `used` are names of files and folders that `left_out` omits,
// because the caller knows them. Throws std::filesystem::filesystem_error if the folder cannot be read.
PictureFolder PicturesIn(const std::filesystem::path& folder, const std::set<std::string>& used = {});

// Throws the Error of a folder without pictures, which says what it holds. `path` names the folder.
[[noreturn]] void RefuseWithoutPictures(const std::string& path, const PictureFolder& folder);

struct Mismatch {
  std::size_t odd = 0;          // index of the first word that differs from the most frequent one
  std::size_t usual = 0;        // index of the first word that equals the most frequent one
  std::size_t usual_count = 0;  // how often that occurs
};
// Finds the first word that differs from the most frequent one (of equally frequent ones, the first), to say
// which of many pictures has another size. Returns none if all words are equal.
std::optional<Mismatch> FirstMismatch(const std::vector<std::string>& words);

// Lists the first three names: "a.jpg, b.jpg, c.jpg, ..."; without dots if there are no more.
std::string AbbreviatedList(const std::vector<std::string>& names);

}  // namespace ulf
