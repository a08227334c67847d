// Tests: core/base/quantile, core/base/counted, core/base/json_text, core/base/lowercase,
// core/base/shell_word, core/base/at, core/base/model_choice, core/base/parallel_for,
// core/base/output_path, core/base/progress, core/base/stop_signal, core/geometry/silent_solver,
// core/base/available_memory, core/base/host_time, core/base/stage_times, core/base/device_uri,
// core/base/error, core/base/mutex, core/base/json_fields, core/base/waiting, core/base/file_descriptor.
#include <gmock/gmock.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <barrier>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/base/at.h"
#include "core/base/available_memory.h"
#include "core/base/counted.h"
#include "core/base/device_uri.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/base/lowercase.h"
#include "core/base/model_choice.h"
#include "core/base/mutex.h"
#include "core/base/output_path.h"
#include "core/base/parallel_for.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/base/stage_times.h"
#include "core/base/stop_signal.h"
#include "core/base/waiting.h"
#include "core/geometry/silent_solver.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::base_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

TEST(Quantile, IsTheValueOfTheNearestRank) {
  EXPECT_EQ(Quantile({5, 1, 4, 2, 3}, 0), 1);
  EXPECT_EQ(Quantile({5, 1, 4, 2, 3}, 0.9), 5);
  EXPECT_EQ(Quantile({5, 1, 4, 2, 3}, 1), 5);
  EXPECT_EQ(Median({5, 1, 4, 2, 3}), 3);
  EXPECT_EQ(Median({4, 1, 3, 2}), 3) << "the upper one of the two in the middle";
  EXPECT_EQ(Median({}), 0);
}

TEST(ParallelForTest, CallsEachIndexOnce) {
  for (const std::size_t count : {0u, 1u, 7u, 1000u})
    for (const double stripes : {0.0, 3.0}) {
      std::vector<std::atomic<int>> calls(count);
      ParallelFor(
          count, [&](std::size_t i) { ++calls[i]; }, stripes);
      for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(calls[i], 1) << i << " of " << count;
    }
}

TEST(Texts, NumbersNamesAndCommandsAreWrittenForPeople) {
  EXPECT_EQ(Counted(1, "view"), "1 view");
  EXPECT_EQ(Counted(0, "view"), "0 views");
  EXPECT_EQ(Lowercase("DSC_0001.JPG"), "dsc_0001.jpg");
  EXPECT_EQ(Lowercase("\xC3\x84"), "\xC3\x84") << "bytes of other scripts stay";
  EXPECT_EQ(ShellWord("vase/journal.jsonl"), "vase/journal.jsonl");
  EXPECT_EQ(ShellWord("my vase"), "\"my vase\"");
  EXPECT_EQ(ShellWord("5$"), "\"5\\$\"");
  EXPECT_EQ(ShellWord(""), "\"\"");
  EXPECT_EQ(ShellWord("wow!"), "'wow!'");
  EXPECT_EQ(ShellWord("it's $5!"), R"('it'\''s $5!')");
  const Error error("{} is missing", "journal.jsonl");
  EXPECT_STREQ(error.what(), "journal.jsonl is missing");
}

TEST(ModelChoiceText, MarksTheChosenCandidate) {
  const ModelChoice choice{"lens", "least error", {{"pinhole", "2.0 px"}, {"radial", "0.2 px", true}}};
  EXPECT_EQ(ToText(choice), "lens: least error\n  pinhole  2.0 px\n* radial   0.2 px\n");
  const auto json = ToJson(choice);
  EXPECT_EQ(json["candidates"][0]["chosen"], false);
  EXPECT_EQ(json["candidates"][1]["evidence"], "0.2 px");
}

