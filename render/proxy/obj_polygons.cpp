// Wavefront OBJ: reads "v x y z" and "f 1/2/3 -1 ..." and ignores everything else.
#include "core/base/error.h"
#include "core/light_field/points/ply_reader.h"
#include "render/proxy/polygon_soup.h"

namespace ulf::render {
namespace {

// Returns the next word of a line; empty at its end.
std::string_view NextWord(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

}  // namespace

PolygonSoup PolygonsFromObj(const std::string& bytes, const std::string& name) {
  PolygonSoup soup;
  std::size_t line_number = 0;
  const std::string_view text = bytes;
  std::string joined;  // for lines that end in a backslash
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++line_number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.ends_with('\\')) {
      joined += line.substr(0, line.size() - 1);
      joined += ' ';
      continue;
    }
    if (!joined.empty()) line = joined += line;
    const std::string_view key = NextWord(line);
    if (key == "v") {
      Eigen::Vector3d position;
      for (int i = 0; i < 3; ++i)
        if (!ParseNumber(NextWord(line), position[i]))
          throw Error("{}: line {}: a vertex needs three numbers", name, line_number);
      soup.vertices.push_back(position.cast<float>());
    } else if (key == "f") {
      std::uint32_t size = 0;
      for (std::string_view word = NextWord(line); !word.empty(); word = NextWord(line), ++size) {
        double number = 0;
        if (!ParseNumber(word.substr(0, word.find('/')), number))
          throw Error("{}: line {}: '{}' is not a corner of a face", name, line_number, word);
        const double count = static_cast<double>(soup.vertices.size());
        const double index = number < 0 ? count + number : number - 1;
        if (!(index >= 0 && index < count))
          throw Error("{}: line {}: a face names vertex {}, there are {} before it; the file is damaged",
                      name, line_number, word, soup.vertices.size());
        soup.corners.push_back(static_cast<std::uint32_t>(index));
      }
      soup.sizes.push_back(size);
    }
    joined.clear();
  }
  return soup;
}

}  // namespace ulf::render
