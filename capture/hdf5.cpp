#include "capture/hdf5.hpp"

#include <algorithm>

namespace ferrule::hdf5 {
namespace {

constexpr hsize_t kChunk = 1024;            // rows
constexpr hsize_t kMostRows = 100'000'000;  // more is damage: a day at 1 kHz

void check(herr_t status, const std::string& what) {
  if (status < 0) throw FileTrouble(what);
}

void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

hid_t create_in_memory(const std::string& name) {
  silence();
  const std::string trouble = name + ": cannot be built";
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, trouble);
  check(H5Pset_fapl_core(access, 1 << 22, false), trouble);
  return H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
}

hid_t open_to_read(const std::string& name) {
  silence();
  return H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

hid_t stored_type(const Table& table) {
  return table.stored == Table::exact    ? H5T_IEEE_F64LE
         : table.stored == Table::single ? H5T_IEEE_F32LE
                                         : H5T_STD_I64LE;
}

}  // namespace

Writer::Writer(const std::string& name)
    : name_(name), file_(create_in_memory(name), H5Fclose, name + ": cannot be built") {}

Handle Writer::group(const std::string& path) const {
  return {H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
          trouble(path)};
}

void Writer::attribute(hid_t where, const char* key, const std::string& value) const {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, trouble(key));
  check(H5Tset_size(type, std::max<std::size_t>(1, value.size())), trouble(key));
  check(H5Tset_cset(type, H5T_CSET_UTF8), trouble(key));
  scalar(where, key, type, value.empty() ? "" : value.data());
}

void Writer::attribute(hid_t where, const char* key, double value) const {
  scalar(where, key, H5T_NATIVE_DOUBLE, &value);
}

void Writer::attribute(hid_t where, const char* key, std::int64_t value) const {
  scalar(where, key, H5T_NATIVE_INT64, &value);
}

void Writer::attribute(hid_t where, const char* key, std::uint64_t value) const {
  scalar(where, key, H5T_NATIVE_UINT64, &value);
}

Handle Writer::table(const Table& t) const {
  const auto rows = static_cast<hsize_t>(t.values.rows());
  const auto width = static_cast<hsize_t>(t.values.cols());
  const hsize_t size[2] = {rows, width};
  const hsize_t chunk[2] = {std::min(kChunk, std::max<hsize_t>(1, rows)), width};
  const int rank = t.flat ? 1 : 2;
  const Handle space(H5Screate_simple(rank, size, nullptr), H5Sclose, trouble(t.path));
  const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, trouble(t.path));
  check(H5Pset_chunk(how, rank, chunk), trouble(t.path));
  check(H5Pset_shuffle(how), trouble(t.path));
  check(H5Pset_deflate(how, 3), trouble(t.path));
  Handle set(
      H5Dcreate2(file_, t.path.c_str(), stored_type(t), space, H5P_DEFAULT, how, H5P_DEFAULT),
      H5Dclose, trouble(t.path));
  check(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, t.values.data()),
        trouble(t.path));
  attribute(set, "unit", t.unit);
  attribute(set, "columns", t.columns);
  return set;
}

std::string Writer::image() const {
  const std::string trouble = name_ + ": cannot be built";
  check(H5Fflush(file_, H5F_SCOPE_GLOBAL), trouble);
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  if (size < 0) throw FileTrouble(trouble);
  std::string image(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(file_, image.data(), image.size()) < 0) throw FileTrouble(trouble);
  return image;
}

std::string Writer::trouble(const std::string& path) const {
  return name_ + ": cannot be written (at " + path + "; is the disk full?)";
}

void Writer::scalar(hid_t where, const char* key, hid_t type, const void* value) const {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, trouble(key));
  const Handle made(H5Acreate2(where, key, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                    trouble(key));
  check(H5Awrite(made, type, value), trouble(key));
}

Reader::Reader(const std::string& name, std::string what)
    : name_(name),
      what_(std::move(what)),
      file_(open_to_read(name), H5Fclose, name + ": not a readable HDF5 file") {}

std::string Reader::text(const char* key, const char* place) const {
  const Handle a = open_attribute(key, place);
  const Handle type(H5Aget_type(a), H5Tclose, trouble(key));
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
    throw FileTrouble(trouble(key));
  std::string value(H5Tget_size(type), '\0');
  check(H5Aread(a, type, value.data()), trouble(key));
  while (!value.empty() && value.back() == '\0') value.pop_back();
  return value;
}

double Reader::number(const char* key, const char* place) const {
  double value = 0;
  check(H5Aread(open_attribute(key, place), H5T_NATIVE_DOUBLE, &value), trouble(key));
  return value;
}

std::uint64_t Reader::whole(const char* key) const {
  std::uint64_t value = 0;
  check(H5Aread(open_attribute(key, "/"), H5T_NATIVE_UINT64, &value), trouble(key));
  return value;
}

Matrix Reader::table(const std::string& path, int width, Eigen::Index count) const {
  const Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose,
                   name_ + ": damaged: " + path + " is missing");
  const Handle space(H5Dget_space(set), H5Sclose, trouble(path));
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t size[2] = {0, 1};
  if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space, size, nullptr) < 0 ||
      size[1] != static_cast<hsize_t>(width) || size[0] > kMostRows)
    throw FileTrouble(name_ + ": damaged: " + path + " has the wrong shape");
  if (count >= 0 && static_cast<Eigen::Index>(size[0]) != count)
    throw FileTrouble(name_ + ": damaged: " + path + " has " + std::to_string(size[0]) +
                      " rows, not " + std::to_string(count));
  Matrix values(static_cast<Eigen::Index>(size[0]), width);
  // Chunk by chunk, so that damage is found where it is.
  for (hsize_t from = 0; from < size[0]; from += kChunk) {
    const hsize_t start[2] = {from, 0};
    const hsize_t extent[2] = {std::min(kChunk, size[0] - from), size[1]};
    const Handle memory(H5Screate_simple(rank, extent, nullptr), H5Sclose, trouble(path));
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, extent, nullptr),
          trouble(path));
    check(H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT,
                  values.row(static_cast<Eigen::Index>(from)).data()),
          name_ + ": damaged: " + path + " cannot be read at row " + std::to_string(from));
  }
  return values;
}

std::string Reader::trouble(const std::string& key) const {
  return name_ + ": not " + what_ + ", or damaged (at " + key + ")";
}

Handle Reader::open_attribute(const char* key, const char* place) const {
  return {H5Aopen_by_name(file_, place, key, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
          trouble(std::string("attribute ") + key)};
}

}  // namespace ferrule::hdf5
