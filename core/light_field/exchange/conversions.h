// What ulf converts when it reads photographs of a light field, whose files stay as they came: other programs
// see other numbers.
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
// Of the first photograph of each kind and size of file: others of it are like it. Raw files and files that
// cannot be read are passed over.
std::vector<Conversion> ConversionsOf(const LightField& light_field);

// Photographs that are copied as they are, although ulf takes them otherwise than by their numbers.
class CopiedMeanings {
 public:
  void Add(const StoredPicture& picture);
  // For the report of the copy, with counts; empty: all are sRGB and stand as they are.
  std::string Doubt(std::size_t copied) const;

 private:
  std::size_t photographs_ = 0;
  std::map<std::string, std::size_t> counts_;  // by what they mean
};

}  // namespace ulf
