#include "tests/stability/curve.h"

namespace ulf::test {

std::vector<Curve> RenderCurves() { return {}; }

}  // namespace ulf::test
