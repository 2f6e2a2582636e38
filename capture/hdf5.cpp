#include "capture/hdf5.hpp"

#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>

namespace ferrule::hdf5 {
namespace {

constexpr hsize_t kMostRows = 100'000'000;  // more is damage: a day at 1 kHz
constexpr hsize_t kMostChunk = 1 << 22;     // numbers
constexpr hsize_t kMostDeflated = 1032;     // bytes from one
constexpr std::size_t kMostNames = 1000;    // of objects, and of the attributes of one
constexpr std::size_t kMostAttribute =
    60'000;  // bytes in an attribute itself; HDF5 takes 64 kB less
             // what it says of it

void check(herr_t status, const std::string& what) {
  if (status < 0) throw FileTrouble(what);
}

void silence() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

hid_t create(const std::string& path, const std::string& trouble) {
  silence();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, trouble);
  check(H5Pset_file_locking(access, false, true), trouble);  // whoever made it holds its lock
  const Handle how(H5Pcreate(H5P_FILE_CREATE), H5Pclose, trouble);
  check(H5Pset_obj_track_times(how, false), trouble);
  return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, how, access);
}

// Nothing of another file or library comes in: no filter, no link, no data from there.
hid_t open_to_read(const MappedFile& file) {
  silence();
  H5PLset_loading_state(0);
  H5Lunregister(H5L_TYPE_EXTERNAL);
  return H5LTopen_file_image(const_cast<char*>(file.data()), file.size(),
                             H5LT_FILE_IMAGE_DONT_COPY | H5LT_FILE_IMAGE_DONT_RELEASE);
}

hid_t stored_type(Table::Stored stored) {
  return stored == Table::exact    ? H5T_IEEE_F64LE
         : stored == Table::single ? H5T_IEEE_F32LE
                                   : H5T_STD_I64LE;
}

std::string cannot_be_built(const std::string& name, const std::string& path) {
  return name + ": cannot be built (at " + path + ")";
}

// What an attempt to write to the disk came to.
void check_written(herr_t status, const std::string& name) {
  if (status < 0) throw FileTrouble(name + ": cannot be written: " + std::strerror(errno));
}

// Texts as HDF5 holds them: one after the other, each as long as the longest.
struct Packed {
  Packed(const std::vector<std::string>& texts, const std::string& trouble)
      : type(H5Tcopy(H5T_C_S1), H5Tclose, trouble), space(create(texts.size()), H5Sclose, trouble) {
    std::size_t size = 1;
    for (const std::string& text : texts) size = std::max(size, text.size());
    check(H5Tset_size(type, size), trouble);
    check(H5Tset_cset(type, H5T_CSET_UTF8), trouble);
    for (std::string text : texts) {
      text.resize(size);
      bytes += text;
    }
  }
  static hid_t create(hsize_t count) { return H5Screate_simple(1, &count, nullptr); }
  const void* data() const noexcept { return bytes.data(); }
  bool fits_attribute() const noexcept { return bytes.size() <= kMostAttribute; }

  Handle type, space;
  std::string bytes;
};

// Texts of any length: an attribute holds where they are in the file's heap.
struct InHeap {
  InHeap(const std::vector<std::string>& texts, const std::string& trouble)
      : type(H5Tcopy(H5T_C_S1), H5Tclose, trouble) {
    check(H5Tset_size(type, H5T_VARIABLE), trouble);
    check(H5Tset_cset(type, H5T_CSET_UTF8), trouble);
    for (const std::string& text : texts) starts.push_back(text.c_str());
  }
  const void* data() const noexcept { return starts.data(); }

  Handle type;
  std::vector<const char*> starts;
};

