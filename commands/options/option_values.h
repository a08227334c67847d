// Checks and parses values of options: numbers, named values and colours; formats the lines of keys in a
// footer.
#pragma once

#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "render/display/plain_panels.h"

namespace ulf::commands {

// These validators have short messages instead of CLI11's range of 300 digits.
CLI::Validator Positive();
CLI::Validator NonNegative();

// Declares named values, as "auto,plane,plane:SHARE,FILE": completion offers those in small letters alone,
// and files if FILE stands last. Nothing is checked: other values are free text.
CLI::Option* OfferValues(CLI::Option* option, const std::string& values);

inline constexpr char kKnownFields[] = "auto,subdivision,linear,lumigraph,lumigraph-per-pixel,soft,nearest";
inline constexpr char kKnownProxies[] = "auto,plane,plane:SHARE,plane:fitted,planes,points,mesh,soft,FILE";

// Returns a line for each key, for a footer.
std::string KeyLines(std::span<const render::KeyHelp> keys);

// Parses "white", "black", or R,G,B from 0 to 255, to B G R from 0 to 1 in display encoding. Throws
// UsageError that names --background.
cv::Vec3d BackgroundFromText(const std::string& text);

}  // namespace ulf::commands
