// Runs another program, without a shell, and reads what it prints.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ulf {

// Returns the executable file of this name in the folders of the environment's PATH; empty if there is none.
std::filesystem::path ProgramInPath(const std::string& name);

struct ProgramEnd {
  int status = 0;        // the exit status, or 128 + the signal that ended the program
  bool stopped = false;  // it was killed, because `stop` asked for that
};

// Runs the program with these arguments to its end. It reads nothing, and what it prints to standard output
// and standard error goes to `take_line`, a line at a time without its end, and nowhere else. `stop`, which
// is asked several times a second, ends it at once. It is also killed when this thread ends, however that
// happens. Throws Error if no process can be made; an exception of `take_line` or `stop` kills the program.
ProgramEnd RunOtherProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           const std::function<void(const std::string& line)>& take_line,
                           const std::function<bool()>& stop);

}  // namespace ulf
