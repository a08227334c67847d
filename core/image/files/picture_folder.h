// Lists the pictures of a folder, and describes other files that somebody put there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ulf {

struct PictureFolder {
  // Visible files with a picture's ending, sorted by name with numbers by value. A raw file with a picture of
  // the same name is left out.
  std::vector<std::filesystem::path> pictures;
  std::size_t others = 0;  // files
  // Clauses for people, each with a count and names: pictures of unread kinds, pictures without a picture's
  // ending, files that are no pictures (except notes and files that programs keep beside photographs),
  // folders with pictures.
  std::vector<std::string> left_out;
  // Returns the same in one line, for an error; empty if there is nothing.
  std::string LeftOut() const;
};

// Files and folders of the names `used` are not reported. Throws std::filesystem::filesystem_error if the
// folder cannot be read.
PictureFolder PicturesIn(const std::filesystem::path& folder, const std::set<std::string>& used = {});

// The first word that differs from the most frequent one (on a tie, from the first), and one that has it.
// Returns none if all are alike.
struct Mismatch {
  std::size_t odd = 0, usual = 0, usual_count = 0;
};
std::optional<Mismatch> FirstMismatch(const std::vector<std::string>& words);

// Lists up to three names: "a.jpg, b.jpg, ...".
std::string AbbreviatedList(const std::vector<std::string>& names);

}  // namespace ulf
