// Reports what ulf converts when it reads photographs of a light field. The files stay unchanged, so other
// programs see other numbers.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/image/files/stored_picture.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct Conversion {
  std::filesystem::path file;
  std::string words;  // a note or remark of stored_picture.h
};
// Reads the first photograph of each extension and size, assuming that others are like it. Raw files and
// unreadable files are ignored.
std::vector<Conversion> ConversionsOf(const LightField& light_field);

// Counts photographs that are copied unchanged although ulf converts them when it reads them.
class CopiedColorEncodings {
 public:
  // Notes a copied photograph.
  void Add(const StoredPicture& picture);
  // Returns a sentence for the report of the copy, with counts; empty if all are plain sRGB.
  std::string Doubt(std::size_t copied) const;

 private:
  std::size_t photographs_ = 0;
  std::map<std::string, std::size_t> counts_;  // by the encoding of their colours
  bool are_all_tagged_ = true;
};

}  // namespace ulf
