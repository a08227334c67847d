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
#include "core/base/stop_signal.h"
#include "core/light_field/folder/light_field_writer.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

constexpr char kCommand[] = "close-after-death";
// These signals are crashes, including GLib's fatal errors (SIGTRAP).
constexpr std::array kFatalSignals{SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGTRAP};

// It is static, because a signal handler must not allocate.
std::array<char, 4096> light_field_dir;
std::array<char, 16> signal_number, thread_name;
std::array<struct sigaction, kFatalSignals.size()> earlier_actions;

void ReplaceProcess(int signal) {
  signal_number = {static_cast<char>('0' + signal / 10), static_cast<char>('0' + signal % 10), 0};
  prctl(PR_GET_NAME, thread_name.data());
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  // Closing all descriptors releases the light field's lock.
  syscall(SYS_close_range, 3u, ~0u, 0u);
  char program[] = "/proc/self/exe", name[] = "ulf";
  char command[sizeof kCommand];
  std::memcpy(command, kCommand, sizeof kCommand);
  char* const arguments[] = {
      name, command, light_field_dir.data(), signal_number.data(), thread_name.data(), nullptr};
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
    fmt::print(stderr,
               "{}, and {} could not be closed ({}); the recorded views are there, --resume goes on\n", what,
               dir, error.what());
  }
  return kFailed;
}

}  // namespace

CrashHandler::CrashHandler(const fs::path& dir) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const std::string text = fs::absolute(dir).string();
  if (text.size() >= light_field_dir.size()) throw Error("{}: the path is too long", text);
  std::copy_n(text.c_str(), text.size() + 1, light_field_dir.begin());
  InstallSignalStack();
  struct sigaction action {};
  action.sa_handler = ReplaceProcess;
  action.sa_flags = SA_ONSTACK | static_cast<int>(SA_RESETHAND);
  sigfillset(&action.sa_mask);
  for (std::size_t i = 0; i < kFatalSignals.size(); ++i)
    sigaction(kFatalSignals[i], &action, &earlier_actions[i]);
#else
  static_cast<void>(dir);
#endif
}

CrashHandler::~CrashHandler() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  for (std::size_t i = 0; i < kFatalSignals.size(); ++i)
    sigaction(kFatalSignals[i], &earlier_actions[i], nullptr);
#endif
}

void AddCloseAfterCrashCommand(CLI::App& app, ChosenCommand& chosen) {
  struct Args {
    std::string dir, thread;
    int signal = 0;
  };
  const auto args = std::make_shared<Args>();
  CLI::App* command =
      app.add_subcommand(kCommand, "Closes the light field of a capture that died of a signal");
  command->group("");
  command->add_option("DIR", args->dir)->required();
  command->add_option("SIGNAL", args->signal)->required();
  command->add_option("THREAD", args->thread)->required();
  command->callback([&chosen, args] {
    chosen = [args] { return CloseAfterDeath(args->dir, args->signal, args->thread); };
  });
}

}  // namespace ulf::commands
