// Checks and parses values of options (numbers, names, colours); formats keys for the end of a help text.
#pragma once

#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "render/display/plain_panels.h"

namespace ulf::commands {

// Accept finite numbers above 0, or from 0 on, with shorter messages than CLI11's own validators.
CLI::Validator Positive();
CLI::Validator NonNegative();

// Lists an option's values for help and shell completion, as in "auto,plane,plane:SHARE,FILE". Completion
// offers those of lower-case letters, digits and hyphens, and files if FILE is last. Values are not checked.
CLI::Option* OfferValues(CLI::Option* option, const std::string& values);

inline constexpr char kKnownFields[] = "auto,subdivision,linear,lumigraph,lumigraph-per-pixel,soft,nearest";
inline constexpr char kKnownProxies[] = "auto,plane,plane:SHARE,plane:fitted,planes,points,mesh,soft,FILE";

// Returns a line for each key, each with a line feed before it.
std::string KeyLines(std::span<const render::KeyHelp> keys);

// Parses "white", "black", or "R,G,B" from 0 to 255. Returns B, G, R from 0 to 1 in display encoding. Throws
// UsageError that names --background.
cv::Vec3d BackgroundFromText(const std::string& text);

}  // namespace ulf::commands
