#include "acquisition/gphoto2/left_photographs.h"

#include <algorithm>

#include "core/base/name_order.h"

namespace ulf::acquisition {
namespace {

std::string PathInCamera(const GphotoFile& file) { return file.folder + "/" + file.name; }

}  // namespace

void LeftPhotographs::Announced(const GphotoFile& file) {
  const MutexLock lock(mutex_);
  announced_.insert(PathInCamera(file));
  last_ = file;
}

void LeftPhotographs::Lost(std::vector<FileInCamera> waiting, double released_s, double now_s) {
  const MutexLock lock(mutex_);
  left_ = {std::move(waiting), last_, released_s, now_s};
}

std::optional<LeftPhotographs::Left> LeftPhotographs::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(left_, std::nullopt);
}

std::vector<FileInCamera> LeftPhotographs::CameSince(const Left& left, std::vector<std::string> names) const {
  if (!left.last) return {};
  const MutexLock lock(mutex_);
  // The two files of a photograph share a stem.
  const std::string last = StemOf(left.last->name);
  std::erase_if(names, [&](const std::string& name) {
    return NameOrder(StemOf(name), last) || announced_.contains(PathInCamera({left.last->folder, name}));
  });
  std::ranges::sort(names, NameOrder);
  std::vector<FileInCamera> files;
  const auto new_one =
      std::ranges::find_if(names, [&](const std::string& name) { return StemOf(name) != last; });
  const std::string first_new = new_one == names.end() ? "" : StemOf(*new_one);
  for (const std::string& name : names) {
    DownloadedFile file;
    file.name = name;
    file.announced_s = left.lost_s;
    // Its photograph's other file was delivered before the link dropped, unless that waits as well.
    file.is_late = StemOf(name) == last && std::ranges::none_of(left.waiting, [&](const FileInCamera& other) {
                     return StemOf(other.first.name) == last;
                   });
    if (StemOf(name) != last && StemOf(name) == first_new) file.released_s = left.released_s;
    files.emplace_back(GphotoFile{left.last->folder, name}, std::move(file));
  }
  return files;
}

}  // namespace ulf::acquisition
