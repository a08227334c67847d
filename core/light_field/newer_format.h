// A light field by a newer ulf. Nothing is wrong with it, and this program neither reads nor changes it.
#pragma once

#include "core/base/error.h"

namespace ulf {

class NewerFormatError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