TEST(JsonText, ErrorsNameLineColumnAndTheReason) {
  EXPECT_EQ(ParseJson("{\"a\": [1, 2]}", "a.json", "copy it again")["a"][1], 2);
  const std::vector<std::pair<std::string, std::string>> damaged{
      {"broken\n", "line 1, column 1: not valid JSON: 'broken' cannot stand here"},
      {"\xff\xfe{\0}", "not valid JSON: it is text in UTF-16"},
      {"[1,\n 2,\n]", "line 3, column 1: not valid JSON: a comma too many before ']'"},
      {"{\"\xC3\xA4\": 1 \"b\": 2}", "line 1, column 9: not valid JSON: text where none can stand"},
      {"[1, 2", "line 1, column 6: not valid JSON: it ends before it is complete"},
      {"{\"a\": \"b", "it ends before it is complete"},
      {" \n", "not valid JSON: it is empty"},
      {"[\x01]", "line 1, column 2: not valid JSON: bytes that are no text"},
      {"{\"a\": \"b,\n\"c\": 1}",
       "line 1, column 10: not valid JSON: the line ends in the middle of text; a quote"},
      {"{\"a\": \"b\tc\"}", "line 1, column 9: not valid JSON: a tab in the middle of text"},
      {"{\"a\": \"D:\\photos\"}", "line 1, column 11: not valid JSON: \\p in text in quotes; a backslash is"},
      {"{\"a\": \"C:\\users\"}", "not valid JSON: \\us in text in quotes; a backslash is written \\\\"},
      {"[1e999]", "a number is too large"}};
  for (const auto& [text, words] : damaged)
    EXPECT_THAT([&text = text] { ParseJson(text, "a.json", "copy it again"); },
                ThrowsMessage<Error>(AllOf(StartsWith("a.json"), HasSubstr(words),
                                           HasSubstr("; copy it again"), Not(HasSubstr("exception")))))
        << text;
}

// Python writes them where JSON has no number.
TEST(JsonText, NumbersThatAreNoneAreText) {
  const nlohmann::json json =
      ParseJson("{\"a NaN \\\" b\": [NaN, -Infinity,1e3, null], \"c\":NaN}", "a.json", "");
  EXPECT_EQ(JsonText(json), "{\"a NaN \\\" b\":[\"NaN\",\"-Infinity\",1000.0,null],\"c\":\"NaN\"}");
  EXPECT_THAT(
      [&] {
        JsonPlace({json, "a.json"}).Number("c");
      },
      ThrowsMessage<Error>(HasSubstr("not \"NaN\"")));
}

TEST(JsonText, RoundTrips) {
  const nlohmann::json json = JsonFromText("{\"a\": [1, 2]}");
  EXPECT_EQ(JsonText(json), "{\"a\":[1,2]}");
  EXPECT_EQ(JsonText(json["a"], 1), "[\n 1,\n 2\n]");
  EXPECT_EQ(JsonText(nlohmann::ordered_json{{"b", 1}, {"a", 2}}), "{\"b\":1,\"a\":2}") << "in its order";
  EXPECT_EQ(JsonFromText(std::istringstream("[3]"))[0], 3);
  EXPECT_EQ(JsonOrDiscarded("{}"), nlohmann::json::object());
  EXPECT_TRUE(JsonOrDiscarded("{").is_discarded());
  EXPECT_TRUE(JsonOrDiscarded("[1e999]").is_discarded());
  EXPECT_TRUE(IsJson("1"));
  EXPECT_FALSE(IsJson("1,"));
  EXPECT_THROW(JsonFromText("{"), nlohmann::json::parse_error);
  const auto nested = [](std::size_t levels) { return std::string(levels, '[') + std::string(levels, ']'); };
  const std::string deep = nested(101), wide = "[" + nested(99) + ", \"[[[\"]";
  EXPECT_THROW(JsonFromText(deep), nlohmann::json::parse_error);
  EXPECT_TRUE(JsonOrDiscarded(deep).is_discarded());
  EXPECT_FALSE(IsJson(deep));
  EXPECT_EQ(JsonFromText(wide)[1], "[[[");
}

