// Tests call the things of every floor by their plain names.
#pragma once

namespace ulf {

namespace acquisition {}
namespace tracking {}
namespace render {}
namespace coverage {}
namespace commands {}

using namespace acquisition;
using namespace tracking;
using namespace render;
using namespace coverage;
using namespace commands;

}  // namespace ulf
