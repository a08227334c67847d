// Tests: render/stereo/swept_maps, commands/rendering/proxy_command, render/output/camera_path.
//
// Depth maps and pictures by the tasks of a real Slurm, started here with one node and two slots, with the
// scripts of docs/farm: one task of each array is killed, runs again, and the bytes are those of one process.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <thread>

#include "core/base/atomic_file.h"
#include "tests/support/child_process.h"
#include "tests/support/test_paths.h"

namespace ulf::test::farm_long_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::string Output(const std::string& command) {
  std::string output;
  FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return output;
  char part[4096];
  while (const std::size_t count = fread(part, 1, sizeof part, pipe)) output.append(part, count);
  pclose(pipe);
  return output;
}

// Empty: it is not installed.
std::string PathOf(const std::string& program) { return Output("command -v " + program + " | tr -d '\\n'"); }

// munged, slurmctld and slurmd, in one folder and on two ports of the loopback interface.
class Slurm {
 public:
  explicit Slurm(const fs::path& dir) : dir_(dir) {
    for (const char* folder : {"state", "spool"}) fs::create_directories(dir_ / folder);
    fs::permissions(dir_, fs::perms::owner_all);
    std::ofstream(dir_ / "munge.key", std::ios::binary) << std::string(1024, 'k');
    fs::permissions(dir_ / "munge.key", fs::perms::owner_read);
    const std::string host = Output("hostname -s | tr -d '\\n'"), at = dir_.string();
    const int port = 20000 + getpid() % 20000;
    std::ofstream(dir_ / "slurm.conf") << fmt::format(
        "ClusterName=ulf\nSlurmctldHost={0}(127.0.0.1)\nSlurmctldPort={1}\nSlurmdPort={2}\nSlurmUser=root\n"
        "SlurmdUser=root\nAuthType=auth/munge\nAuthInfo=socket={3}/munge.socket\nCredType=cred/munge\n"
        "StateSaveLocation={3}/state\nSlurmdSpoolDir={3}/spool\nSlurmctldPidFile={3}/slurmctld.pid\n"
        "SlurmdPidFile={3}/slurmd.pid\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/"
        "none\nMpiDefault=none\n"
        "SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nSwitchType=switch/"
        "none\nReturnToService=2\n"
        "JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/"
        "none\nSlurmdParameters="
        "config_overrides\nSchedulerParameters=requeue_setup_env_fail,sched_interval=2\nJobRequeue="
        "1\nMinJobAge=600\n"
        "SlurmctldLogFile={3}/slurmctld.log\nSlurmdLogFile={3}/slurmd.log\n"
        "NodeName={0} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\nPartitionName=all Nodes={0} Default=YES "
        "State=UP\n",
        host, port, port + 1, at);
    // It is loaded, and nothing above uses it: a container does not own its cgroups.
    std::ofstream(dir_ / "cgroup.conf") << "CgroupPlugin=cgroup/v1\n";
    setenv("SLURM_CONF", (dir_ / "slurm.conf").c_str(), 1);
    munged_.emplace(std::vector<std::string>{
        PathOf("munged"), "--foreground", "--force", "--num-threads=2", "--socket=" + at + "/munge.socket",
        "--key-file=" + at + "/munge.key", "--pid-file=" + at + "/munge.pid",
        "--seed-file=" + at + "/munge.seed", "--log-file=" + at + "/munge.log"});
    Wait([&] { return fs::exists(dir_ / "munge.socket"); });
    slurmctld_.emplace(std::vector<std::string>{PathOf("slurmctld"), "-D", "-c", "-f", at + "/slurm.conf"});
    slurmd_.emplace(std::vector<std::string>{PathOf("slurmd"), "-D", "-f", at + "/slurm.conf", "-N", host});
    is_up_ = Wait([] { return Output("sinfo -h -o %t").find("idle") == 0; });
  }
  ~Slurm() {
    // The tasks first: slurmd's own children outlive it.
    Output("scancel -u root");
    Wait([] { return Output("squeue -h").empty(); });
    for (auto* daemon : {&slurmd_, &slurmctld_, &munged_})
      if (*daemon) (*daemon)->Signal(SIGTERM), (*daemon)->Wait(10);
    unsetenv("SLURM_CONF");
  }
  Slurm(const Slurm&) = delete;
  Slurm& operator=(const Slurm&) = delete;
  bool is_up() const { return is_up_; }

  static bool Wait(const std::function<bool()>& done, double at_most_s = 60) {
    for (const auto start = Clock::now();
         std::chrono::duration<double>(Clock::now() - start).count() < at_most_s;) {
      if (done()) return true;
      std::this_thread::sleep_for(200ms);
    }
    return done();
  }

 private:
  fs::path dir_;
  std::optional<ChildProcess> munged_, slurmctld_, slurmd_;
  bool is_up_ = false;
};

// Processes of this computer whose command line holds both texts.
std::vector<pid_t> ProcessesWith(const std::string& one, const std::string& other) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    if (pid <= 0) continue;
    std::ifstream file(entry.path() / "cmdline");
    std::string line{std::istreambuf_iterator<char>(file), {}};
    std::replace(line.begin(), line.end(), '\0', ' ');
    std::error_code gone;
    if (line.find(one) != std::string::npos && line.find(other) != std::string::npos &&
        fs::read_symlink(entry.path() / "exe", gone).filename() == "ulf")
      found.push_back(pid);
  }
  return found;
}

