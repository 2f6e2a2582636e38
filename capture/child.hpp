// Work with HDF5, in a child process: where it crashes, hangs or takes too much memory, that is a
// FileTrouble of one line here, and nothing else happens.
//
// A library that was not written for hostile files can be brought to any of the three by some
// changed bytes; and one whose disk filled up half way through a file cannot be closed any more.
// The child that reads a stranger's file only reads files and computes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "sim/base/child_process.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

class Child {
 public:
  // What the work sends to its parent, and what it may take.
  class Parent {
   public:
    explicit Parent(int fd) : fd_(fd) {}
    // Ends the child where the parent is gone.
    void send(const void* data, std::size_t size) noexcept;
    void send_json(const Json& json) noexcept;
    // Says why there is no more to send.
    void refuse(char answer, const std::string& why) noexcept;
    // More memory [bytes] and time [s] than at first: kMemory, kTime.
    static void allow(std::size_t memory, std::size_t time) noexcept;

   private:
    int fd_;
  };
  static constexpr std::size_t kMemory = 256 << 20;  // beyond what the parent has [bytes]
  static constexpr std::size_t kTime = 1;            // of a processor [s]

  enum class Work { reads, writes };  // one that writes has no limits

  // Starts `work` on `file`. Throws FileTrouble where no process can be started.
  Child(std::string file, Work kind, const std::function<void(Parent&)>& work);
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  // The next bytes, in the pieces that it sends. Throws what it throws instead, BadInput or
  // FileTrouble; and FileTrouble where it ends otherwise.
  void receive(void* data, std::size_t size);
  Json receive_json();

 private:
  std::size_t take(void* data, std::size_t size) noexcept;
  [[noreturn]] void broken();

  std::string file_;
  Work kind_;
  int fd_ = -1;
  std::optional<ChildProcess> process_;
};

}  // namespace ferrule
