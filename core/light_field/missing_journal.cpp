#include "core/light_field/missing_journal.h"

#include "core/base/shell_word.h"
#include "core/light_field/exchange/colmap_text.h"
#include "core/light_field/exchange/transforms_json.h"
#include "core/light_field/journal.h"

namespace ulf {
namespace fs = std::filesystem;

bool IsJournalMissing(const fs::path& dir) {
  if (fs::exists(dir / kJournalFile)) return false;
  const auto stamped = [&](const char* name, const auto& read) {
    if (!fs::is_regular_file(dir / name)) return false;
    try {
      return read(dir / name).made_from.has_value();
    } catch (const Error&) {
      return false;
    }
  };
  return stamped(kTransformsFile, ReadTransformsText) || stamped("sparse/0/images.txt", ReadColmapPoses);
}

Error MissingJournalError(const fs::path& dir) {
  const std::string folder = dir.string(), word = ShellWord(folder);
  if (!fs::is_directory(dir))
    return Error("{}: there is no such folder; give the folder of a light field", folder);
  if (IsJournalMissing(dir))
    return Error("{}: the journal is missing; 'ulf repair {}' shows how to restore it", folder, word);
  if (fs::is_regular_file(dir / kTransformsFile))
    return Error(
        "{}: a set by another program, which is never written to; 'ulf import {} -o NEW' makes a light field "
        "of it",
        folder, word);
  return Error(
      "{}: holds no light field (no journal.jsonl); check the path, or record one with 'ulf capture -o {}'",
      folder, word);
}

}  // namespace ulf
