#include "core/light_field/exchange/readers/npy_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"

namespace ulf {
namespace {

std::string_view WithoutSpaces(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(" \t\n"), text.size()));
}

// The header is a Python dictionary such as {'descr': '<f8', 'fortran_order': False, 'shape': (20, 17), }.
// The standard library's regular expressions recurse for each character, and a header may have millions.
class NpyHeader {
 public:
  NpyHeader(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  bool ByColumns() const {
    const std::string_view value = Behind("'fortran_order'");
    if (!value.starts_with("True") && !value.starts_with("False")) Damaged();
    return value.starts_with("True");
  }
  std::string_view Between(std::string_view key, char open, char close) const {
    const std::string_view value = Behind(key);
    const std::size_t end = value.starts_with(open) ? value.find(close, 1) : std::string_view::npos;
    if (end == std::string_view::npos) Damaged();
    return value.substr(1, end - 1);
  }

 private:
  std::string_view Behind(std::string_view key) const {
    const std::size_t at = text_.find(key);
    if (at == std::string_view::npos) Damaged();
    const std::string_view rest = WithoutSpaces(text_.substr(at + key.size()));
    if (!rest.starts_with(':')) Damaged();
    return WithoutSpaces(rest.substr(1));
  }
  [[noreturn]] void Damaged() const {
    throw Error("{}: its header is damaged ('descr', 'fortran_order' or 'shape' is missing); copy it again",
                where_);
  }

  std::string_view text_;
  const std::string& where_;
};

// Parses "20, 17", "20," or "20, 17,": one or two sizes.
std::optional<std::pair<std::size_t, std::size_t>> Sides(std::string_view shape) {
  constexpr std::size_t kMostSides = 2;
  std::vector<std::size_t> sides;
  bool comma = true;
  while (true) {
    shape = WithoutSpaces(shape);
    if (shape.empty()) break;
    if (shape.front() == ',') {
      if (comma) return std::nullopt;
      comma = true;
      shape.remove_prefix(1);
      continue;
    }
    std::uint32_t side = 0;
    const auto [end, problem] = std::from_chars(shape.data(), shape.data() + shape.size(), side);
    if (problem != std::errc() || !comma || sides.size() == kMostSides) return std::nullopt;
    sides.push_back(side);
    comma = false;
    shape.remove_prefix(static_cast<std::size_t>(end - shape.data()));
  }
  if (sides.empty() || (sides.size() == 1 && !comma)) return std::nullopt;
  return std::pair(sides[0], sides.size() > 1 ? sides[1] : 1);
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
  constexpr std::size_t kMagic = 6, kVersionEnd = 8, kMostShown = 80;
  if (!bytes.starts_with("\x93NUMPY") || bytes.size() < kVersionEnd + 4)
    throw Error("{}: is no NumPy file (.npy), or is cut short; copy it again", where);
  const bool is_long = bytes[kMagic] >= 2;
  const std::uint64_t length = LittleEndian(std::string_view(bytes).substr(kVersionEnd, is_long ? 4 : 2));
  const std::size_t begin = kVersionEnd + (is_long ? 4 : 2);
  if (length > bytes.size() - begin) throw Error("{}: is cut short; copy it again", where);
  const NpyHeader header(std::string_view(bytes).substr(begin, length), where);
  const std::string_view type = header.Between("'descr'", '\'', '\''),
                         shape = header.Between("'shape'", '(', ')');
  const bool by_columns = header.ByColumns();
  const auto sides = Sides(shape);
  if (!sides)
    throw Error("{}: an array of shape ({}); one or two dimensions are supported", where,
                shape.substr(0, kMostShown));
  if (type != "<f8" && type != "<f4" && type != ">f8" && type != ">f4")
    throw Error(
        "{}: numbers of type '{}'; 4 and 8 byte floating point is supported: numpy.save(..., "
        "array.astype('f8'))",
        where, type.substr(0, kMostShown));
  const auto [rows, cols] = *sides;
  if (rows == 0 || cols == 0) throw Error("{}: an array without numbers", where);
  const std::size_t each = type.ends_with('8') ? 8 : 4;
  const std::size_t held = (bytes.size() - begin - length) / each;
  if (rows > held / cols)
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
