// A hash of a file's bytes, to tell whether it is the one that was meant. Not a protection against
// someone who wants to deceive.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace ferrule {

// SHA-1 of bytes that come in pieces.
class Sha1 {
 public:
  Sha1();
  ~Sha1();
  void add(const void* bytes, std::size_t size);
  // 40 hexadecimal digits, as sha1sum prints them. The last call.
  std::string text();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha1(const std::string& bytes);
// Of a file, a piece of which is in memory at a time. Throws FileTrouble as read_text.
std::string sha1_of_file(const std::string& file);

}  // namespace ferrule
