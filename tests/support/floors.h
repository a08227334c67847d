// Makes the names of every floor known in namespace ulf, so that tests write them without the floor's name.
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