void write_attribute(hid_t where, const std::string& key, const Json& value,
                     const std::string& trouble) {
  const auto write = [&](hid_t space, hid_t type, const void* bytes) {
    const Handle made(H5Acreate2(where, key.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                      H5Aclose, trouble);
    check(H5Awrite(made, type, bytes), trouble);
  };
  const Handle one(H5Screate(H5S_SCALAR), H5Sclose, trouble);
  const auto scalar = [&](hid_t type, const void* bytes) { write(one, type, bytes); };
  if (value.is_string() || value.is_array()) {
    const std::vector<std::string> texts = value.is_string()
                                               ? std::vector{value.get<std::string>()}
                                               : value.get<std::vector<std::string>>();
    const Packed packed(texts, trouble);
    const InHeap in_heap(texts, trouble);
    const hid_t space = value.is_string() ? one : packed.space;
    if (packed.fits_attribute())
      write(space, packed.type, packed.data());
    else
      write(space, in_heap.type, in_heap.data());
  } else if (value.is_number_float()) {
    const double number = value;
    scalar(H5T_NATIVE_DOUBLE, &number);
  } else if (value.is_number_unsigned()) {
    const std::uint64_t number = value;
    scalar(H5T_NATIVE_UINT64, &number);
  } else {
    const std::int64_t number = value;
    scalar(H5T_NATIVE_INT64, &number);
  }
}

Handle create_table(hid_t file, const Table& t, Eigen::Index count, const std::string& trouble) {
  const hsize_t size[2] = {static_cast<hsize_t>(count), static_cast<hsize_t>(t.width)};
  const hsize_t chunk[2] = {std::clamp<hsize_t>(size[0], 1, kChunk), 1};
  const int rank = t.flat ? 1 : 2;
  const Handle space(H5Screate_simple(rank, size, nullptr), H5Sclose, trouble);
  const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, trouble);
  check(H5Pset_obj_track_times(how, false), trouble);
  check(H5Pset_chunk(how, rank, chunk), trouble);
  check(H5Pset_shuffle(how), trouble);
  check(H5Pset_deflate(how, 1), trouble);  // more takes longer and gains a hundredth
  return Handle(
      H5Dcreate2(file, t.path.c_str(), stored_type(t.stored), space, H5P_DEFAULT, how, H5P_DEFAULT),
      H5Dclose, trouble);
}

// Selects `rows` rows from `first` on in a table's space; where they are in memory.
Handle select_rows(hid_t space, Eigen::Index first, Eigen::Index rows, Eigen::Index width,
                   const std::string& trouble) {
  const hsize_t start[2] = {static_cast<hsize_t>(first), 0};
  const hsize_t extent[2] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(width)};
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, extent, nullptr), trouble);
  return Handle(H5Screate_simple(H5Sget_simple_extent_ndims(space), extent, nullptr), H5Sclose,
                trouble);
}

void write_rows(hid_t set, Eigen::Index first, const Matrix& values, const std::string& name) {
  const Handle space(H5Dget_space(set), H5Sclose, name);
  const Handle memory = select_rows(space, first, values.rows(), values.cols(), name);
  check_written(H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()), name);
}

void write_labels(hid_t file, const Labels& labels, const std::string& trouble) {
  const Packed texts(labels.texts, trouble);
  const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, trouble);
  check(H5Pset_obj_track_times(how, false), trouble);
  const Handle set(
      H5Dcreate2(file, labels.path.c_str(), texts.type, texts.space, H5P_DEFAULT, how, H5P_DEFAULT),
      H5Dclose, trouble);
  check(H5Dwrite(set, texts.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.bytes.data()), trouble);
}

// The dimensions' scales, which netCDF and xarray name them by.
void attach_scales(hid_t file, const Content& content, const std::string& name) {
  for (const Table& table : content.tables)
    for (std::size_t dimension = 0; dimension < table.scales.size(); ++dimension) {
      const std::string& path = table.scales[dimension];
      const std::string trouble = cannot_be_built(name, path);
      const Handle set(H5Dopen2(file, table.path.c_str(), H5P_DEFAULT), H5Dclose, trouble);
      const Handle scale(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, trouble);
      if (H5DSis_scale(scale) == 0)
        check(H5DSset_scale(scale, path.substr(path.rfind('/') + 1).c_str()), trouble);
      check(H5DSattach_scale(set, scale, static_cast<unsigned>(dimension)), trouble);
    }
}

using Names = std::map<std::string, std::set<std::string>>;

