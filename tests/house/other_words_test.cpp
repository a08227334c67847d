// No behaviour hangs on the wording of a message: a copy of the program in which every sentence reads
// otherwise does the same. Sentences are what the linker merged as texts, with three words or more; each of
// their letters becomes the next one of the alphabet, but for what stands in braces.
#include <elf.h>
#include <gmock/gmock.h>

#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;

std::string FileText(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Shaders and other programs' formats of numbers are no sentences.
bool IsSentence(const std::string& text) {
  static const std::regex placeholder(R"(\{[^}]*\})"), word(R"((^|[\s,(])[a-z]{2,}(?=[\s,;:.)]|$))");
  if (text.find('%') != std::string::npos || text.find(";\n") != std::string::npos) return false;
  const std::string plain = std::regex_replace(text, placeholder, "");
  return std::distance(std::sregex_iterator(plain.begin(), plain.end(), word), {}) >= 3;
}

void SayOtherwise(char* text) {
  for (bool braced = false; *text; ++text) {
    braced = *text == '{' || (braced && *text != '}');
    if (!braced && *text >= 'a' && *text <= 'z') *text = *text == 'z' ? 'a' : *text + 1;
  }
}

// How many sentences were exchanged.
int WriteWithOtherWords(const fs::path& program, const fs::path& copy) {
  std::string bytes = FileText(program);
  Elf64_Ehdr header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  int exchanged = 0;
  for (int i = 0; i < header.e_shnum; ++i) {
    Elf64_Shdr section;
    std::memcpy(&section, bytes.data() + header.e_shoff + i * header.e_shentsize, sizeof(section));
    if (!(section.sh_flags & SHF_STRINGS) || !(section.sh_flags & SHF_ALLOC)) continue;
    for (std::size_t at = section.sh_offset, end = at + section.sh_size; at < end;) {
      char* text = bytes.data() + at;
      at += std::strlen(text) + 1;
      if (!IsSentence(text)) continue;
      SayOtherwise(text);
      ++exchanged;
    }
  }
  std::ofstream(copy, std::ios::binary) << bytes;
  fs::permissions(copy, fs::perms::owner_all);
  return exchanged;
}

std::string Output(const fs::path& program, const std::string& arguments, const fs::path& scratch) {
  const fs::path output = scratch / "output";
  const std::string command =
      program.string() + " " + arguments + " >" + output.string() + " 2>" + (scratch / "messages").string();
  EXPECT_EQ(std::system(command.c_str()), 0) << FileText(scratch / "messages");
  return FileText(output);
}

// The leaves that are no texts.
std::string Numbers(const nlohmann::json& json) {
  std::string numbers;
  const nlohmann::json flat = json.flatten();
  for (const auto& [place, leaf] : flat.items())
    if (!leaf.is_string()) numbers += place + " " + leaf.dump() + "\n";
  return numbers;
}

class OtherWords : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::getenv("ULF_BINARY"));
    ASSERT_GT(WriteWithOtherWords(usual_, other_), 1000);
  }

  ScratchFolder scratch_;
  const fs::path usual_ = std::getenv("ULF_BINARY"), other_ = scratch_ / "ulf";
};

TEST_F(OtherWords, ErrorsReadOtherwise) {
  const auto refused = [&](const fs::path& program) {
    const fs::path messages = scratch_ / "messages";
    EXPECT_NE(std::system((program.string() + " info /nowhere 2>" + messages.string()).c_str()), 0);
    return FileText(messages);
  };
  const std::string usual = refused(usual_), other = refused(other_);
  EXPECT_THAT(usual, testing::HasSubstr("/nowhere"));
  EXPECT_THAT(other, testing::HasSubstr("/nowhere"));
  EXPECT_NE(usual, other);
}

// The simulated person reads the display's instructions, and the device's events are counted by kind.
TEST_F(OtherWords, CaptureRecordsTheSameViews) {
  const auto captured = [&](const fs::path& program, const std::string& name) {
    Output(program,
           "capture 'sim:studio?width=320&height=240&fps=15' --headless --deterministic --no-geometry "
           "--operator novice:5 "
           "--subject-size 0.28 --quality fast --max-seconds 12 -o " +
               (scratch_ / name).string(),
           scratch_.path());
    return FileText(scratch_ / name / "transforms.json");
  };
  const std::string usual = captured(usual_, "usual");
  EXPECT_THAT(usual, testing::HasSubstr("file_path"));
  EXPECT_EQ(usual, captured(other_, "other"));
}

TEST_F(OtherWords, CalibrationFindsTheSameLens) {
  const auto lens = [&](const fs::path& program, const std::string& name) {
    return Numbers(nlohmann::json::parse(
        Output(program, "calibrate sim:board --json -o " + (scratch_ / name).string(), scratch_.path())));
  };
  const std::string usual = lens(usual_, "usual.json");
  EXPECT_THAT(usual, testing::HasSubstr("/camera/fx"));
  EXPECT_EQ(usual, lens(other_, "other.json"));
}

}  // namespace
}  // namespace ulf::test
