#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <cstdio>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "acquisition/simulator/scene/scene.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/stop_signal.h"
#include "core/base/waiting.h"

namespace ulf::commands {
namespace {

struct SimulateArgs {
  std::string scene = "studio", options, board;
  std::vector<std::string> interfaces{"127.0.0.1"}, serials, poses, calibrations, faults;
  std::vector<std::uint64_t> seeds;
  double fps = 0, duration_s = 0, line_hz = 10;
  int loop = 0;
};

// There is one value for each camera, or none at all.
template <typename T>
void RequireOneEach(const char* option, const std::vector<T>& values, std::size_t cameras) {
  if (!values.empty() && values.size() != cameras)
    throw UsageError("{} names {} for {} cameras; give one for each --interface, with commas between", option,
                     values.size(), cameras);
}

// Parses a `sim:` URI: a scene with a hand-held camera, or a board or card before the camera.
std::pair<acquisition::SimulationOptions, std::optional<acquisition::BoardSceneOptions>> SceneOf(
    const DeviceUri& uri) {
  if (uri.path != "board" && uri.path != "card")
    return {acquisition::SimulationOptions::FromUri(uri), std::nullopt};
  SensorWindow window;
  const acquisition::BoardSceneOptions board = acquisition::BoardSceneFromUri(uri, window);
  acquisition::SimulationOptions simulation;
  simulation.scene = uri.path;
  simulation.width = board.camera.width;
  simulation.height = board.camera.height;
  simulation.seed = board.seed;
  simulation.fps = uri.Number("fps", simulation.fps, 1, 1000);
  return {simulation, board};
}

// Returns the options of each camera of the command line.
std::vector<acquisition::GigeServerOptions> CamerasOf(const SimulateArgs& args) {
  const std::size_t count = args.interfaces.size();
  RequireOneEach("--serial", args.serials, count);
  RequireOneEach("--seed", args.seeds, count);
  RequireOneEach("--poses", args.poses, count);
  RequireOneEach("--calibration-out", args.calibrations, count);
  // --options takes options of `sim:` URIs; the command's own options take precedence.
  std::string uri = "sim:" + (args.board.empty() ? args.scene : "board");
  if (!args.options.empty()) uri += "?" + args.options;
  if (!args.board.empty()) uri += fmt::format("{}board={}", args.options.empty() ? "?" : "&", args.board);
  const auto [simulation_of_uri, board] = SceneOf(DeviceUri::Parse(uri));
  acquisition::SimulationOptions simulation = simulation_of_uri;
  if (args.fps != 0) simulation.fps = args.fps;
  for (const std::string& fault : args.faults) simulation.faults.Add(fault);
  std::vector<acquisition::GigeServerOptions> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    acquisition::GigeServerOptions camera{
        .simulation = simulation,
        .board = board,
        .interface = args.interfaces[i],
        .serial = args.serials.empty() ? fmt::format("ULF-SIM-{}", i + 1) : args.serials[i],
        .poses = args.poses.empty() ? "" : args.poses[i],
        .line_hz = args.line_hz,
        .loop = args.loop};
    camera.simulation.seed = args.seeds.empty() ? simulation.seed + i : args.seeds[i];
    camera.simulation.Validate();
    if (camera.board) camera.board->seed = camera.simulation.seed;
    cameras.push_back(camera);
  }
  return cameras;
}

std::string Describe(const acquisition::GigeRelayStatistics& link) {
  return fmt::format("; link: {}, {} lost, {} doubled, {} swapped, {} asked again in {}, {}",
                     Counted(link.packets, "packet"), link.lost, link.doubled, link.swapped, link.resent,
                     Counted(link.resend_requests, "request"), Counted(link.late_frames, "late frame"));
}

int RunSimulate(const SimulateArgs& args) {
  const std::vector<acquisition::GigeServerOptions> cameras = CamerasOf(args);

  // Blocks the signals before any thread starts, so that only the wait below receives them.
  sigset_t ends;
  sigemptyset(&ends);
  for (const int signal : StopSignals()) sigaddset(&ends, signal);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);

