// Makes what every table and picture of docs/measured/ says about itself.
#pragma once

#include <string>

namespace ulf::test {

// If this environment variable is set, a tree with changes may be measured, and its commit gets a "+".
inline constexpr char kMeasureChanged[] = "ULF_MEASURE_CHANGED";

// Returns a line with the command, the machine's processors, the date (UTC) and the commit. Throws Error
// where files other than pages differ from the commit, so that nobody could make the same again.
std::string Provenance(const std::string& command);

// Returns what follows the command and the first kBetween; empty if there is none.
std::string WithoutCommand(const std::string& provenance);
inline const std::string kBetween = "  ·  ";

// Puts `text` into the file `page` between the marks `<!-- NAME -->` and `<!-- /NAME -->`; if it has no
// marks, they are added at its end. Throws Error when the page cannot be written.
void ReplacePart(const std::string& page, const std::string& name, const std::string& text);

}  // namespace ulf::test
