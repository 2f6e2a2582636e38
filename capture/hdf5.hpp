// HDF5's C library with handles that close themselves and errors that are FileTrouble.
// Files are built in memory, so that a disk that fills up meets plain writes and not HDF5 half way
// through a file. HDF5's own messages on stderr are off.
#pragma once

#include <hdf5.h>

#include <Eigen/Core>
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

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// One data set, with its attributes `unit` and `columns`.
struct Table {
  std::string path;
  Matrix values;
  std::string unit, columns;
  enum { exact, single, whole } stored = exact;  // float64, float32, int64
  bool flat = false;                             // (N) and not (N, 1)
};

// A file in memory. Throws FileTrouble.
class Writer {
 public:
  explicit Writer(const std::string& name);  // of the file that it becomes, for messages

  hid_t root() const noexcept { return file_; }
  Handle group(const std::string& path) const;
  Handle table(const Table& table) const;  // compressed by chunks of rows
  void attribute(hid_t where, const char* key, const std::string& value) const;
  void attribute(hid_t where, const char* key, double value) const;
  void attribute(hid_t where, const char* key, std::int64_t value) const;
  void attribute(hid_t where, const char* key, std::uint64_t value) const;
  // Its bytes.
  std::string image() const;

 private:
  std::string trouble(const std::string& path) const;
  void scalar(hid_t where, const char* key, hid_t type, const void* value) const;

  std::string name_;
  Handle file_;
};

// A file on disk. Throws FileTrouble, naming what is damaged.
class Reader {
 public:
  // `what` the file should be: "an episode".
  Reader(const std::string& name, std::string what);

  bool has(const char* key) const { return H5Aexists(file_, key) > 0; }
  std::string text(const char* key, const char* place = "/") const;
  double number(const char* key, const char* place = "/") const;
  std::uint64_t whole(const char* key) const;
  // A data set of `width` columns and `count` rows, or any number of rows where `count` is -1.
  Matrix table(const std::string& path, int width, Eigen::Index count) const;

 private:
  std::string trouble(const std::string& key) const;
  Handle open_attribute(const char* key, const char* place) const;

  std::string name_, what_;
  Handle file_;
};

}  // namespace ferrule::hdf5
