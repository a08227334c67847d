// `overrun_capture DIR THREAD`: a capture of DIR that runs out of stack, in its main thread or in another one
// ("main", "other"). Like `ulf` it can be what a capture turns into when it dies.
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <string>
#include <thread>

#include "commands/capture/crash_handler.h"
#include "core/base/stop_signal.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"

namespace {

// Without end, in a way that no compiler sees.
int Overrun(const volatile char* above) {
  volatile char room[512];
  room[0] = *above;
  return room[0] == 0 ? 0 : Overrun(room) + room[0];
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app;
  ulf::ChosenCommand chosen;
  ulf::AddCloseAfterCrashCommand(app, chosen);
  std::string dir, thread;
  app.add_option("DIR", dir);
  app.add_option("THREAD", thread);
  CLI11_PARSE(app, argc, argv);
  if (chosen) return chosen();
  const ulf::LightFieldWriter writer = ulf::LightFieldWriter::Resume(dir);
  const ulf::CrashHandler guard(dir);
  const volatile char goes_on = 1;
  if (thread == "main") return Overrun(&goes_on);
  std::thread([&] {
    ulf::InstallSignalStack();
    prctl(PR_SET_NAME, "overrun");
    Overrun(&goes_on);
  }).join();
  return 3;  // it came back
}
