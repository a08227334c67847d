// No behaviour hangs on the wording of a message: a copy of the program in which every sentence reads
// otherwise does the same. Sentences are what the linker merged as texts, with two words or more; their
// small letters move on in the alphabet, each sentence's by a number of its own, but for what stands in
// braces. What both programs say has the same lines, numbers and marks.
#include <elf.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/pictures/sample_pictures.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;

std::string FileText(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// With two words or more. Shaders and other programs' formats of numbers are no sentences.
bool IsSentence(const std::string& text) {
  if (text.find('%') != std::string::npos || text.find(";\n") != std::string::npos) return false;
  const auto is_in = [](const char* these, char c) { return std::strchr(these, c) != nullptr; };
  int words = 0;
  for (std::size_t at = 0, end = 0; at < text.size(); at = std::max(end, at + 1)) {
    for (end = at; end < text.size() && text[end] >= 'a' && text[end] <= 'z';) ++end;
    words += end - at >= 2 && (at == 0 || is_in(" \n,(", text[at - 1])) &&
             (end == text.size() || is_in(" \n,;:.)", text[end]));
  }
  return words >= 2;
}

// Each by letters of its own: else a part would still be found in a whole that was changed alike.
void SayOtherwise(char* text) {
  const int by = 1 + static_cast<int>(std::strlen(text) % 25);
  for (bool braced = false; *text; ++text) {
    braced = *text == '{' || (braced && *text != '}');
    if (!braced && *text >= 'a' && *text <= 'z') *text = static_cast<char>('a' + (*text - 'a' + by) % 26);
  }
}

// Returns the characters that other words leave as they are.
std::string WithoutSmallLetters(std::string text) {
  std::erase_if(text, [](char c) { return c >= 'a' && c <= 'z'; });
  return text;
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

// The leaves that are no texts, but for the size and checksum of a journal, in which sentences stand.
std::string Numbers(const nlohmann::json& json) {
  std::string numbers;
  const nlohmann::json flat = json.flatten();
  for (const auto& [place, leaf] : flat.items())
    if (!leaf.is_string() && !place.starts_with("/ulf/journal")) numbers += place + " " + leaf.dump() + "\n";
  return numbers;
}

// Photographs in Display P3 on an arc round the origin, one of them without a pose, and Metashape's cameras
// of them, with a second chunk that is not read.
void WriteMetashapeSet(const fs::path& dir) {
  std::string cameras;
  for (int i = 0; i < 9; ++i) {
    const std::string name = "p" + std::to_string(i);
    WritePngSample(dir / (name + ".png"), {.icc = IccProfile("P3")});
    const double s = std::sin(0.15 * i), c = std::cos(0.15 * i);
    if (i < 8)
      cameras += fmt::format(
          "<camera id=\"{}\" sensor_id=\"0\" label=\"{}\"><transform>{} 0 {} {} 0 1 0 0 {} 0 {} {} 0 0 0 1"
          "</transform></camera>\n",
          i, name, c, -s, 2 * s, s, c, -2 * c);
  }
  const std::string lens = "<resolution width=\"60\" height=\"40\"/>";
  std::ofstream(dir / "cameras.xml")
      << "<document version=\"2.0.0\"><chunk label=\"one\"><sensors><sensor id=\"0\" type=\"frame\">" << lens
      << "<calibration type=\"frame\" class=\"adjusted\">" << lens
      << "<f>60</f></calibration></sensor></sensors><cameras>" << cameras
      << "</cameras></chunk><chunk label=\"two\"><cameras/></chunk></document>";
}

class OtherWords : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::getenv("ULF_BINARY"));
    ASSERT_GT(WriteWithOtherWords(usual_, other_), 1000);
  }

  // Runs the commands one after the other in a copy of `input`: what they said, the files that are there
  // then, and the numbers of light fields.
  std::string Done(const fs::path& program, const fs::path& input, const std::vector<std::string>& commands) {
    const ScratchFolder folder;
    const std::string at = folder.path();
    fs::copy(input, folder.path(), fs::copy_options::recursive);
    std::string done;
    for (const std::string& command : commands) {
      const int status = std::system(
          fmt::format("cd {0} && {1} {2} >{3} 2>&1", at, program.string(), command, said_.string()).c_str());
      done += fmt::format("{}: {}\n{}\n", command, status,
                          std::regex_replace(FileText(said_), std::regex(at), "folder"));
    }
    std::set<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) files.insert(entry.path());
    for (const fs::path& file : files) {
      done += file.lexically_relative(folder.path()).string() + "\n";
      if (file.filename() == "transforms.json") done += Numbers(nlohmann::json::parse(FileText(file)));
    }
    return done;
  }
  // Returns what the usual program said and did.
  std::string ExpectTheSame(const fs::path& input, const std::vector<std::string>& commands) {
    const std::string usual = Done(usual_, input, commands), other = Done(other_, input, commands);
    EXPECT_NE(usual, other);
    EXPECT_EQ(WithoutSmallLetters(usual), WithoutSmallLetters(other));
    return usual;
  }

  ScratchFolder scratch_;
  const fs::path usual_ = std::getenv("ULF_BINARY"), other_ = scratch_ / "ulf", said_ = scratch_ / "said";
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
           "--operator novice:5 --subject-size 0.28 --quality fast --max-seconds 12 -o " +
               (scratch_ / name).string(),
           scratch_.path());
    return Numbers(nlohmann::json::parse(FileText(scratch_ / name / "transforms.json")));
  };
  const std::string usual = captured(usual_, "usual");
  EXPECT_THAT(usual, testing::HasSubstr("/frames/9/transform_matrix"));
  EXPECT_EQ(usual, captured(other_, "other"));
}

TEST_F(OtherWords, ImportAndExportDoTheSame) {
  fs::create_directory(scratch_ / "set");
  WriteMetashapeSet(scratch_ / "set");
  const std::string usual =
      ExpectTheSame(scratch_ / "set", {"import cameras.xml -o vase --subject 0,0,0,0.3", "info vase",
                                       "export colmap vase -o colmap", "export metashape vase -o metashape"});
  EXPECT_THAT(usual, testing::HasSubstr("1 photograph without a pose"));
  EXPECT_THAT(usual, testing::HasSubstr("magick"));
}

TEST_F(OtherWords, RepairMendsTheSame) {
  Output(usual_,
         "capture 'sim:studio?width=160&height=120' --headless --deterministic --no-geometry --poses known "
         "--subject 0,0,0.07,0.17 --quality fast --max-seconds 4 -o " +
             (scratch_ / "vase").string(),
         scratch_.path());
  // Two damaged lines, one after the other, and the last one cut.
  const fs::path journal = scratch_ / "vase/journal.jsonl";
  std::string text = FileText(journal);
  std::size_t line = 0;
  for (int i = 0; i < 4; ++i) line = text.find('\n', line + 1);
  for (int i = 0; i < 2; ++i, line = text.find('\n', line + 1)) text.replace(line + 10, 8, "########");
  std::ofstream(journal, std::ios::binary) << text.substr(0, text.size() - 20);
  const std::string usual =
      ExpectTheSame(scratch_ / "vase", {"info .", "repair .", "repair . --write", "info .", "repair ."});
  EXPECT_THAT(usual, testing::HasSubstr("lines 5 to 6: damaged"));
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
