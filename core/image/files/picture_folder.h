// The pictures of a folder, and in words what else somebody put there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace ulf {

struct PictureFolder {
  // Files by the ending of their name, hidden ones aside; by name, numbers by value. Of photographs that are
  // there as pictures and as raw files, the pictures alone.
  std::vector<std::filesystem::path> pictures;
  std::size_t others = 0;  // files
  // Clauses for people, each with a count and names: pictures of kinds that are not read, pictures whose
  // names do not say so, files that are no pictures (notes and what programs keep beside photographs aside),
  // folders that hold pictures.
  std::vector<std::string> left_out;
  // The same in one line, for an error; empty: nothing.
  std::string LeftOut() const;
};

// Files and folders of the names `used` are not left out. Throws std::filesystem::filesystem_error where the
// folder cannot be read.
PictureFolder PicturesIn(const std::filesystem::path& folder, const std::set<std::string>& used = {});

// The first of these words that is not the most frequent one (of as many of both, the first counts as usual),
// and one that is. None: all are alike.
struct OddOne {
  std::size_t odd = 0, usual = 0, usual_count = 0;
};
std::optional<OddOne> OddOneOut(const std::vector<std::string>& words);

// Up to three of them: "a.jpg, b.jpg, ...".
std::string SomeNames(const std::vector<std::string>& names);

}  // namespace ulf
