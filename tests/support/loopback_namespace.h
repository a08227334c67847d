// A network of this process's own: the loopback interface and nothing else. Every GigE Vision camera listens
// on the one UDP port 3956, so two tests at once, or a test beside a real camera, would talk to each other's.
#pragma once

#include <optional>
#include <string>

namespace ulf::test {

// Moves this process (and what it starts) into a network namespace with loopback up; as an ordinary user by
// way of a user namespace. To be called before any thread is started. Returns why it cannot, where it is not
// allowed.
std::optional<std::string> EnterLoopbackNamespace();

}  // namespace ulf::test
