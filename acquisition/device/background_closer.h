// Lets go of what is gone: closing a camera whose cable was pulled waits out every retry, seconds in all, and
// nobody should have to wait with it. What is given away here is closed in a thread of its own.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

namespace ulf::acquisition {

class BackgroundCloser {
 public:
  static BackgroundCloser& Instance();

  // Runs `work` soon, in another thread. At the end of the process it is waited for, but no longer than ten
  // seconds.
  void CloseInBackground(std::function<void()> work);
  // As CloseInBackground, for what is let go of by being destroyed: a unique_ptr, a shared_ptr.
  template <typename Owner>
  void CloseInBackground(Owner owner) requires(!std::is_invocable_v<Owner>) {
    if (!owner) return;
    // A std::function must be copyable, its owner need not be.
    auto held = std::make_shared<Owner>(std::move(owner));
    CloseInBackground(std::function<void()>([held] { held->reset(); }));
  }

 private:
  BackgroundCloser() = default;
};

}  // namespace ulf::acquisition
