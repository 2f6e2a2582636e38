// HDF5's C library with handles that close themselves and errors that are FileTrouble.
// To be used in a Child (capture/child.hpp): HDF5 may fail on a file that is damaged, and cannot
// close one whose disk is full. HDF5's own messages on stderr are off.
#pragma once

// HDF5 1.12 and later keep the functions of 1.10 under this name.
#define H5_USE_110_API
#include <hdf5.h>

#include <Eigen/Core>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "capture/mapped_file.hpp"
#include "sim/base/json_fields.hpp"

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
  // Where closing may fail.
  void close(const std::string& what) {
    if (close_(std::exchange(id_, -1)) < 0) throw FileTrouble(what);
  }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A data set of numbers, which come in blocks of rows.
struct Table {
  std::string path;
  Eigen::Index width;
  enum Stored { exact, single, whole } stored = exact;  // float64, float32, int64
  bool flat = false;                                    // (N) and not (N, 1)
  // Of each dimension the path of its scale, a table or labels; none where it has none.
  std::vector<std::string> scales{};
};

// A data set of texts: the names along a dimension.
struct Labels {
  std::string path;
  std::vector<std::string> texts;
};

// All that is in a file but the numbers. An attribute is a text, a list of texts, a double, or a
// whole number of 64 bits. Texts of more than 60 kB are of variable length, in the file's heap;
// HDF5 has no room for them in an attribute.
struct Content {
  // Of every group and data set, by its path; "/" is the root.
  std::map<std::string, std::map<std::string, Json>> attributes;
  Eigen::Index rows = 0;      // of every table
  std::vector<Table> tables;  // compressed column by column
  std::vector<Labels> labels;
};

// Rows of one column that are compressed together: the bytes of its numbers side by side compress
// better than those of whole rows.
inline constexpr Eigen::Index kChunk = 8192;

// Writes a file to `path`, always the same bytes; `name` is for messages. `next` is asked for the
// next kChunk rows of every table, in the order of content.tables, until there are all. Throws
// FileTrouble.
void write(const std::string& path, const std::string& name, const Content& content,
           const std::function<std::vector<Matrix>()>& next);

// A table of a file that is being read.
class StoredTable {
 public:
  const Table& table() const noexcept { return table_; }
  Eigen::Index rows() const noexcept { return rows_; }
  // Rows [first, first + count). Throws FileTrouble.
  Matrix read(Eigen::Index first, Eigen::Index count) const;

 private:
  friend class Reader;
  StoredTable(Handle set, const MappedFile& bytes, const std::string& damaged);

  const MappedFile* bytes_;
  Handle set_, space_, type_;
  std::string damaged_;
  Table table_{};
  Eigen::Index rows_ = 0, chunk_ = 1;
};

// A file on disk that anybody may have written: everything is checked before it is read, and no
// size is believed that the file cannot hold. Throws FileTrouble, naming what is damaged.
class Reader {
 public:
  // `what` the file should be: "an episode". `bytes` must outlive the reader and its tables.
  Reader(const MappedFile& bytes, std::string what);

  bool has(const char* key) const { return H5Aexists(file_, key) > 0; }
  // Texts may be of fixed or of variable length.
  Json attribute(const std::string& key, const std::string& place = "/") const;
  std::string text(const char* key) const;
  double number(const char* key) const;
  std::uint64_t whole(const char* key) const;
  // A data set of `width` columns and `count` rows, or any number of rows where `count` is -1.
  StoredTable table(const std::string& path, Eigen::Index width, Eigen::Index count) const;
  std::vector<std::string> labels(const std::string& path) const;
  // Of every group and data set by its path, the names of its attributes, but for those by which
  // dimensions know their scales.
  std::map<std::string, std::set<std::string>> names() const;

 private:
  std::string trouble(const std::string& key) const;
  hsize_t expect_room(hid_t set, hsize_t rows, hsize_t width, const std::string& path) const;

  const MappedFile& bytes_;
  std::string what_;
  Handle file_;
};

}  // namespace ferrule::hdf5
