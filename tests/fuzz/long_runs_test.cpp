// Tests: core/light_field/folder/journal, core/light_field/exchange/read_posed_set,
// core/light_field/exchange/readers/npy_file, acquisition/calibration/calibration_formats,
// core/base/json_text, core/light_field/formats/xml_file.
//
// What a fuzzer's short inputs do not reach: parsers that call themselves once a character, a bracket or a
// line overrun the stack, and those that look at the rest again for each of them never end. Files of the
// corpus get a long run of one thing in their midst, and go through their door in a process of their own.
#include <gmock/gmock.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/fuzz/fuzz_targets.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRunBytes = 200'000;
constexpr std::size_t kMostFiles = 4, kMostPlaces = 8;  // of a door, of a file

std::vector<std::size_t> EndsOfWords(std::string_view bytes) {
  const auto is_word = [&](std::size_t at) {
    return std::isalnum(static_cast<unsigned char>(bytes[at])) != 0;
  };
  std::vector<std::size_t> ends{0};
  for (std::size_t at = 1; at < bytes.size(); ++at)
    if (is_word(at) != is_word(at - 1)) ends.push_back(at);
  ends.push_back(bytes.size());
  return ends;
}

template <typename T>
std::vector<T> SpreadOver(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * (all.size() - 1) / (most - 1)]);
  return some;
}

// What is repeated at a place: things that nest or part, the word and the line that stand before it.
std::vector<std::string> Repeated(std::string_view bytes, const std::vector<std::size_t>& ends,
                                  std::size_t at) {
  std::vector<std::string> texts{"[", "(", "{",  "{\"a\":",           "<a>", "a: ", "- ", " ", "\n",
                                 ",", "9", "\"", std::string(1, '\0')};
  const auto end = std::ranges::find(ends, at);
  if (end != ends.begin()) texts.emplace_back(bytes.substr(*(end - 1), at - *(end - 1)));
  const std::size_t line = at < 2 ? std::string_view::npos : bytes.rfind('\n', at - 2);
  if (line != std::string_view::npos && line + 1 < at)
    texts.emplace_back(bytes.substr(line + 1, at - line - 1));
  return texts;
}

// What the process is at, for who finds it dead.
struct Note {
  char words[200];
};

void ReadAll(const FuzzTarget& target, const std::string& bytes, Note& note) {
  const std::vector<std::size_t> ends = EndsOfWords(bytes);
  for (const std::size_t at : SpreadOver(ends, kMostPlaces))
    for (const std::string& text : Repeated(bytes, ends, at)) {
      const std::string words = fmt::format("at byte {} repeated: {:.100}", at, text);
      std::strncpy(note.words, words.c_str(), sizeof note.words - 1);
      std::string longer = bytes.substr(0, at);
      while (longer.size() < at + kRunBytes) longer += text;
      longer += bytes.substr(at);
      try {
        target.read(longer);
      } catch (const Error&) {
      }
    }
}

class LongRuns : public ::testing::TestWithParam<FuzzTarget> {};

TEST_P(LongRuns, AreReadOrRefused) {
  spdlog::set_level(spdlog::level::off);
  auto* const note = static_cast<Note*>(
      mmap(nullptr, sizeof(Note), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(note, MAP_FAILED);
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(FUZZ_CORPUS) / GetParam().name))
    files.push_back(entry.path());
  std::ranges::sort(files);
  for (const fs::path& file : SpreadOver(files, kMostFiles)) {
    const std::string bytes = ReadWholeFile(file);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      constexpr rlimit kSeconds{120, 120};  // two are usual; what looks at everything again takes hours
      setrlimit(RLIMIT_CPU, &kSeconds);
      ReadAll(GetParam(), bytes, *note);
      _exit(0);
    }
    int status = 0;
    rusage usage{};
    ASSERT_EQ(wait4(child, &status, 0, &usage), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
        << file << ", " << note->words << ": ended by signal " << WTERMSIG(status);
    EXPECT_LT(usage.ru_maxrss / 1024, 1000) << file << " takes megabytes";
  }
  munmap(note, sizeof(Note));
}

INSTANTIATE_TEST_SUITE_P(Doors, LongRuns, ::testing::ValuesIn(FuzzTargets().begin(), FuzzTargets().end()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace ulf::test
