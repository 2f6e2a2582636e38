// HDF5's C library with handles that close themselves and errors that are FileTrouble.
// Used by capture/episode.cpp only.
#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

#include "sim/error.hpp"

namespace ferrule::hdf5 {

// An HDF5 identifier and the function that closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*closer)(hid_t), const std::string& what) : id_(id), close_(closer) {
    if (id < 0) throw FileTrouble(what);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const noexcept { return id_; }
  // For files: closing is where the last bytes are written.
  void close(const std::string& what) {
    if (close_(std::exchange(id_, -1)) < 0) throw FileTrouble(what);
  }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

inline void check(herr_t status, const std::string& what) {
  if (status < 0) throw FileTrouble(what);
}

}  // namespace ferrule::hdf5
