// Work on a file of strangers, in a child process: where it crashes, hangs or takes too much
// memory, that is a FileTrouble of one line here, and nothing else happens.
//
// A library that was not written for hostile files (HDF5) can be brought to any of the three by
// some changed bytes. The child only reads files and computes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sim/base/child_process.hpp"

namespace ferrule {

class Child {
 public:
  // What the work sends to its parent, and what it may take.
  class Parent {
   public:
    explicit Parent(int fd) : fd_(fd) {}
    // Ends the child where the parent is gone.
    void send(const void* data, std::size_t size) noexcept;
    // Says why there is nothing to send.
    void refuse(char answer, const std::string& why) noexcept;
    // More memory [bytes] and time [s] than at first: kMemory, kTime.
    static void allow(std::size_t memory, std::size_t time) noexcept;

   private:
    int fd_;
    bool began_ = false;
  };
  static constexpr std::size_t kMemory = 256 << 20;  // beyond what the parent has [bytes]
  static constexpr std::size_t kTime = 1;            // of a processor [s]

  // Starts `work` on `file`. Throws what it throws before it sends anything, BadInput or
  // FileTrouble; and FileTrouble where it ends otherwise.
  Child(std::string file, const std::function<void(Parent&)>& work);
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  // The next bytes that it sends. Throws FileTrouble where there are fewer.
  void receive(void* data, std::size_t size);

 private:
  void first_answer();
  std::size_t take(void* data, std::size_t size) noexcept;
  [[noreturn]] void damaged();

  std::string file_;
  int fd_ = -1;
  std::optional<ChildProcess> process_;
};

}  // namespace ferrule
