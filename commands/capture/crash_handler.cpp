#include "commands/capture/crash_handler.h"

#include <fmt/core.h>
#include <linux/close_range.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/base/signal_stack.h"
#include "core/light_field/light_field_io.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

constexpr char kCommand[] = "close-after-death";
// What a program that breaks gets, from the processor or from itself (GLib's fatal errors: SIGTRAP).
constexpr std::array kDeadly{SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGTRAP};

// Everything that is needed at death lies ready: there is no allocating then.
std::array<char, 4096> dying_dir;
std::array<char, 16> dying_signal, dying_thread;
std::array<struct sigaction, kDeadly.size()> before;

void Become(int signal) {
  dying_signal = {static_cast<char>('0' + signal / 10), static_cast<char>('0' + signal % 10), 0};
  prctl(PR_GET_NAME, dying_thread.data());
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  // The light field's lock goes with its descriptors.
  syscall(SYS_close_range, 3u, ~0u, 0u);
  char program[] = "/proc/self/exe", name[] = "ulf";
  char command[sizeof kCommand];
  std::memcpy(command, kCommand, sizeof kCommand);
  char* const arguments[] = {name,   command, dying_dir.data(), dying_signal.data(), dying_thread.data(),
                             nullptr};
  execv(program, arguments);
  ::signal(signal, SIG_DFL);
  raise(signal);
}

int CloseAfterDeath(const std::string& dir, int signal, const std::string& thread) {
  const std::string what = fmt::format("ulf: the capture died of signal {} ({}) in its thread '{}'", signal,
                                       strsignal(signal), thread);
  try {
    LightFieldWriter writer = LightFieldWriter::Resume(dir);
    const LightField& light_field = writer.Contents();
    double seconds = light_field.capture_s;
    if (!light_field.views.empty())
      seconds =
          std::max(seconds, light_field.views.back().device_time_s - light_field.views.front().device_time_s);
    writer.Close(seconds, writer.Contents().reasons);
    fmt::print(stderr, "{}; {} is closed with {}: go on with 'ulf capture ... -o {} --resume'\n", what, dir,
               Counted(light_field.views.size(), "view"), ShellWord(dir));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}, and {} could not be closed ({}); what was recorded is there, --resume goes on\n",
               what, dir, error.what());
  }
  return kFailed;
}

}  // namespace

CrashHandler::CrashHandler(const fs::path& dir) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const std::string text = fs::absolute(dir).string();
  if (text.size() >= dying_dir.size()) throw Error("{}: the path is too long", text);
  std::copy_n(text.c_str(), text.size() + 1, dying_dir.begin());
  InstallSignalStack();
  struct sigaction action {};
  action.sa_handler = Become;
  action.sa_flags = SA_ONSTACK | static_cast<int>(SA_RESETHAND);
  sigfillset(&action.sa_mask);
  for (std::size_t i = 0; i < kDeadly.size(); ++i) sigaction(kDeadly[i], &action, &before[i]);
#else
  static_cast<void>(dir);
#endif
}

CrashHandler::~CrashHandler() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  for (std::size_t i = 0; i < kDeadly.size(); ++i) sigaction(kDeadly[i], &before[i], nullptr);
#endif
}

void AddCloseAfterCrashCommand(CLI::App& app, ChosenCommand& chosen) {
  struct Args {
    std::string dir, thread;
    int signal = 0;
  };
  const auto args = std::make_shared<Args>();
  CLI::App* command = app.add_subcommand(kCommand, "What a capture turns into when it dies of a signal");
  command->group("");
  command->add_option("DIR", args->dir)->required();
  command->add_option("SIGNAL", args->signal)->required();
  command->add_option("THREAD", args->thread)->required();
  command->callback([&chosen, args] {
    chosen = [args] { return CloseAfterDeath(args->dir, args->signal, args->thread); };
  });
}

}  // namespace ulf::commands
