#include "core/light_field/folder/unused_folder.h"

#include <set>
#include <string>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/followed_links.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {

namespace fs = std::filesystem;

bool IsUnused(const fs::path& dir) {
  std::error_code unknown;
  if (!fs::is_regular_file(dir / kJournalFile, unknown)) return false;
  for (const char* folder : {"images", "masters", "unposed"})
    if (fs::is_directory(dir / folder, unknown) && !fs::is_empty(dir / folder, unknown)) return false;
  try {
    // Without a header the capture ended before it began.
    if (ReadWholeFile(dir / kJournalFile).find('\n') == std::string::npos)
      return !fs::exists(dir / kTransformsFile) && !fs::exists(dir / "sparse");
    return ReadJournal(dir / kJournalFile).next_view_id == 1;
  } catch (const Error&) {
    return false;
  }
}

void RequireForNewLightField(const fs::path& dir) {
  std::error_code unknown;
  if (fs::exists(dir, unknown) && !fs::is_directory(dir))
    throw Error("{}: is a file; choose another name", dir.string());
  RequireFollowed(dir, RefusedLinks(dir, {}));
  if (IsUnused(dir)) return;
  if (fs::is_regular_file(dir / kJournalFile, unknown))
    throw Error("{}: holds a light field already; go on with it ({}) or choose another folder", dir.string(),
                Parameter("resume"));
  if (fs::is_directory(dir, unknown) && !fs::is_empty(dir, unknown))
    throw Error("{}: the folder is not empty; choose another one", dir.string());
}

void RemoveUnused(const fs::path& dir) {
  if (!IsUnused(dir)) return;
  const std::set<std::string> own{"images", "masters", "unposed", "sparse", kJournalFile, kTransformsFile};
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator(dir, refused))
    if (!own.contains(entry.path().filename().string())) return;
  for (const std::string& name : own) fs::remove_all(dir / name, refused);
  fs::remove(dir, refused);
}

}  // namespace ulf
