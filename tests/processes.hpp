// Whether other processes run, for tests.
#pragma once

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

namespace ferrule::testing {

// What is gone, or has ended and is not waited for, does not.
inline bool runs(const std::string& process) {
  std::ifstream file("/proc/" + process + "/stat");
  std::string text;
  std::getline(file, text);
  return !process.empty() && !text.empty() && text.substr(text.rfind(')') + 2, 1) != "Z";
}

// The first line of a file that one of them writes; empty while there is none.
inline std::string told_in(const std::string& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

// Calls it until it is true, some ten seconds long.
template <class Is>
bool comes(const Is& is) {
  for (int n = 0; n < 1000 && !is(); ++n)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return is();
}

}  // namespace ferrule::testing
