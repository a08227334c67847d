// The owner of a file descriptor or socket: closes it.
#pragma once

#include <unistd.h>

#include <utility>

namespace ulf {

class Descriptor {
 public:
  Descriptor() = default;
  // Takes over an open descriptor; -1: none.
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }

  int Number() const { return number_; }
  bool IsOpen() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

}  // namespace ulf
