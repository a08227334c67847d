// Tests: core/light_field/journal_stamp, core/light_field/folder/journal,
// core/light_field/folder/repair_plan, core/light_field/folder/folder_repair,
// core/light_field/formats/transforms_json.
//
// What a damaged light field keeps, and what happens to one by a newer version, counted: rows of
// docs/measured/cameras.md.
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <map>
#include <random>

#include "core/base/atomic_file.h"
#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/repair_plan.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/journal_stamp.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::damage_test {
namespace {

using test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

std::map<std::string, std::string> Bytes(const fs::path& dir) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(dir))
    if (entry.is_regular_file())
      bytes[entry.path().lexically_relative(dir).generic_string()] = ReadWholeFile(entry.path());
  return bytes;
}

void Replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string bytes = ReadWholeFile(file);
  const std::size_t at = bytes.find(from);
  ASSERT_NE(at, std::string::npos) << file << " has no " << from;
  std::ofstream(file, std::ios::binary) << bytes.replace(at, from.size(), to);
}

// Whoever reads, goes on with, or repairs it is sent to a newer program, and not a byte of it changes.
TEST(Damage, ALightFieldByANewerVersionIsLeftAlone) {
  int tried = 0;
  for (const bool journal_gone : {false, true}) {
    const ScratchFolder scratch;
    const fs::path dir = scratch / "lf";
    WriteSample(dir, 5);
    if (journal_gone) {
      fs::remove(dir / "journal.jsonl");
      Replace(dir / "transforms.json", "\"format_version\": ", "\"format_version\": 9");
    } else {
      Replace(dir / "journal.jsonl", "\"version\":", "\"version\":9");
    }
    const auto before = Bytes(dir);
    const auto newer =
        ThrowsMessage<Error>(AllOf(HasSubstr("newer than this program's"), HasSubstr("use a newer ulf")));
    if (!journal_gone) {
      EXPECT_THAT([&] { ReadLightField(dir); }, newer);
      EXPECT_THAT([&] { ReadLightField(dir); }, ThrowsMessage<Error>(Not(HasSubstr("ulf repair"))));
      EXPECT_THAT([&] { LightFieldWriter::Create(dir, Header()); }, testing::Throws<Error>());
      EXPECT_THAT([&] { LightFieldWriter::Resume(dir); }, newer);
    }
    EXPECT_THAT([&] { PlanRepair(dir); }, newer) << journal_gone;
    EXPECT_THAT([&] { Repair(dir); }, newer) << journal_gone;
    EXPECT_TRUE(Bytes(dir) == before) << journal_gone;
    tried += journal_gone ? 2 : 4;
  }
  test::PrintFaultRow("light field by a newer version: read, resumed, begun anew, repaired", tried,
                      "no byte; each is refused", std::nullopt);
}

// One byte of one file, anywhere: after the repair every view is there but the one whose line or
// photograph it was.
TEST(Damage, AByteThatFlipsCostsOneViewAtMost) {
  constexpr int kViews = 6, kTries = 120;
  const ScratchFolder scratch;
  WriteSample(scratch / "whole", kViews);
  const auto whole = Bytes(scratch / "whole");
  std::vector<std::string> files;
  for (const auto& [file, bytes] : whole) files.push_back(file);
  std::mt19937 random(20261127);
  int lost = 0, refused = 0, changed = 0;
  double longest_s = 0;
  for (int i = 0; i < kTries; ++i) {
    const fs::path dir = scratch / "lf";
    fs::remove_all(dir);
    fs::copy(scratch / "whole", dir, fs::copy_options::recursive);
    // The journal as often as all photographs together: it is what everything hangs on.
    const std::string file = i % 3 == 0 ? "journal.jsonl" : files[random() % files.size()];
    std::string bytes = whole.at(file);
    const std::size_t at = random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
    std::ofstream(dir / file, std::ios::binary) << bytes;
    const std::string where = fmt::format("{}, byte {}", file, at);
    const auto start = std::chrono::steady_clock::now();
    LightField read;
    try {
      read = ReadLightField(dir);
    } catch (const NewerFormatError&) {
      continue;  // the digit of the version
    } catch (const Error& error) {
      ++refused;  // the header: repair makes it anew
      EXPECT_THAT(error.what(), HasSubstr("ulf repair")) << where;
    }
    Repair(dir);
    read = ReadLightField(dir);
    longest_s = std::max(longest_s, SecondsSince(start));
    int good = 0;
    for (const View& view : read.views) {
      EXPECT_NO_THROW(ReadViewImage(read, view)) << where;
      const bool same =
          (view.cam_from_world.Matrix() - ViewNumber(view.id - 1).cam_from_world.Matrix()).norm() < 1e-6;
      changed += !same;
      good += same;
    }
    EXPECT_GE(good, kViews - 1) << where;
    lost += kViews - static_cast<int>(read.views.size());
    // Nothing is deleted: what the views lost lies beside them.
    for (const auto& [name, was] : whole) {
      if (!name.starts_with("images/") || name == file) continue;
      EXPECT_TRUE(fs::exists(dir / name) || fs::exists(dir / "unposed" / fs::path(name).filename())) << where;
    }
  }
  EXPECT_LE(lost, kTries);
  test::PrintFaultRow("one bit flipped in any file, then `ulf repair --write`", kTries,
                      fmt::format("{} of {} views, {} poses changed", lost, kTries * kViews, changed),
                      longest_s);
}

}  // namespace
}  // namespace ulf::damage_test