TEST(OutputPath, RefusesWhatCannotBeWritten) {
  const ScratchFolder folder;
  EXPECT_NO_THROW(RequireWritable((folder / "report.json").string()));
  EXPECT_THAT([&] { RequireWritable(folder.path().string()); },
              ThrowsMessage<Refusal>(HasSubstr("is a folder")));
  EXPECT_THAT([&] { RequireWritable((folder / "missing/report.json").string()); },
              ThrowsMessage<Refusal>(HasSubstr("does not exist")));
  EXPECT_NO_THROW(RequireWritablePicture((folder / "view.JPG").string()));
  EXPECT_THAT([&] { RequireWritablePicture((folder / "view.gif").string()); },
              ThrowsMessage<Refusal>(HasSubstr(".png or .jpg")));
  RequireWritableFolder((folder / "a/b").string());
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b"));
  std::ofstream(folder / "file").put('x');
  EXPECT_THROW(RequireWritableFolder((folder / "file").string()), Refusal);
}

TEST(DeviceUriTest, APathIsWrittenOut) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch / "my walk.mp4") << "film";
  std::filesystem::create_directories(scratch / "photos");
  const auto remedy = [](const std::string& given) -> std::string {
    try {
      DeviceUri::Parse(given);
    } catch (const Refusal& refusal) {
      return refusal.what();
    }
    return "it was taken";
  };
  EXPECT_THAT(remedy((scratch / "my walk.mp4").string()),
              ::testing::HasSubstr("write \"replay:" + (scratch / "my walk.mp4").string() + "\""));
  const std::string photos = (scratch / "photos").string();
  EXPECT_THAT(remedy(photos), ::testing::AllOf(::testing::HasSubstr("write replay:" + photos + " for"),
                                               ::testing::HasSubstr("ulf import " + photos)));
  EXPECT_THAT(remedy("/dev/null"), ::testing::HasSubstr("write v4l2:/dev/null"));
  EXPECT_THAT(remedy("nothing"), ::testing::HasSubstr("sim:studio"));
}

TEST(DeviceUriTest, OptionsAreReadWithinTheirRange) {
  const DeviceUri uri = DeviceUri::Parse("sim:studio?fps=15&queue=4&seed=1.5");
  EXPECT_EQ(uri.Number("fps", 30, 1, 100), 15);
  EXPECT_EQ(uri.Number("gain", 2, 0, 10), 2);
  EXPECT_EQ(uri.Whole("queue", 1, 8), 4);
  EXPECT_EQ(uri.Whole("buffers", 1, 8), std::nullopt);
  EXPECT_THROW(uri.Number("fps", 30, 20, 100), Refusal);
  EXPECT_THROW(uri.Whole("queue", 5, 8), Refusal);
  EXPECT_THROW(uri.Whole("seed", 1, 8), Refusal);
  EXPECT_THAT([&] { uri.AllowOnly({"fps", "queue"}); }, ThrowsMessage<Refusal>(HasSubstr("seed")));
}

TEST(ProgressText, SaysLinesAtOnceAndSharesOfLongWork) {
  ::testing::internal::CaptureStderr();
  {
    Progress progress("render");
    progress.Show(0.5);
    progress.Say("one picture is damaged");
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "one picture is damaged\n");
}

// Nobody but a thread can say it while the work runs.
TEST(WaitingText, SaysWhatLongWorkIsAt) {
  ::testing::internal::CaptureStderr();
  { const Waiting waiting("short", "nothing to wait for"); }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  ::testing::internal::CaptureStderr();
  {
    Waiting waiting("closing", "the last views");
    waiting.SetStep("the mesh");
    std::this_thread::sleep_for(std::chrono::milliseconds(1600));
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              ::testing::StartsWith("closing: the mesh, 1 s so far\n"));
}

TEST(StopOnSignalTest, SignalAsksWithoutEndingTheProcess) {
  {
    const StopOnSignal stop;
    EXPECT_FALSE(StopOnSignal::Requested());
    std::raise(SIGTERM);
    EXPECT_TRUE(StopOnSignal::Requested());
  }
  struct sigaction after {};
  sigaction(SIGTERM, nullptr, &after);
  EXPECT_EQ(after.sa_handler, SIG_DFL);
}

TEST(SignalStack, IsGivenToAThread) {
  stack_t stack{};
  std::thread([&] {
    InstallSignalStack();
    sigaltstack(nullptr, &stack);
  }).join();
  EXPECT_EQ(stack.ss_flags & SS_DISABLE, 0);
  EXPECT_GE(stack.ss_size, static_cast<std::size_t>(MINSIGSTKSZ));
}

