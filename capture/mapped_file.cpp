#include "capture/mapped_file.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <cstring>
#include <filesystem>

#include "sim/base/content_hash.hpp"
#include "sim/base/error.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
namespace ipc = boost::interprocess;

ipc::mapped_region map(const std::string& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    throw FileTrouble(file + (fs::exists(file, error) ? ": is no file" : ": no such file"));
  try {
    const ipc::file_mapping opened(file.c_str(), ipc::read_only);
    // One without bytes cannot be mapped.
    return fs::is_empty(file, error) ? ipc::mapped_region()
                                     : ipc::mapped_region(opened, ipc::read_only);
  } catch (const ipc::interprocess_exception& why) {
    throw FileTrouble(file + ": cannot be read: " + std::strerror(why.get_native_error()));
  }
}

}  // namespace

MappedFile::MappedFile(const std::string& file) : name_(file), region_(map(file)) {}

// Not region_.advise(), which glibc takes no notice of.
void MappedFile::forget() const noexcept {
  ::madvise(region_.get_address(), size(), MADV_DONTNEED);
}

std::string MappedFile::sha1() const {
  constexpr std::size_t kPiece = 1 << 22;
  Sha1 hash;
  for (std::size_t first = 0; first < size(); first += kPiece) {
    hash.add(data() + first, std::min(kPiece, size() - first));
    forget();
  }
  return hash.text();
}

}  // namespace ferrule
