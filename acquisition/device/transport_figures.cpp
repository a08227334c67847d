#include "acquisition/device/transport_figures.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace ulf::acquisition {
namespace {

struct FigureKind {
  const char* name;
  bool counts;
};
// These are in the order of TransportFigure.
constexpr std::array kFigureKinds{
    FigureKind{"MB/s of pixels", false},
    FigureKind{"frames completed", true},
    FigureKind{"frames failed", true},
    FigureKind{"frames timed out", true},
    FigureKind{"frames aborted", true},
    FigureKind{"frames missing (library)", true},
    FigureKind{"size mismatches", true},
    FigureKind{"underruns", true},
    FigureKind{"packets received", true},
    FigureKind{"packets missing", true},
    FigureKind{"resend requests", true},
    FigureKind{"packets resent", true},
    FigureKind{"resend limit reached", true},
    FigureKind{"resends given up", true},
    FigureKind{"packets twice", true},
    FigureKind{"packets with errors", true},
    FigureKind{"packets ignored", true},
    FigureKind{"bytes received", true},
    FigureKind{"bytes ignored", true},
    FigureKind{"buffers", false},
    FigureKind{"payload (bytes)", false},
    FigureKind{"frames a second set", false},
    FigureKind{"throughput limit (bytes/s)", false},
    FigureKind{"real-time priority", false},
    FigureKind{"high priority", false},
    FigureKind{"packets refused", true},
    FigureKind{"packet size", false},
    FigureKind{"packet size negotiated", false},
    FigureKind{"packet delay (ns)", false},
    FigureKind{"resend on", false},
    FigureKind{"packet timeout (ms)", false},
    FigureKind{"frame retention (ms)", false},
    FigureKind{"socket buffer asked for (bytes)", false},
    FigureKind{"socket buffer (bytes)", false},
    FigureKind{"IEEE 1588 locked", false},
    FigureKind{"IEEE 1588 offset (ns)", false},
    FigureKind{"exposure (us)", false},
    FigureKind{"frames with wrong packet ids", true},
    FigureKind{"frames while settling", true},
    FigureKind{"photographs", true},
    FigureKind{"photographs not downloaded", true},
    FigureKind{"live view refused", true},
    FigureKind{"release to announcement ms", false},
};
static_assert(kFigureKinds.size() == static_cast<std::size_t>(TransportFigure::kReleaseToAnnouncementMs) + 1);

const FigureKind& KindOf(TransportFigure figure) { return kFigureKinds[static_cast<std::size_t>(figure)]; }

}  // namespace

const char* Name(TransportFigure figure) { return KindOf(figure).name; }

bool IsCount(TransportFigure figure) { return KindOf(figure).counts; }

std::optional<double> FigureIn(const TransportFigures& figures, TransportFigure figure) {
  for (const auto& [known, value] : figures)
    if (known == figure) return value;
  return std::nullopt;
}

void Add(const TransportFigures& later, TransportFigures& sum) {
  for (const auto& [figure, value] : later) {
    const auto same = std::ranges::find(sum, figure, &TransportFigures::value_type::first);
    if (same == sum.end())
      sum.emplace_back(figure, value);
    else
      same->second = IsCount(figure) ? same->second + value : value;
  }
}

}  // namespace ulf::acquisition
