#include "acquisition/gphoto2/unfetched_photographs.h"

#include <algorithm>

#include "core/base/name_order.h"
#include "core/image/files/picture_kind.h"

namespace ulf::acquisition {

void UnfetchedPhotographs::Announced(const GphotoFile& file) {
  const MutexLock lock(mutex_);
  announced_.insert(file.Path());
  last_ = file;
}

void UnfetchedPhotographs::Lost(Unfetched left) {
  const MutexLock lock(mutex_);
  if (!left.last) left.last = last_;
  fetched_ = announced_;
  left_ = std::move(left);
}

std::optional<UnfetchedPhotographs::Unfetched> UnfetchedPhotographs::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(left_, std::nullopt);
}

std::vector<GphotoFile> UnfetchedPhotographs::PhotographsAfter(const Unfetched& left,
                                                               std::vector<std::string> names) const {
  if (!left.last) return {};
  const MutexLock lock(mutex_);
  // The two files of a photograph share a stem.
  const std::string last = StemOf(left.last->name);
  std::erase_if(names, [&](const std::string& name) ULF_REQUIRES(mutex_) {
    return !(ExtensionOf(name) == ".jpg" || IsRawFile(name)) || NameOrder(StemOf(name), last) ||
           announced_.contains(GphotoFile{left.last->folder, name}.Path());
  });
  std::ranges::sort(names, NameOrder);
  std::vector<GphotoFile> files;
  for (const std::string& name : names) files.push_back({left.last->folder, name});
  return files;
}

std::vector<FileInCamera> UnfetchedPhotographs::CameSince(const Unfetched& left,
                                                          const std::vector<GphotoFile>& files) {
  if (!left.last) return {};
  const std::string last = StemOf(left.last->name);
  const auto new_one =
      std::ranges::find_if(files, [&](const GphotoFile& file) { return StemOf(file.name) != last; });
  const std::string first_new = new_one == files.end() ? "" : StemOf(new_one->name);
  std::vector<FileInCamera> to_fetch;
  for (const GphotoFile& where : files) {
    const std::string stem = StemOf(where.name);
    DownloadedFile file;
    file.name = where.name;
    file.announced_s = left.lost_s;
    // Its photograph's other file was delivered before the link dropped, unless that waits as well.
    file.is_late = stem == last && std::ranges::none_of(left.waiting, [&](const FileInCamera& other) {
                     return StemOf(other.first.name) == last;
                   });
    if (stem == first_new) file.released_s = left.released_s;
    to_fetch.emplace_back(where, std::move(file));
  }
  return to_fetch;
}

void UnfetchedPhotographs::Fetched(const GphotoFile& file) {
  const MutexLock lock(mutex_);
  announced_.insert(file.Path());
  fetched_.insert(file.Path());
  last_ = file;
}

bool UnfetchedPhotographs::WasFetched(const GphotoFile& file) const {
  const MutexLock lock(mutex_);
  return fetched_.contains(file.Path());
}

}  // namespace ulf::acquisition