TEST(SilentSolverTest, PrintsNothingAndUsesOneThread) {
  const auto options = SilentSolver(7);
  EXPECT_EQ(options.max_num_iterations, 7);
  EXPECT_EQ(options.num_threads, 1);
  EXPECT_EQ(options.logging_type, ceres::SILENT);
}

TEST(AvailableMemoryTest, IsAtMostTheProcesssOwnLimit) {
  EXPECT_GT(AvailableMemory(), 1u << 20);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  constexpr std::uint64_t kLeft = 64 << 20;
  rlimit limit = before;
  limit.rlim_cur = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + kLeft;
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  const std::uint64_t available = AvailableMemory();
  setrlimit(RLIMIT_AS, &before);
  EXPECT_LE(available, kLeft + (1 << 20));  // the allocator may return some memory meanwhile
}

// In a process of its own: heaps that exist stay.
TEST(AvailableMemoryTest, ManyThreadsShareTwoHeaps) {
  if (kIsSanitized) GTEST_SKIP() << "a sanitizer's allocator is another";
  const auto heaps_of_threads = [](bool shared) {
    if (shared) ShareHeaps();
    constexpr int kThreads = 8;
    std::barrier all_have_allocated(kThreads + 1), counted(kThreads + 1);
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i)
      threads.emplace_back([&] {
        const std::vector<std::string> kept(1000, std::string(100, 'x'));
        all_have_allocated.arrive_and_wait();
        counted.arrive_and_wait();
      });
    all_have_allocated.arrive_and_wait();
    char* text = nullptr;
    std::size_t size = 0;
    FILE* const stream = open_memstream(&text, &size);
    malloc_info(0, stream);
    fclose(stream);
    int heaps = 0;
    for (const char* at = text; (at = std::strstr(at, "<heap nr=")); ++at) ++heaps;
    free(text);
    counted.arrive_and_wait();
    for (std::thread& thread : threads) thread.join();
    return heaps;
  };
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  unsetenv("MALLOC_ARENA_MAX");
  EXPECT_EXIT(std::exit(heaps_of_threads(true) <= 2 ? 0 : 1), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(std::exit(heaps_of_threads(false) > 2 ? 0 : 1), testing::ExitedWithCode(0), "");
  setenv("MALLOC_ARENA_MAX", "4", 1);
  EXPECT_EXIT(std::exit(heaps_of_threads(true) > 2 ? 0 : 1), testing::ExitedWithCode(0), "");
  unsetenv("MALLOC_ARENA_MAX");
}

TEST(MutexTest, ExcludesAndWaitsForAPredicate) {
  Mutex mutex;
  ConditionVariable changed;
  int count = 0;
  std::thread other([&] {
    for (int i = 0; i < 1000; ++i) {
      const MutexLock lock(mutex);
      ++count;
    }
    changed.notify_all();
  });
  {
    MutexLock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, std::chrono::seconds(10), [&] { return count == 1000; }));
    EXPECT_FALSE(changed.wait_for(lock, std::chrono::milliseconds(1), [&] { return count > 1000; }));
    bool is_held = false;
    std::thread([&] {
      if (mutex.try_lock())
        mutex.unlock();
      else
        is_held = true;
    }).join();
    EXPECT_TRUE(is_held);
  }
  other.join();
}

TEST(Clocks, TheThreadsClockCountsWorkAndNotSleep) {
  const double cpu_s = ThreadCpuSeconds();
  const auto steady = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LT(ThreadCpuSeconds() - cpu_s, 0.04);
  EXPECT_GE(SecondsSince(steady), 0.05);
  EXPECT_GT(EpochSeconds(), 1.7e9);
  double sum_s = 1;
  {
    StageTimer timer(&sum_s);
    volatile double work = 0;
    for (int i = 0; i < 100000; ++i) work = work + i;
    timer.Stop();
  }
  EXPECT_GT(sum_s, 1);
  EXPECT_EQ(std::vector<int>({1, 2, 3})[At(2)], 3);
}

}  // namespace
}  // namespace ulf::test::base_test
