#include "core/light_field/exchange/npy_file.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <regex>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace ulf {
namespace {

// The value behind a key of the header, a Python dictionary such as
// {'descr': '<f8', 'fortran_order': False, 'shape': (20, 17), }.
std::string NpyField(const std::string& header, const char* pattern, const std::string& where) {
  std::smatch found;
  if (!std::regex_search(header, found, std::regex(pattern)))
    throw Error("{}: its header is damaged ('descr', 'fortran_order' or 'shape' is missing); copy it again",
                where);
  return found[1];
}

template <typename T>
double NpyNumber(const char* at, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swapped) std::ranges::reverse(bytes);
  return static_cast<double>(std::bit_cast<T>(bytes));
}

}  // namespace

Eigen::MatrixXd ReadNpyMatrix(const std::filesystem::path& file) {
  const std::string where = file.string(), bytes = ReadWholeFile(file);
  constexpr std::size_t kMagic = 6, kVersionEnd = 8;
  if (!bytes.starts_with("\x93NUMPY") || bytes.size() < kVersionEnd + 4)
    throw Error("{}: is no NumPy file (.npy), or is cut short; copy it again", where);
  const bool is_long = bytes[kMagic] >= 2;
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<std::uint8_t>(bytes[i]));
  };
  std::size_t length = byte(8) | byte(9) << 8;
  if (is_long) length |= byte(10) << 16 | byte(11) << 24;
  const std::size_t begin = kVersionEnd + (is_long ? 4 : 2);
  if (length > bytes.size() - begin) throw Error("{}: is cut short; copy it again", where);
  const std::string header = bytes.substr(begin, length);
  const std::string type = NpyField(header, R"('descr'\s*:\s*'([^']*)')", where);
  const bool by_columns = NpyField(header, R"('fortran_order'\s*:\s*(True|False))", where) == "True";
  const std::string shape = NpyField(header, R"('shape'\s*:\s*\(([^)]*)\))", where);
  std::smatch sides;
  if (!std::regex_match(shape, sides, std::regex(R"(\s*(\d{1,9})\s*,\s*(?:(\d{1,9})\s*,?\s*)?)")))
    throw Error("{}: an array of shape ({}); one or two dimensions are supported", where, shape);
  if (type != "<f8" && type != "<f4" && type != ">f8" && type != ">f4")
    throw Error(
        "{}: numbers of type '{}'; 4 and 8 byte floating point is supported: numpy.save(..., "
        "array.astype('f8'))",
        where, type);
  const auto rows = static_cast<std::size_t>(std::stoll(sides[1])),
             cols = sides[2].matched ? static_cast<std::size_t>(std::stoll(sides[2])) : 1;
  const std::size_t each = type.ends_with('8') ? 8 : 4;
  const std::size_t held = (bytes.size() - begin - length) / each;
  if (cols > 0 && rows > held / cols)
    throw Error("{}: is cut short: an array of {}x{} numbers, of which {} are there; copy it again", where,
                rows, cols, held);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
  const bool swapped = type.starts_with('>');
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < cols; ++c) {
      const char* at = bytes.data() + begin + length + each * (by_columns ? c * rows + r : r * cols + c);
      values(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) =
          each == 8 ? NpyNumber<double>(at, swapped) : NpyNumber<float>(at, swapped);
    }
  return values;
}

}  // namespace ulf
