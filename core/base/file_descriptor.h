// Owns a file descriptor or socket and closes it.
#pragma once

#include <unistd.h>

#include <utility>

namespace ulf {

class FileDescriptor {
 public:
  FileDescriptor() = default;
  // Takes over an open descriptor; -1 stands for none.
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~FileDescriptor() {
    if (number_ >= 0) close(number_);
  }

  int Number() const { return number_; }
  bool IsOpen() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

}  // namespace ulf
