#include "render/proxy/indexed_file.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"

namespace ulf::render {

std::string ChecksumForIndex(std::string_view bytes) { return ChecksumText(FastChecksumOf(bytes)); }

std::string ReadIndexedFile(const std::filesystem::path& path, const std::string& checksum) {
  std::string bytes = ReadWholeFile(path);
  if (ChecksumForIndex(bytes) != checksum) throw Error("{}: its bytes have changed", path.string());
  return bytes;
}

}  // namespace ulf::render
