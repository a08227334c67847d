#include "core/light_field/folder/light_field_io.h"

#include <fcntl.h>
#include <sys/file.h>

#include <spdlog/spdlog.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/base/shell_word.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/derived_files.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/quick_checks.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

bool IsBeingWritten(const fs::path& journal) {
  const FileDescriptor file(open(journal.c_str(), O_RDONLY | O_CLOEXEC));
  return file.IsOpen() && flock(file.Number(), LOCK_SH | LOCK_NB) != 0;
}

LightField ReadForeignSet(const fs::path& transforms) {
  LightField light_field = ReadTransformsJson(transforms);
  WarnOnce(light_field.doubts);
  AddKnownFindings({}, light_field);
  return light_field;
}

}  // namespace

LightField ReadLightField(const fs::path& path) {
  std::error_code unknown;
  if (fs::is_regular_file(path, unknown) && path.filename() == kJournalFile)
    throw Error("{}: give the folder that holds it: {}", path.string(), FolderOf(path).string());
  if (fs::is_regular_file(path, unknown)) return ReadForeignSet(path);
  if (!fs::is_directory(path, unknown))
    throw Error("{}: there is no such folder; give the folder of a light field", path.string());
  if (!fs::is_regular_file(path / kJournalFile)) {
    if (fs::is_regular_file(path / kTransformsFile)) return ReadForeignSet(path / kTransformsFile);
    if (IsJournalMissing(path) || !FormatsIn(path).empty()) throw MissingJournalError(path);
    throw Error("{}: holds no light field: neither {} nor {}; capture or import one{}", path.string(),
                kJournalFile, kTransformsFile,
                fs::is_directory(path / "images", unknown)
                    ? fmt::format(" (the photographs in images/ get new poses by 'ulf import {} {} -o NEW')",
                                  ShellWord((path / "images").string()), Parameter("pose"))
                    : "");
  }
  RequireFollowed(path, RefusedLinks(path, {}));
  JournalContents journal = ReadJournal(path / kJournalFile);
  const bool being_written = IsBeingWritten(path / kJournalFile);
  const FolderCheck check = CheckFolder(path, journal, being_written);
  RequireImages(journal.light_field, check);
  LightField light_field = std::move(journal.light_field);
  light_field.doubts = check.words;
  ReadPoints(light_field);
  WarnOnce(light_field.doubts);
  AddKnownFindings(journal.kept_findings, light_field);
  if (check.not_closed && !light_field.views.empty())
    spdlog::debug("{}: transforms.json and sparse/ are older than the journal", path.string());
  return light_field;
}

void WriteLightField(const LightField& light_field) {
  if (light_field.cameras.empty()) throw Error("{}: a light field needs a camera", light_field.root.string());
  Journal journal(light_field.root / kJournalFile);
  journal.CutAt(0);
  journal.Header(light_field);
  if (light_field.up_in_world) journal.SetUp(*light_field.up_in_world);
  if (light_field.goal) journal.SetGoal(*light_field.goal);
  if (light_field.readout) journal.SetReadout(*light_field.readout);
  if (light_field.turntable) journal.SetTurntable(*light_field.turntable);
  if (light_field.subject) journal.SetSubject(*light_field.subject);
  journal.AddViews(light_field.views);
  journal.Close(light_field.capture_s, light_field.reasons, light_field.measured);
  WriteDerivedFiles(light_field);
}

}  // namespace ulf