herr_t add_attribute(hid_t, const char* name, const H5A_info_t*, void* names) {
  constexpr std::array kOfScales = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"};
  if (std::find(kOfScales.begin(), kOfScales.end(), std::string(name)) == kOfScales.end())
    static_cast<std::set<std::string>*>(names)->insert(name);
  return static_cast<std::set<std::string>*>(names)->size() > kMostNames;
}

// Called for every object once, whatever the links.
herr_t add_object(hid_t root, const char* name, const H5O_info_t*, void* names) {
  auto& all = *static_cast<Names*>(names);
  const std::string path = name == std::string(".") ? "/" : "/" + std::string(name);
  const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
  if (object < 0 || all.size() > kMostNames) return -1;
  const herr_t status =
      H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, add_attribute, &all[path]);
  H5Oclose(object);
  return status;
}

}  // namespace

void write(const std::string& path, const std::string& name, const Content& content,
           const std::function<std::vector<Matrix>()>& next) {
  const hid_t created = create(path, cannot_be_built(name, "/"));
  check_written(created < 0 ? -1 : 0, name);
  Handle file(created, H5Fclose, name);
  const auto is_table = [&](const std::string& place) {
    const auto at = [&](const auto& t) { return t.path == place; };
    return std::any_of(content.tables.begin(), content.tables.end(), at) ||
           std::any_of(content.labels.begin(), content.labels.end(), at);
  };
  for (const auto& [place, _] : content.attributes) {
    if (place == "/" || is_table(place)) continue;
    const std::string trouble = cannot_be_built(name, place);
    const Handle how(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, trouble);
    check(H5Pset_obj_track_times(how, false), trouble);
    const Handle group(H5Gcreate2(file, place.c_str(), H5P_DEFAULT, how, H5P_DEFAULT), H5Gclose,
                       trouble);
  }
  std::vector<Handle> tables;
  for (const Table& table : content.tables)
    tables.push_back(create_table(file, table, content.rows, cannot_be_built(name, table.path)));
  for (const Labels& labels : content.labels)
    write_labels(file, labels, cannot_be_built(name, labels.path));
  attach_scales(file, content, name);
  for (const auto& [place, attributes] : content.attributes) {
    const std::string trouble = cannot_be_built(name, place);
    const Handle object(H5Oopen(file, place.c_str(), H5P_DEFAULT), H5Oclose, trouble);
    for (const auto& [key, value] : attributes) write_attribute(object, key, value, trouble);
  }
  for (Eigen::Index first = 0; first < content.rows; first += kChunk) {
    const std::vector<Matrix> values = next();
    for (std::size_t i = 0; i < tables.size(); ++i) write_rows(tables[i], first, values[i], name);
  }
  check_written(H5Fflush(file, H5F_SCOPE_GLOBAL), name);
  tables.clear();
  file.close(name + ": cannot be written");
}

Reader::Reader(const MappedFile& bytes, std::string what)
    : bytes_(bytes),
      what_(std::move(what)),
      file_(open_to_read(bytes), H5Fclose, bytes.name() + ": not a readable HDF5 file") {}

namespace {

// Texts of a type of HDF5, `count` of them, as `read` fills them in.
std::vector<std::string> read_texts(hid_t type, hid_t space, std::size_t count, std::size_t most,
                                    const std::function<herr_t(void*)>& read,
                                    const std::string& damaged) {
  std::vector<std::string> texts;
  const std::size_t size = H5Tget_size(type);
  if (count > most || size == 0 || size > most || count * size > most) throw FileTrouble(damaged);
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> pointers(count, nullptr);
    check(read(pointers.data()), damaged);
    for (const char* text : pointers)
      texts.emplace_back(text ? std::string(text, ::strnlen(text, most)) : std::string());
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    return texts;
  }
  std::string bytes(count * size, '\0');
  check(read(bytes.data()), damaged);
  for (std::size_t i = 0; i < count; ++i) {
    texts.push_back(bytes.substr(i * size, size));
    texts.back().resize(texts.back().find_last_not_of('\0') + 1);
  }
  return texts;
}

