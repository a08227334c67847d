#include "acquisition/simulator/simulate_command.h"

#include <fmt/core.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/simulated_gige_camera.h"

namespace ulf {
namespace {

struct SimulateArgs {
  std::string scene = "studio", options, calibration_out;
  double fps = 0, duration_s = 0;
  std::int64_t seed = -1;
  GigeServerOptions server;
};

int RunSimulate(const SimulateArgs& args) {
  GigeServerOptions options = args.server;
  // What `sim:` URIs know is said here in the same words; the plain options win.
  std::string uri = "sim:" + args.scene;
  if (!args.options.empty()) uri += "?" + args.options;
  options.simulation = SimulationOptions::FromUri(DeviceUri::Parse(uri));
  if (args.fps != 0) options.simulation.fps = args.fps;
  if (args.seed >= 0) options.simulation.seed = static_cast<std::uint64_t>(args.seed);
  options.simulation.Validate();

  // Blocked before any thread starts, so that only the wait below sees them.
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);

  const SimulatedGigeCamera server(options);
  if (!args.calibration_out.empty())
    WriteCalibration(args.calibration_out, server.camera().camera(), options.serial,
                     "exact: the simulated camera of scene " + options.simulation.scene);
  fmt::print("serving aravis:{} at {}\n", server.DeviceId(), options.interface);
  std::fflush(stdout);

  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  while (args.duration_s <= 0 || elapsed_s() < args.duration_s) {
    const timespec moment{0, 50'000'000};
    if (sigtimedwait(&ends, nullptr, &moment) > 0) break;
  }
  const GigeServerStatistics statistics = server.Statistics();
  fmt::print("served {} frames ({} late) in {:.1f} s, {:.1f} ms to render one, hand at {:.1f} s\n",
             statistics.served, statistics.late, elapsed_s(), statistics.render_ms_mean, statistics.hand_s);
  return kOk;
}

}  // namespace

void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<SimulateArgs>();
  auto* sub = app.add_subcommand("simulate", "Serves the simulated camera as a real GigE Vision device");
  sub->add_option("scene", args->scene, "studio, or wall (flat)")->capture_default_str();
  sub->add_option("--interface", args->server.interface,
                  "IPv4 address of this machine to serve at; one camera each")
      ->capture_default_str();
  sub->add_option("--serial", args->server.serial, "Serial number, up to 15 characters")
      ->capture_default_str();
  sub->add_option("--poses", args->server.poses,
                  "Write every frame's exact pose here (TUM, frame ids as comments)");
  sub->add_option("--calibration-out", args->calibration_out, "Write the exact intrinsics here");
  sub->add_option("--fps", args->fps, "Frames per second (15)");
  sub->add_option("--seed", args->seed, "Seed of hand and noise (7)");
  sub->add_option("--duration-s", args->duration_s, "Stop by itself after so long");
  sub->add_option("--options", args->options,
                  "Further options as in sim: URIs, e.g. \"width=1280&height=960&cap=40x30\"");
  sub->footer(
      "Example: ulf simulate studio --calibration-out sim.json --poses truth.txt &\n"
      "         ulf capture aravis:ULF-ULF-SIM-1 --calibration sim.json -o studio --until-covered 60x40\n"
      "Runs until SIGINT or SIGTERM. Prints one line when it can be opened and one with figures at its end.");
  sub->callback([&chosen, args] { chosen = [args] { return RunSimulate(*args); }; });
}

}  // namespace ulf
