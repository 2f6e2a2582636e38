// stdin, stdout and stderr as the program can rely on them.
#pragma once

namespace ferrule {

// A descriptor of them that is closed would be given to the first file that is opened: it is opened
// on /dev/null (of stdout, so that writing fails). What is written to stderr and cannot be is
// forgotten: a message that nobody reads ends nothing.
void secure_standard_streams();

// While one lives, nothing that is printed gets to standard output.
class MutedOutput {
 public:
  MutedOutput();
  ~MutedOutput();
  MutedOutput(const MutedOutput&) = delete;
  MutedOutput& operator=(const MutedOutput&) = delete;

 private:
  int before_;
};

}  // namespace ferrule