std::map<std::string, std::string> Bytes(const fs::path& dir) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(dir))
    if (entry.is_regular_file() && entry.path().string().find("/cache/") == std::string::npos)
      bytes[entry.path().lexically_relative(dir).generic_string()] = ReadWholeFile(entry.path());
  return bytes;
}

// Submits, kills the program of the task whose command line holds `victim` once, and waits. How often
// the task began.
int RunAndKill(const std::string& submit, const fs::path& dir, const std::string& victim) {
  const std::string job = Output(submit);
  const int id = std::atoi(job.c_str());
  EXPECT_GT(id, 0) << job;
  bool killed = false;
  EXPECT_TRUE(Slurm::Wait(
      [&] {
        for (const pid_t pid : ProcessesWith(victim, dir.string())) killed = kill(pid, SIGKILL) == 0;
        return killed;
      },
      300))
      << "the task did not begin\n"
      << Output("squeue -l; sinfo -lN")
      << Output(fmt::format("cat {}/*.log {}/*.out | tail -40", dir.string(), dir.string()));
  // Slurm lets it wait for two minutes; what is tested does not need them.
  const std::string pending = fmt::format("squeue -h -r -j {} -t PD -o '%K %r' | grep '1 BeginTime'", id);
  EXPECT_TRUE(Slurm::Wait([&] { return !Output(pending).empty(); })) << "it did not go back to the queue";
  Output(fmt::format("scontrol update JobId={}_1 StartTime=now", id));
  const auto state = [&] { return Output(fmt::format("squeue -h -j {} -o %T", id)); };
  EXPECT_TRUE(
      Slurm::Wait([&] { return state().empty() || state().find("Invalid job") != std::string::npos; }, 900))
      << state();
  const std::string restarts = Output(fmt::format("scontrol show job {} | grep -o 'Restarts=[0-9]*'", id));
  const std::string ends =
      Output(fmt::format("scontrol show job {} | grep -o 'JobState=[A-Z]*' | sort -u", id));
  EXPECT_EQ(ends, "JobState=COMPLETED\n");
  EXPECT_THAT(restarts, testing::HasSubstr("Restarts=1"));
  fmt::print("{}: killed in mid-run, then\n{}", victim, restarts);
  return killed;
}

TEST(FarmLong, SlurmTasksGiveTheBytesOfOneProcess) {
  if (getuid() != 0) GTEST_SKIP() << "SKIPPED: slurmd starts tasks as root only";
  for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "sinfo"})
    if (PathOf(program).empty())
      GTEST_SKIP() << "SKIPPED: no " << program
                   << " here: apt-get install slurm-wlm munge, to test docs/farm.md";
  const ScratchFolder scratch;
  const fs::path farmed = scratch / "farmed", alone = scratch / "alone",
                 farm = fs::path(CHECKOUT) / "docs" / "farm";
  const auto captured =
      RunUlf("capture 'sim:studio?width=640&height=480&seed=21' -o " + alone.string() +
             " --headless --no-geometry --poses known --subject 0,0,0.07,0.17 --frames 260");
  ASSERT_EQ(captured.exit_code, 0) << captured.errors;
  fs::copy(alone, farmed, fs::copy_options::recursive);
  const std::string proxy_options = " --size 480 --depth-maps 16",
                    render_options =
                        " --path orbit --zoom 1 --width 480 "
                        "--proxy mesh --field subdivision --renderer reference";
  const auto mesh = RunUlf("proxy " + alone.string() + proxy_options);
  ASSERT_EQ(mesh.exit_code, 0) << mesh.errors;
  const auto pictures = RunUlf("render " + alone.string() + " -o " + (scratch / "alone_pictures").string() +
                               " --frames 16" + render_options);
  ASSERT_EQ(pictures.exit_code, 0) << pictures.errors;

  setenv("ULF_FARM", farm.c_str(), 1);
  setenv("PATH",
         (fs::path(std::getenv("ULF_BINARY")).parent_path().string() + ":" + std::getenv("PATH")).c_str(), 1);
  const fs::path dir = scratch / "slurm";
  fs::create_directories(dir);
  const Slurm slurm(dir);
  ASSERT_TRUE(slurm.is_up()) << Output("sinfo -lN; tail -30 " + dir.string() + "/*.log");
  const std::string submit =
      fmt::format("sbatch --parsable --array=0-3%2 --output={0}/%a.out ", dir.string());
  RunAndKill(submit + (farm / "depth_maps.sbatch").string() + " " + farmed.string() + " " +
                 (dir / "maps").string() + proxy_options,
             dir, "--maps-of 1/4");
  const auto fused =
      RunUlf("proxy " + farmed.string() + " --maps " + (dir / "maps").string() + proxy_options);
  ASSERT_EQ(fused.exit_code, 0) << fused.errors;
  EXPECT_TRUE(Bytes(farmed) == Bytes(alone)) << "mesh and depth maps";
  // The pictures' folder notes the light field by its files, not by its place.
  RunAndKill(submit + (farm / "pictures.sbatch").string() + " " + farmed.string() + " " +
                 (dir / "pictures").string() + " 16" + render_options,
             dir, "--frames 4:8/16");
  const auto mine = Bytes(scratch / "alone_pictures"), theirs = Bytes(dir / "pictures");
  int compared = 0;
  for (const auto& [name, bytes] : mine)
    if (name.ends_with(".png")) {
      EXPECT_TRUE(theirs.contains(name) && theirs.at(name) == bytes) << name;
      ++compared;
    }
  EXPECT_EQ(compared, 16);
}

}  // namespace
}  // namespace ulf::test::farm_long_test
