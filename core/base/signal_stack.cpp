#include "core/base/signal_stack.h"

#include <signal.h>

#include <cstddef>
#include <memory>

namespace ulf {
namespace {

constexpr std::size_t kBytes = 1 << 16;  // the crash handler needs a few KiB; guessed

class SignalStack {
 public:
  SignalStack() {
    stack_t before{};
    if (sigaltstack(nullptr, &before) != 0 || (before.ss_flags & SS_DISABLE) == 0) return;
    memory_ = std::make_unique_for_overwrite<std::byte[]>(kBytes);
    stack_t ours{};
    ours.ss_sp = memory_.get();
    ours.ss_size = kBytes;
    if (sigaltstack(&ours, nullptr) != 0) memory_.reset();
  }
  ~SignalStack() {
    if (!memory_) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
  }
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<std::byte[]> memory_;
};

}  // namespace

void InstallSignalStack() { static thread_local const SignalStack stack; }

}  // namespace ulf
