#include "core/light_field/folder/leftovers.h"

#include <system_error>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Only the holder of the journal's lock writes here.
constexpr const char* kOfTheWriter[] = {"images",         "masters",     "masks",   "unposed",
                                        kExposuresFolder, kMergedFolder, "sparse/0"};
// `ulf proxy`, renderers and whoever edits links write here, too.
constexpr const char* kOfSeveral[] = {"depth", "cache", "kept"};

template <typename Entries, typename IsLeft>
void RemoveFrom(const fs::path& folder, const IsLeft& is_left) {
  std::error_code unknown;
  std::vector<fs::path> left;
  for (Entries entry(folder, unknown), end; !unknown && entry != end; entry.increment(unknown))
    if (is_left(*entry)) left.push_back(entry->path());
  for (const fs::path& file : left) fs::remove(file, unknown);
}

}  // namespace

void RemoveLeftovers(const fs::path& light_field_folder, bool has_lock) {
  for (const char* place : kOfTheWriter)
    RemoveFrom<fs::recursive_directory_iterator>(
        light_field_folder / place, [&](const fs::directory_entry& entry) {
          return has_lock ? IsTemporary(entry) : IsLeftTemporary(entry);
        });
  std::error_code unknown;
  if (has_lock) fs::remove(light_field_folder / kNewJournal, unknown);
  for (const char* place : kOfSeveral)
    RemoveFrom<fs::recursive_directory_iterator>(light_field_folder / place, IsLeftTemporary);
  RemoveFrom<fs::directory_iterator>(light_field_folder, IsLeftTemporary);
}

}  // namespace ulf
