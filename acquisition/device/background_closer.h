// Closes lost cameras in separate threads: a library takes seconds to close one whose cable was pulled.
#pragma once

#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

namespace ulf::acquisition {

// Runs `work` in another thread. The end of the process waits for it, up to ten seconds.
void CloseInBackground(std::function<void()> work);
// Destroys what `owner` (a unique_ptr or shared_ptr) holds in the same way.
template <typename Owner>
void CloseInBackground(Owner owner) requires(!std::is_invocable_v<Owner>) {
  if (!owner) return;
  // A std::function must be copyable, which a unique_ptr is not.
  auto held = std::make_shared<Owner>(std::move(owner));
  CloseInBackground(std::function<void()>([held] { held->reset(); }));
}

}  // namespace ulf::acquisition