  std::vector<std::unique_ptr<acquisition::SimulatedGigeCamera>> servers;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    std::optional<Waiting> waiting(std::in_place, "simulate",
                                   args.loop > 0 ? "the scene, and the pictures of the loop" : "the scene");
    const auto& server = servers.emplace_back(std::make_unique<acquisition::SimulatedGigeCamera>(cameras[i]));
    waiting.reset();
    if (!args.calibrations.empty())
      acquisition::WriteCalibration(args.calibrations[i], server->StoredCamera(), cameras[i].serial,
                                    "exact: the simulated camera of scene " + cameras[i].simulation.scene);
    fmt::print("serving aravis:{} at {}\n", server->DeviceId(), cameras[i].interface);
    std::fflush(stdout);
  }

  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] { return SecondsSince(begin); };
  while (args.duration_s <= 0 || elapsed_s() < args.duration_s) {
    const timespec moment{0, 50'000'000};
    if (sigtimedwait(&ends, nullptr, &moment) > 0) break;
  }
  int exit_code = kOk;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const acquisition::GigeServerStatistics statistics = servers[i]->Statistics();
    fmt::print(
        "{}served {} ({} late) in {:.1f} s, {:.1f} ms to render one, hand at {:.1f} s{}{}\n",
        cameras.size() == 1 ? "" : cameras[i].serial + ": ", Counted(statistics.served, "frame"),
        statistics.late, elapsed_s(), statistics.render_ms_mean, statistics.hand_s,
        statistics.refused == 0 ? "" : fmt::format("; {} refused", Counted(statistics.refused, "request")),
        servers[i]->relay() ? Describe(servers[i]->relay()->Statistics()) : "");
    if (statistics.unwritten_poses == 0) continue;
    fmt::print(stderr, "ulf: {}: {} could not be written; check the disk's room\n", args.poses[i],
               Counted(statistics.unwritten_poses, "pose"));
    exit_code = kFailed;
  }
  return exit_code;
}

}  // namespace

void AddSimulateCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [sub, args] = NewSubcommand(
      app, chosen, "simulate", "Serves the simulated camera as a real GigE Vision device", RunSimulate);
  sub->add_option("scene", args->scene,
                  fmt::format("Scene: {}, board or card (docs/devices.md)",
                              fmt::join(acquisition::Scene::Names(), ", ")))
      ->capture_default_str();
  sub->add_option("--board", args->board,
                  "Hold a board before the camera, as `ulf board` prints it, to practise ulf calibrate; "
                  "--options are then those of sim:board, such as \"lens=wide\"");
  sub->add_option("--interface", args->interfaces,
                  "IPv4 addresses of this machine, separated by commas; one camera each")
      ->delimiter(',')
      ->capture_default_str();
  sub->add_option("--serial", args->serials,
                  "Serial numbers, up to 15 characters (default: ULF-SIM-1, ULF-SIM-2, ...)")
      ->delimiter(',');
  sub->add_option("--poses", args->poses,
                  "Write the exact pose of every frame to this file (TUM format, frame ids as comments); one "
                  "per camera")
      ->delimiter(',');
  sub->add_option("--calibration-out", args->calibrations,
                  "Write the exact intrinsics to this file; one per camera")
      ->delimiter(',');
  sub->add_option("--fps", args->fps, "Frames per second (default: 15)");
  sub->add_option("--seed", args->seeds, "Seeds of hand and noise, one per camera (default: 7, 8, ...)")
      ->delimiter(',');
  sub->add_option("--loop", args->loop,
                  "Render so many pictures at the start and play them forwards and backwards, at any frame "
                  "rate (default: render every frame)");
  sub->add_option("--line-hz", args->line_hz, "Pulses per second on Line0, the input of the hardware trigger")
      ->capture_default_str();
  sub->add_option("--fault", args->faults,
                  "Simulate a fault, may be repeated (default: none): lost=SHARE doubled=SHARE swapped=SHARE "
                  "resend=0 late=MS:SHARE freeze=AT:SECONDS disconnect=AT:SECONDS drift=STOPS_PER_MINUTE")
      ->delimiter(',');
  sub->add_option("--duration-s", args->duration_s, "Stop after so many seconds (default: no limit)")
      ->check(Positive());
  sub->add_option("--options", args->options,
                  "Further options of sim: URIs, such as \"width=1280&height=960&cap=40x30\"");
  sub->footer(
      "Example: ulf simulate studio --calibration-out sim.json --poses truth.txt &\n"
      "         ulf capture aravis:ULF-ULF-SIM-1 --calibration sim.json -o studio --until-covered 60x40\n"
      "         ulf simulate --board charuco:7x5:30:22:DICT_5X5_100 &\n"
      "         ulf calibrate aravis:ULF-ULF-SIM-1 -o sim.json\n"
      "         ulf simulate --interface 127.0.0.1,127.0.0.2 --fault lost=0.005 --fault disconnect=20:3\n"
      "Runs until SIGINT, SIGTERM or SIGHUP. Prints a line for each camera when it can be opened and one "
      "with figures at its end. Seconds of faults count from the first frame taken.");
}

}  // namespace ulf::commands