// How many there are along the one dimension of `space`; empty where it has another shape.
std::optional<std::size_t> length_of(hid_t space) {
  hsize_t count = 0;
  if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != 1 ||
      H5Sget_simple_extent_dims(space, &count, nullptr) < 0)
    return std::nullopt;
  return count;
}

}  // namespace

Json Reader::attribute(const std::string& key, const std::string& place) const {
  const std::string damaged = trouble("attribute " + key);
  const Handle a(H5Aopen_by_name(file_, place.c_str(), key.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                 H5Aclose, damaged);
  const Handle space(H5Aget_space(a), H5Sclose, damaged);
  const Handle type(H5Aget_type(a), H5Tclose, damaged);
  const H5T_class_t kind = H5Tget_class(type);
  const std::size_t size = H5Tget_size(type);
  const auto read = [&](void* into) { return H5Aread(a, type, into); };
  const std::optional<std::size_t> length = length_of(space);
  if (length && kind == H5T_STRING)
    return read_texts(type, space, *length, bytes_.size(), read, damaged);
  if (H5Sget_simple_extent_type(space) != H5S_SCALAR || size == 0 || size > bytes_.size())
    throw FileTrouble(damaged);
  if (kind == H5T_STRING) return read_texts(type, space, 1, bytes_.size(), read, damaged).front();
  if (size > sizeof(double)) throw FileTrouble(damaged);
  if (kind == H5T_FLOAT) {
    double value = 0;
    check(H5Aread(a, H5T_NATIVE_DOUBLE, &value), damaged);
    return value;
  }
  if (kind != H5T_INTEGER) throw FileTrouble(damaged);
  if (H5Tget_sign(type) == H5T_SGN_NONE) {
    std::uint64_t value = 0;
    check(H5Aread(a, H5T_NATIVE_UINT64, &value), damaged);
    return value;
  }
  std::int64_t value = 0;
  check(H5Aread(a, H5T_NATIVE_INT64, &value), damaged);
  return value;
}

std::string Reader::text(const char* key) const {
  const Json value = attribute(key);
  if (!value.is_string()) throw FileTrouble(trouble(key));
  return value;
}

double Reader::number(const char* key) const {
  const Json value = attribute(key);
  if (!value.is_number()) throw FileTrouble(trouble(key));
  return value;
}

std::uint64_t Reader::whole(const char* key) const {
  const Json value = attribute(key);
  if (!value.is_number_integer() || value < 0) throw FileTrouble(trouble(key));
  return value;
}

namespace {

// What another library compressed by a filter of its own is whole, but cannot be read.
void expect_filters(hid_t how, const std::string& place) {
  const int filters = H5Pget_nfilters(how);
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, settings = 0;
    std::size_t values = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t filter = H5Pget_filter2(how, static_cast<unsigned>(i), &flags, &values,
                                               nullptr, name.size() - 1, name.data(), &settings);
    if (filter < 0 || H5Zfilter_avail(filter) > 0) continue;
    throw FileTrouble(place + " is compressed by the filter " + std::to_string(filter) + " (" +
                      printable(name.data()) +
                      "), which is missing here: write it again with gzip");
  }
}

}  // namespace

// What the file says of a data set must fit into the file. Returns the rows of a chunk.
hsize_t Reader::expect_room(hid_t set, hsize_t rows, hsize_t width, const std::string& path) const {
  const std::string damaged = bytes_.name() + ": damaged: " + path;
  const Handle how(H5Dget_create_plist(set), H5Pclose, damaged);
  expect_filters(how, bytes_.name() + ": " + path);
  const H5D_layout_t layout = H5Pget_layout(how);
  if (H5Pget_external_count(how) != 0 || layout == H5D_VIRTUAL || layout < 0)
    throw FileTrouble(damaged + " has its numbers elsewhere");
  hsize_t chunk[2] = {1, 1};
  const int rank = layout == H5D_CHUNKED ? H5Pget_chunk(how, 2, chunk) : 1;
  if (rank < 1 || rank > 2 || chunk[0] > kMostChunk || chunk[1] > kMostChunk ||
      chunk[0] * chunk[1] > kMostChunk)
    throw FileTrouble(damaged + " has chunks larger than any that are read here");
  // No data set has fewer bytes than rows, nor is compressed by more than deflate can.
  const hsize_t stored = H5Dget_storage_size(set);
  if (rows > bytes_.size() || stored > bytes_.size() ||
      rows * width * sizeof(float) > kMostDeflated * (stored + 64))
    throw FileTrouble(damaged + " claims " + std::to_string(rows) +
                      " rows, more than are in the file");
  return layout == H5D_CHUNKED ? chunk[0] : std::max<hsize_t>(1, rows);
}

StoredTable Reader::table(const std::string& path, Eigen::Index width, Eigen::Index count) const {
  const std::string damaged = bytes_.name() + ": damaged: " + path;
  StoredTable stored(
      Handle(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, damaged + " is missing"), bytes_,
      damaged);
  Table& table = stored.table_;
  table.path = path;
  table.width = width;
  const int rank = H5Sget_simple_extent_ndims(stored.space_);
  hsize_t size[2] = {0, 1};
  if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(stored.space_, size, nullptr) < 0 ||
      size[1] != static_cast<hsize_t>(width) || size[0] > kMostRows)
    throw FileTrouble(damaged + " has the wrong shape");
  if (count >= 0 && static_cast<Eigen::Index>(size[0]) != count)
    throw FileTrouble(damaged + " has " + std::to_string(size[0]) + " rows, not " +
                      std::to_string(count));
  constexpr Table::Stored kinds[] = {Table::exact, Table::single, Table::whole};
  const auto* const kind = std::find_if(std::begin(kinds), std::end(kinds), [&](auto of) {
    return H5Tequal(stored.type_, stored_type(of)) > 0;
  });
  if (kind == std::end(kinds)) throw FileTrouble(damaged + " has numbers of another type");
  table.stored = *kind;
  table.flat = rank == 1;
  stored.rows_ = static_cast<Eigen::Index>(size[0]);
  stored.chunk_ = static_cast<Eigen::Index>(expect_room(stored.set_, size[0], size[1], path));
  return stored;
}

StoredTable::StoredTable(Handle set, const MappedFile& bytes, const std::string& damaged)
    : bytes_(&bytes),
      set_(std::move(set)),
      space_(H5Dget_space(set_), H5Sclose, damaged),
      type_(H5Dget_type(set_), H5Tclose, damaged),
      damaged_(damaged) {}

Matrix StoredTable::read(Eigen::Index first, Eigen::Index count) const {
  Matrix values(count, table_.width);
  // Chunk by chunk, so that damage is found where it is.
  for (Eigen::Index from = first; from < first + count;) {
    const Eigen::Index rows = std::min(chunk_ - from % chunk_, first + count - from);
    const std::string damaged = damaged_ + " cannot be read at row " + std::to_string(from);
    const Handle memory = select_rows(space_, from, rows, table_.width, damaged);
    check(H5Dread(set_, H5T_NATIVE_DOUBLE, memory, space_, H5P_DEFAULT,
                  values.row(from - first).data()),
          damaged);
    from += rows;
  }
  bytes_->forget();
  return values;
}

std::vector<std::string> Reader::labels(const std::string& path) const {
  const std::string damaged = bytes_.name() + ": damaged: " + path;
  const Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose, damaged + " is missing");
  const Handle space(H5Dget_space(set), H5Sclose, damaged);
  const Handle type(H5Dget_type(set), H5Tclose, damaged);
  const std::optional<std::size_t> count = length_of(space);
  if (!count || H5Tget_class(type) != H5T_STRING) throw FileTrouble(damaged + " holds no texts");
  expect_room(set, *count, 1, path);
  return read_texts(
      type, space, *count, bytes_.size(),
      [&](void* into) { return H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, into); }, damaged);
}

Names Reader::names() const {
  Names all;
  check(H5Ovisit(file_, H5_INDEX_NAME, H5_ITER_INC, add_object, &all), trouble("its objects"));
  return all;
}

std::string Reader::trouble(const std::string& key) const {
  return bytes_.name() + ": not " + what_ + ", or damaged (at " + key + ")";
}

}  // namespace ferrule::hdf5
